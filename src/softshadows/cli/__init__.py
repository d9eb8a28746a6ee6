"""The `softshadows` command: one file per group of commands."""

from softshadows.cli.app import main

__all__ = ["main"]
