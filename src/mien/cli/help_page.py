"""What ``mien --help`` shows, and what is suggested for a command or an option that does not exist."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from mien.core.assets import asset_table

__all__ = ["GROUPS", "HelpFormatter", "examples_of", "help_page", "options_of", "with_suggestion"]

GROUPS: dict[str, tuple[str, ...]] = {
    "perform": ("say", "animate", "align", "express", "recolor", "emotion", "studio", "batch"),
    "learn": ("corpus", "record", "learn", "inspect", "emotion-train", "emotion-map", "tracker"),
    "faces": ("face",),
    "streams": ("live", "serve", "interpret", "speak", "translate", "perform"),
    "research": ("score", "evaluate", "stimuli", "emotion-table"),
    "choose from": ("voices", "emotions", "faces", "languages", "language", "formats", "performers"),
}
"""Commands by what they are for, in the order in which they are shown; the others follow under *more*."""

_EXAMPLES = (
    'mien say "I never said that." --emotion angry -o line.mp4',
    "mien animate line.wav --text line.txt -o line.glb --also line.csv",
    "mien corpus import my-videos/ -o corpus && mien learn corpus -o me.mien",
)


def help_page(about: str, commands: Mapping[str, str]) -> str:
    """The page of ``mien --help``.

    Parameters
    ----------
    about : str
        What mien does, in one line.
    commands : mapping of str to str
        One line of help for each command.
    """
    left = dict(commands)
    groups = {title: [name for name in names if name in left] for title, names in GROUPS.items()}
    grouped = {name for names in groups.values() for name in names}
    groups["more"] = [name for name in left if name not in grouped]
    width = max(map(len, commands))
    lines = [about, "", "usage: mien COMMAND ...    ('mien COMMAND --help' shows its options)"]
    for title, names in groups.items():
        if names:
            lines += ["", f"{title}:"] + [f"  {name:{width}}  {left[name]}".rstrip() for name in names]
    return "\n".join([*lines, "", "examples:", *(f"  {example}" for example in _EXAMPLES), ""])


class HelpFormatter(argparse.HelpFormatter):
    """Wraps everything but examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith("examples:") else super()._fill_text(text, width, indent)


def examples_of(prog: str) -> str | None:
    """What stands under the help of a command such as ``"mien say"``; None where it has no examples."""
    lines = asset_table("help/examples.toml").get(prog.removeprefix("mien").strip(), ())
    return "\n  ".join(["examples:", *lines]) if lines else None


def with_suggestion(message: str, commands: Iterable[str], options: Iterable[str]) -> str:
    """An error of argparse, with the nearest name that exists in the place of a list of all.

    Examples
    --------
    >>> with_suggestion("argument COMMAND: invalid choice: 'sya' (choose from 'say', 'live')", ["say", "live"], [])
    "there is no command 'sya': did you mean 'say'?"
    >>> with_suggestion("unrecognized arguments: --emotoin sad", [], ["--emotion", "--fps"])
    'unrecognized arguments: --emotoin sad: did you mean --emotion?'
    """
    chosen = re.match(r"argument COMMAND: invalid choice: '([^']*)'", message)
    if chosen:
        near = get_close_matches(chosen[1], list(commands), n=1)
        guess = f": did you mean {near[0]!r}?" if near else ""
        return f"there is no command {chosen[1]!r}{guess}"
    unknown = re.match(r"unrecognized arguments: (\S+)", message)
    if unknown:
        near = get_close_matches(unknown[1].split("=")[0], list(options), n=1)
        return f"{message}: did you mean {near[0]}?" if near else message
    return message


def options_of(parser: argparse.ArgumentParser) -> list[str]:
    """Every long option that a parser knows."""
    return [name for name in parser._option_string_actions if name.startswith("--")]
