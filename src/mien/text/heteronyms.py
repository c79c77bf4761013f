"""Words written alike and said differently by what stands next to them: *read*, *lead*, *live* and their like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from mien.core.assets import asset_table
from mien.text.spoken_text import SpokenWord

__all__ = ["with_heteronyms"]

_ENDS = (".", "?", "!", ";", ":")
_REACH = 12
"""Words to either side that a rule looks at."""


@cache
def _table() -> dict[str, Any]:
    return asset_table("text/heteronyms.toml")


def with_heteronyms(words: Sequence[SpokenWord]) -> tuple[SpokenWord, ...]:
    """The words, each heteronym with the phones that its neighbours ask for.

    Examples
    --------
    >>> from mien.text.normalisation import spoken_words
    >>> [word.phones for word in spoken_words("I will read what you have read.").words if word.text == "read"]
    [('R', 'IY', 'D'), ('R', 'EH', 'D')]
    """
    found = []
    for place, word in enumerate(words):
        entry = _table().get(word.text)
        if entry is not None and word.phones is None:
            word = replace(word, phones=tuple(_said(entry, words, place).split()))
        found.append(word)
    return tuple(found)


def _said(entry: dict[str, Any], words: Sequence[SpokenWord], place: int) -> str:
    """The phones of the first rule all of whose conditions hold."""
    starts = place == 0 or words[place - 1].pause in _ENDS
    before = "^" if starts else words[place - 1].text
    after = words[place + 1].text if place + 1 < len(words) and not words[place].pause else "$"
    sentence = _sentence(words, place) if any("within" in rule for rule in entry["rules"]) else frozenset()
    for rule in entry["rules"]:
        if (
            ("after" not in rule or before in _listed(rule["after"]))
            and ("before" not in rule or after in _listed(rule["before"]))
            and ("within" not in rule or sentence & _listed(rule["within"]))
        ):
            return str(rule["say"])
    return str(entry["else"])


def _listed(names: str) -> frozenset[str]:
    """Words of a rule; ``@determiners`` and their like stand for the lists at the head of the table."""
    groups = _table()["groups"]
    return frozenset(
        word for name in names.split() for word in (groups[name[1:]].split() if name.startswith("@") else [name])
    )


def _sentence(words: Sequence[SpokenWord], place: int) -> frozenset[str]:
    """The other words of a sentence, at most `_REACH` away."""
    first = place
    while first > max(0, place - _REACH) and words[first - 1].pause not in _ENDS:
        first -= 1
    last = place
    while last < min(len(words), place + _REACH) - 1 and words[last].pause not in _ENDS:
        last += 1
    return frozenset(word.text for number, word in enumerate(words[first : last + 1], first) if number != place)
