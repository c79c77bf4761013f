"""Words written alike and said differently by what stands next to them: *read*, *lead*, *live* and their like."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.text.normalisation import SpokenWord

__all__ = ["with_heteronyms"]


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads((files("mien") / "assets" / "text" / "heteronyms.toml").read_text(encoding="utf-8"))


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
            starts = place == 0 or words[place - 1].pause in (".", "?", "!", ";", ":")
            before = "^" if starts else words[place - 1].text
            after = words[place + 1].text if place + 1 < len(words) and not word.pause else ""
            said = next(
                (
                    rule["say"]
                    for rule in entry["rules"]
                    if before in rule.get("after", "").split() or (after and after in rule.get("before", "").split())
                ),
                entry["else"],
            )
            word = replace(word, phones=tuple(said.split()))
        found.append(word)
    return tuple(found)
