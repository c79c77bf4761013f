"""SSML's ``say-as``: how a stretch of text is to be read, brought into words that the voice reads that way."""

from __future__ import annotations

import re
from collections.abc import Callable

__all__ = ["SAY_AS", "say_as"]

_SIGNS = {"@": "at", ".": "dot", "-": "dash", "_": "underscore", "/": "slash", "+": "plus", "#": "hash", "&": "and"}
_ORDINAL_ENDS = {1: "st", 2: "nd", 3: "rd"}


def _characters(text: str) -> str:
    """Each letter by its name, each digit by itself."""
    said = [f"{char.upper()}." if char.isalpha() else _SIGNS.get(char, char) for char in text if not char.isspace()]
    return " ".join(said)


def _digits(text: str) -> str:
    return " ".join(char for char in text if char.isdigit())


def _ordinal(text: str) -> str:
    digits = re.sub(r"\D", "", text)
    if not digits:
        return text
    number = int(digits)
    end = "th" if number % 100 in (11, 12, 13) else _ORDINAL_ENDS.get(number % 10, "th")
    return f"{number}{end}"


def _telephone(text: str) -> str:
    groups = re.findall(r"\d+", text)
    return ", ".join(" ".join(group) for group in groups)


def _as_written(text: str) -> str:
    return text


SAY_AS: dict[str, Callable[[str], str]] = {
    "characters": _characters,
    "spell-out": _characters,
    "letters": _characters,
    "verbatim": _characters,
    "digits": _digits,
    "telephone": _telephone,
    "ordinal": _ordinal,
    "cardinal": _as_written,
    "number": _as_written,
    "fraction": _as_written,
    "unit": _as_written,
    "date": _as_written,
    "time": _as_written,
    "currency": _as_written,
    "address": _as_written,
}
"""By the value of ``interpret-as``."""


def say_as(kind: str, text: str) -> str | None:
    """The text to be read, or None if this kind is not known.

    Examples
    --------
    >>> say_as("characters", "B2"), say_as("ordinal", "22"), say_as("telephone", "555-0199")
    ('B. 2', '22nd', '5 5 5, 0 1 9 9')
    """
    known = SAY_AS.get(kind.strip().lower())
    return None if known is None else known(text.strip())
