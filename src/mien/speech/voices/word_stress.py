"""Which syllables of an English word are stressed.

The pronunciations that mien speaks from carry no stress; neural voices want it. The table
``assets/voices/stress.txt.gz`` holds the stress of every word of two syllables and more of the CMU Pronouncing
Dictionary (BSD-2-Clause): one digit a syllable, 1 primary, 2 secondary, 0 none. Where a word is stressed in more than
one way, each way has its vowels: ``record 01/AH-AO 10/EH-ER``.
"""

from __future__ import annotations

import gzip
import re
from collections import Counter
from functools import cache

from mien.core.assets import asset
from mien.text.phones import is_vowel

__all__ = ["stress_of"]

_LONGEST_ENDING = 5
_ENOUGH_WORDS = 5


def stress_of(word: str, phones: tuple[str, ...]) -> str:
    """Stress of a word: one digit for each vowel of its pronunciation.

    A word outside the table takes the commonest pattern among words of as many syllables that share its longest
    ending.

    Examples
    --------
    >>> stress_of("banana", ("B", "AH", "N", "AE", "N", "AH"))
    '010'
    >>> stress_of("cat", ("K", "AE", "T"))
    '1'
    """
    syllables = sum(map(is_vowel, phones))
    if syllables <= 1:
        return "1" * syllables
    vowels = "-".join(filter(is_vowel, phones))
    entries = [entry for entry in _patterns(word.lower()) if len(entry.partition("/")[0]) == syllables]
    fitting = [entry for entry in entries if entry.endswith(f"/{vowels}")] or entries
    return fitting[0].partition("/")[0] if fitting else _by_ending(word.lower(), syllables)


@cache
def _text() -> bytes:
    """A line for each word, each with a line feed before it."""
    return b"\n" + gzip.decompress(asset("voices/stress.txt.gz").read_bytes())


@cache
def _patterns(word: str) -> tuple[str, ...]:
    """What the table has of one word; a line needs a few words of a hundred thousand."""
    text, sought = _text(), f"\n{word} ".encode()
    place = text.find(sought)
    if place < 0:
        return ()
    start = place + len(sought)
    return tuple(text[start : text.find(b"\n", start)].decode().split())


@cache
def _by_ending(word: str, syllables: int) -> str:
    for length in range(_LONGEST_ENDING, 0, -1):
        first = rb"%s ([012]{%d}(?:/\S+)?)\s" % (re.escape(word[-length:].encode()), syllables)
        found: Counter[str] = Counter(pattern.decode() for pattern in re.findall(first, _text()))
        if found.total() >= _ENOUGH_WORDS:
            return max(sorted(found), key=lambda pattern: found[pattern])
    return "0" * max(0, syllables - 3) + "1" + "0" * min(2, syllables - 1)
