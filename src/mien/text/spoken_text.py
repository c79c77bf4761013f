"""`SpokenWord` and `SpokenText`: the words that are said for a written text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mien.core.errors import Note

__all__ = ["Spelled", "SpokenText", "SpokenWord", "with_spellings"]

Spelled = tuple[int, int, tuple[str, ...]]
"""Characters ``start`` to ``end`` of a text and the ARPAbet phones that are asked for them."""


@dataclass(frozen=True)
class SpokenWord:
    """One word to be said.

    Attributes
    ----------
    text : str
        Lower case: letters and apostrophes. A letter said by its name carries a full stop: ``"b."``.
    start, end : int
        The characters of the written text that it stands for, ``written[start:end]``. Words of one number share them.
    pause : str
        The punctuation that follows, ``""`` if none: the strongest of ``. ? ! : ; , -``, where ``"-"`` is a dash.
    phones : tuple of str or None
        How it is to be pronounced, where that was asked for; ARPAbet.
    """

    text: str
    start: int
    end: int
    pause: str = ""
    phones: tuple[str, ...] | None = None


@dataclass(frozen=True)
class SpokenText:
    """A written text and the words that are said for it, in order; at least one."""

    written: str
    words: tuple[SpokenWord, ...]
    notes: tuple[Note, ...] = ()

    @property
    def spoken(self) -> str:
        """The spoken words, separated by blanks."""
        return " ".join(word.text for word in self.words)

    def written_for(self, first: int, last: int) -> str:
        """The written text of words ``first`` to ``last``, both included."""
        return self.written[self.words[first].start : self.words[last].end]


def with_spellings(spoken: SpokenText, spellings: Sequence[Spelled], by: str = "") -> SpokenText:
    """The same text with some words pronounced as asked; what cannot be followed is a note.

    Parameters
    ----------
    spoken : SpokenText
    spellings : sequence of (start, end, phones)
        Characters of the written text, and their ARPAbet phones.
    by : str
        Who speaks, for the notes.
    """
    words, notes = list(spoken.words), list(spoken.notes)
    for start, end, phones in spellings:
        inside = [place for place, word in enumerate(words) if word.end > start and word.start < end]
        if len(inside) != 1:
            what = f"{spoken.written[start:end].strip()!r} is not pronounced as asked {by}".rstrip()
            notes.append(Note("note", f"{what}: it is not read as one word"))
            continue
        words[inside[0]] = replace(words[inside[0]], phones=phones)
    return replace(spoken, words=tuple(words), notes=tuple(notes))
