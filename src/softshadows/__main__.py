"""`python -m softshadows` is the `softshadows` command."""

from softshadows.cli import main

main()
