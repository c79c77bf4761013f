"""``mien completion``: what a shell needs to complete commands, options and values."""

from __future__ import annotations

import argparse
from typing import Any

from mien.core.errors import MissingPartError

__all__ = ["add_command"]

SHELLS = ("bash", "zsh", "tcsh")


def add_command(commands: Any, parser: argparse.ArgumentParser) -> None:
    """Add it to the parser of ``mien``, which is what it writes out."""
    completion = commands.add_parser(
        "completion", help='shell completion: add eval "$(mien completion bash)" to the start file of your shell'
    )
    completion.add_argument("shell", choices=SHELLS)
    completion.set_defaults(run=lambda options: _print(parser, options.shell))


def _print(parser: argparse.ArgumentParser, shell: str) -> int:
    try:
        import shtab
    except ImportError as problem:
        raise MissingPartError("completion is written by shtab: pip install 'mien[completion]'") from problem
    print(shtab.complete(parser, shell))
    return 0
