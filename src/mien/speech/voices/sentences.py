"""What a voice is asked to say: sentences of words with their phones and the marks after them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

from mien.text.pronunciation import Pronunciation, pronounce
from mien.text.spoken_text import SpokenText

__all__ = ["Sentence", "Word", "in_groups", "sentences_of", "shorter_than"]

_FULL_STOPS = ".?!"
_WORDS_AT_ONCE = 500
_LINKING = frozenset(
    re.findall(
        r"\w+", "and but or nor so that which who when while where because since if unless until although before as"
    )
)
"""Before these one may breathe."""


@dataclass(frozen=True)
class Word:
    """One word.

    Attributes
    ----------
    text : str
        Lower case, as spoken; a letter said by its name carries a full stop: ``"b."``.
    phones : tuple of str
        ARPAbet without stress digits.
    mark : str
        The punctuation that follows: ``""`` or one of ``. ? ! : ; , -``.
    """

    text: str
    phones: Pronunciation
    mark: str = ""

    @property
    def plain(self) -> str:
        """Letters and apostrophes only, as engines that read text want it; a letter's name as a capital."""
        return self.text[0].upper() + self.text[2:] if self.text[1:2] == "." else self.text


@dataclass(frozen=True)
class Sentence:
    """Words up to a full stop, question or exclamation mark."""

    words: tuple[Word, ...]

    @property
    def text(self) -> str:
        """The words and their marks as one line; a dash becomes a comma.

        Examples
        --------
        >>> Sentence((Word("oh", ("OW",), ","), Word("no", ("N", "OW"), "!"))).text
        'oh, no!'
        """
        return " ".join(word.plain + word.mark.replace("-", ",") for word in self.words)

    @property
    def mark(self) -> str:
        """The mark that ends it, ``""`` if it was cut elsewhere."""
        return self.words[-1].mark


def sentences_of(spoken: SpokenText) -> tuple[Sentence, ...]:
    """Cut a text into sentences and look its words up; the last one always ends with a mark.

    Examples
    --------
    >>> from mien.text.normalisation import spoken_words
    >>> [sentence.text for sentence in sentences_of(spoken_words("Oh no! It is 5 o'clock, Bob"))]
    ['oh no!', "it is five o'clock, bob."]
    """
    sentences: list[Sentence] = []
    words: list[Word] = []
    for place, word in enumerate(spoken.words):
        words.append(Word(word.text, word.phones or pronounce(word.text), word.pause))
        last = place == len(spoken.words) - 1
        if last and word.pause not in tuple(_FULL_STOPS):
            words[-1] = replace(words[-1], mark=".")
        if last or words[-1].mark in tuple(_FULL_STOPS):
            sentences.append(Sentence(tuple(words)))
            words = []
    return tuple(sentences)


def in_groups(sentences: Sequence[Sentence]) -> Iterator[tuple[Sentence, ...]]:
    """Whole sentences of at least 500 words together: what an engine that is a program of its own is asked at once.

    So a long text is never held in memory as a whole, and its progress can be told.
    """
    group: list[Sentence] = []
    for sentence in sentences:
        group.append(sentence)
        if sum(len(one.words) for one in group) >= _WORDS_AT_ONCE:
            yield tuple(group)
            group = []
    if group:
        yield tuple(group)


def shorter_than(limit: int, sentence: Sentence) -> Iterator[Sentence]:
    """Cut a sentence into pieces of at most ``limit`` letters of any network, at a mark if possible.

    It is cut after the last mark that fits, else before the last word that links clauses, else between any words; a
    piece holds at least one word. A phone takes at most three letters (stress mark and two more), the mark and the
    space after a word two.

    Examples
    --------
    >>> long = Sentence(tuple(Word("no", ("N", "OW"), "," if i == 1 else "") for i in range(5)))
    >>> [len(piece.words) for piece in shorter_than(24, long)]
    [2, 3]
    """
    rest = sentence.words
    while rest:
        sizes = accumulate(3 * len(word.phones) + 2 for word in rest)
        count = max(1, sum(size <= limit for size in sizes))
        if count < len(rest):
            places = range(count, count // 3, -1)
            marked = [place for place in places if rest[place - 1].mark]
            linking = [place for place in places if rest[place].text in _LINKING]
            count = (marked or linking or [count])[0]
        yield Sentence(rest[:count])
        rest = rest[count:]
