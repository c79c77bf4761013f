"""`SpokenWord` and `SpokenText`: the words that are said for a written text."""

from __future__ import annotations

from dataclasses import dataclass

from mien.core.errors import Note

__all__ = ["SpokenText", "SpokenWord"]


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
