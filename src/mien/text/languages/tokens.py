"""A text cut at its blanks, each piece with the pause that its marks ask for."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterator
from dataclasses import dataclass

__all__ = ["Token", "is_from_other_script", "tokens_of"]

_MARKS = {
    "…": ".",
    "—": "-",
    "–": "-",
    ")": ",",
    "(": ",",
    "¿": "",
    "¡": "",
    "。": ".",
    "、": ",",
    "，": ",",
    "？": "?",
    "！": "!",
    "：": ":",
    "；": ";",
}
_RANK = "-,;:!?."
_BEFORE = "\"'“”„«»‘’([{¿¡-–—−*_「『《（"
_AFTER = "\"'“”«»‘’)]}.,;:!?…-–—*_」』》）。、，？！：；"
_EAST = "\u3040-\u30ff\u3400-\u9fff"
# Marks between Chinese or Japanese characters (or a form in figures, masked) need no blank, be they full-width or not.
_PIECE = re.compile(
    rf"[^ \t\r\f\v]+?(?:[。、，？！：；]+|(?<=[{_EAST}])[,;:!?.]+(?=[{_EAST}\ue000\ue001])"
    rf"|(?<=[\ue000\ue001])[,;:!?.]+(?=[{_EAST}])|(?=[ \t\r\f\v]|$))"
)


@dataclass(frozen=True)
class Token:
    """A piece of text without blanks and without the marks around it.

    ``start`` and ``end`` count characters of the text; ``pause`` is the strongest of ``. ? ! : ; , -`` after it;
    ``said`` are the words it stands for, where it is not read as it is written.
    """

    text: str
    start: int
    end: int
    pause: str = ""
    said: str = ""


def tokens_of(text: str, short_forms: Collection[str] = ()) -> Iterator[Token]:
    """Pieces between blanks. A stop after one of the ``short_forms`` (small letters, with their stop) ends no sentence.

    Examples
    --------
    >>> [(token.text, token.pause) for token in tokens_of("Hei, esim. näin!", {"esim."})]
    [('Hei', ','), ('esim.', ''), ('näin', '!')]
    """
    for match in _PIECE.finditer(text.replace("\n", " ")):
        piece = match.group()
        front = len(piece) - len(piece.lstrip(_BEFORE))
        if front == len(piece):
            yield Token("", match.start(), match.start(), _strongest(piece))
            continue
        body = piece[front:].rstrip(_AFTER)
        tail = piece[front + len(body) :]
        if tail[:1] == "." and f"{body}.".lower() in short_forms:
            body, tail = body + ".", tail[1:] if tail[1:] else ""
        start = match.start() + front
        yield Token(body, start, start + len(body), _strongest(tail))


def _strongest(marks: str) -> str:
    found = [mark for char in marks for mark in _MARKS.get(char, char) if mark in _RANK and mark]
    return max(found, key=_RANK.index, default="")


def is_from_other_script(char: str) -> bool:
    """Whether it is a letter that is not Latin.

    Examples
    --------
    >>> is_from_other_script("ж"), is_from_other_script("ø"), is_from_other_script("!")
    (True, False, False)
    """
    return unicodedata.category(char)[0] == "L" and not unicodedata.name(char, "").startswith("LATIN")
