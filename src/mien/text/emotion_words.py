"""Words for emotions: what people call them, and the short tags that ask for one.

``<angry>...</angry>`` stands for ``<emotion name="angry">...</emotion>``, ``<angry 0.6>`` for the same at 0.6; one that
is not closed holds to the end of the text, or until the next that is not.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import cache

from mien.core.emotions import emotions

__all__ = ["NOUNS", "emotion_called", "with_long_tags"]

NOUNS: dict[str, str] = {
    "joy": "happy",
    "happiness": "happy",
    "fear": "afraid",
    "anger": "angry",
    "disgust": "disgusted",
    "sadness": "sad",
    "surprise": "surprised",
    "frustration": "frustrated",
}
"""What else the emotions of mien are called."""


def emotion_called(word: str) -> str:
    """The emotion that a word names; a word that is no other name of one is left as it is, in small letters.

    Examples
    --------
    >>> emotion_called("Joy"), emotion_called("fear"), emotion_called("wistful")
    ('happy', 'afraid', 'wistful')
    """
    small = word.strip().lower()
    return NOUNS.get(small, small)


@cache
def _short_tag() -> re.Pattern[str]:
    words = "|".join(sorted({*emotions(), *NOUNS}, key=len, reverse=True))
    return re.compile(rf"<(?P<end>/)?(?P<name>{words})(?:[ \t]+(?P<strength>[01]?\.?\d{{1,6}}))?[ \t]*>")


def with_long_tags(text: str, known: Collection[str] = ()) -> tuple[str, tuple[str, ...]]:
    """A text in which short tags of emotions are written out, and which of them are never closed.

    Every other character stays, lines too.

    Parameters
    ----------
    text : str
    known : collection of str
        Names that mean something else.

    Examples
    --------
    >>> with_long_tags("<angry 0.6>No!</angry> Well.")
    ('<emotion name="angry" intensity="0.6">No!</emotion> Well.', ())
    >>> with_long_tags("Oh. <joy>It is you!")
    ('Oh. <emotion name="happy">It is you!</emotion>', ('joy',))
    """
    pieces, place, opened, held = [], 0, list[str](), list[str]()
    tags = [found for found in _short_tag().finditer(text) if found["name"] not in known]
    ends = [found["name"] for found in tags if found["end"]]
    for found in tags:
        name = found["name"]
        pieces.append(text[place : found.start()])
        place = found.end()
        if found["end"]:
            ends.remove(name)
            pieces.append("</emotion>")
            continue
        if opened:
            pieces.append("</emotion>")
            opened.pop()
        if name not in ends:
            opened.append(name)
            held.append(name)
        strength = f' intensity="{found["strength"]}"' if found["strength"] else ""
        pieces.append(f'<emotion name="{emotion_called(name)}"{strength}>')
    return "".join([*pieces, text[place:], "</emotion>" * len(opened)]), tuple(dict.fromkeys(held))
