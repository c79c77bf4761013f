"""The command line: argument parsing and progress bars only."""

from mien.cli.main import main

__all__ = ["main"]
