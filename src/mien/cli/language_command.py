"""``mien language check``: is a table of a language complete, and how exact is alignment in it?"""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add it to the parser of ``mien``."""
    language = commands.add_parser("language", help="check the table of a language with eSpeak NG's voice")
    actions = language.add_subparsers(required=True, metavar="ACTION")
    check = actions.add_parser("check", help="speak sentences, align them, and print phones and boundary errors")
    check.add_argument("language", metavar="TAG|X.toml", help="a tag from 'mien languages', or your own table")
    check.add_argument("sentences", metavar="TEXT", nargs="*", help="what to speak (default: the samples in the table)")
    check.set_defaults(run=_check)


def _check(options: argparse.Namespace) -> int:
    from mien.speech.language_check import check_language

    print(check_language(options.language, options.sentences))
    return 0
