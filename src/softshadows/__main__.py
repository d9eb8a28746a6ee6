"""`python -m softshadows` is the `softshadows` command."""

from softshadows.cli.app import main

main()
