"""The words of a line with their phones, and which of them are which in another reading of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cached_property

from mien.core.utterance import Utterance

__all__ = ["Line", "LineWord", "SpokenLine", "line_of", "matched_phones", "matched_words"]


@dataclass(frozen=True)
class LineWord:
    """A word of a line, as a layer remembers it.

    Attributes
    ----------
    word : str or None
        Lower case, as in the words tier; None: what comes before the first word.
    phones : tuple of str
        Labels of its phones.
    pauses : tuple of str
        Labels of the phones after it that belong to no word: mostly none, or one ``"SIL"``.
    """

    word: str | None
    phones: tuple[str, ...] = ()
    pauses: tuple[str, ...] = ()


Line = tuple[LineWord, ...]
"""The first entry is what comes before the first word."""


@dataclass(frozen=True, eq=False)
class SpokenLine:
    """A line in an utterance.

    Attributes
    ----------
    line : Line
    phones, pauses : tuple of tuple of int
        For each entry of the line, the places of its phones and pauses in the phone tier.
    """

    line: Line
    phones: tuple[tuple[int, ...], ...]
    pauses: tuple[tuple[int, ...], ...]

    @cached_property
    def words(self) -> list[str | None]:
        """The words alone."""
        return [entry.word for entry in self.line]


def line_of(utterance: Utterance) -> SpokenLine:
    """The line of an utterance: each phone goes to the word in which its middle lies, or to the pauses before it.

    Examples
    --------
    >>> from mien.core.audio import Audio
    >>> from mien.core.timeline import Interval, Tier
    >>> words = Tier("words", (Interval(0.1, 0.3, "no"),))
    >>> phones = [(0, 0.1, "SIL"), (0.1, 0.2, "N"), (0.2, 0.3, "OW"), (0.3, 0.5, "SIL")]
    >>> tier = Tier("phones", tuple(Interval(*phone) for phone in phones))
    >>> line_of(Utterance("No.", Audio.silence(0.5, 8000), words, tier, "en-US", "voice")).line[1]
    LineWord(word='no', phones=('N', 'OW'), pauses=('SIL',))
    """
    words, labels = utterance.words.intervals, [phone.label for phone in utterance.phones]
    phones: list[list[int]] = [[] for _ in range(len(words) + 1)]
    pauses: list[list[int]] = [[] for _ in range(len(words) + 1)]
    begun = 0
    for place, phone in enumerate(utterance.phones):
        while begun < len(words) and words[begun].start <= phone.middle:
            begun += 1
        inside = begun > 0 and phone.middle < words[begun - 1].end
        (phones if inside else pauses)[begun].append(place)
    named: list[str | None] = [None, *(word.label for word in words)]
    line = tuple(
        LineWord(name, tuple(labels[p] for p in own), tuple(labels[p] for p in after))
        for name, own, after in zip(named, phones, pauses, strict=True)
    )
    return SpokenLine(line, tuple(map(tuple, phones)), tuple(map(tuple, pauses)))


def matched_words(old: Line, new: Line) -> dict[int, int]:
    """Which entry of ``new`` each entry of ``old`` has become, as far as it is there still.

    The words are aligned in order, in the longest stretches that both lines share (Ratcliff and Obershelp), so that a
    word put in before another of the same name does not take its edits.

    Examples
    --------
    >>> old = tuple(map(LineWord, (None, "never", "say", "never")))
    >>> new = tuple(map(LineWord, (None, "i", "never", "never", "say", "never")))
    >>> matched_words(old, new)
    {0: 0, 1: 3, 2: 4, 3: 5}
    """
    found = {0: 0} if old and new else {}
    a, b = [entry.word for entry in old[1:]], [entry.word for entry in new[1:]]
    for block in SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks():
        found |= {block.a + n + 1: block.b + n + 1 for n in range(block.size)}
    return found


def matched_phones(old: Sequence[str], new: Sequence[str]) -> dict[int, int]:
    """Which phone of a word each has become in another pronunciation; as many others in the same place count as it.

    Examples
    --------
    >>> matched_phones(["N", "EH", "V", "ER"], ["N", "EH", "V", "AH", "R"])
    {0: 0, 1: 1, 2: 2}
    >>> matched_phones(["DH", "AH"], ["DH", "IY"])
    {0: 0, 1: 1}
    """
    found: dict[int, int] = {}
    for kind, a, a_end, b, b_end in SequenceMatcher(None, list(old), list(new), autojunk=False).get_opcodes():
        if kind == "equal" or (kind == "replace" and a_end - a == b_end - b):
            found |= {a + n: b + n for n in range(a_end - a)}
    return found
