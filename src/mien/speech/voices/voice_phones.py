"""Writing English in the letters of a neural voice, and reading their times back.

Each network has its own letters (IPA with habits of its own): a table in ``assets/voices`` says how ARPAbet is
written in them. The same table shape serves every network, see ``assets/voices/kokoro.toml``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from mien.core.assets import asset_table
from mien.core.timeline import Interval
from mien.speech.voices.sentences import Sentence, Word
from mien.speech.voices.word_stress import stress_of
from mien.text.phones import is_vowel

__all__ = ["Letter", "letter_table", "letters_of", "times_of"]


@dataclass(frozen=True)
class Letter:
    """One letter for the network, and which phone of which word it writes (``phone`` is -1 for spaces and marks)."""

    symbol: str
    word: int
    phone: int


@cache
def letter_table(name: str) -> dict[str, Any]:
    """The table of a network, ``assets/voices/NAME.toml``."""
    return asset_table(f"voices/{name}.toml")


def letters_of(sentence: Sentence, table: dict[str, Any]) -> list[Letter]:
    """Write a sentence in a network's letters.

    Examples
    --------
    >>> word = Word("butter", ("B", "AH", "T", "ER"), ".")
    >>> "".join(letter.symbol for letter in letters_of(Sentence((word,)), letter_table("kokoro")))
    'bˈʌɾəɹ.'
    """
    letters: list[Letter] = []
    for number, word in enumerate(sentence.words):
        if number:
            letters.append(Letter(" ", number - 1, -1))
        for phone, symbols in enumerate(_spelling(word, table)):
            letters += [Letter(symbol, number, phone) for symbol in symbols]
        letters += [Letter(table["marks"].get(mark, mark), number, -1) for mark in word.mark]
    return letters


def _spelling(word: Word, table: dict[str, Any]) -> Iterator[str]:
    """The letters of each phone of a word."""
    weak = word.text in table["words"]["unstressed"].split()
    digits = iter(stress_of(word.text, word.phones))
    degrees = [next(digits) if is_vowel(phone) else "" for phone in word.phones]
    for place, (phone, degree) in enumerate(zip(word.phones, degrees, strict=True)):
        if not degree:
            yield table["flap"] if _is_flapped(word.phones, degrees, place) else table["consonants"][phone]
        elif degree == "0" or weak:
            yield table["unstressed"].get(phone, table["vowels"][phone])
        else:
            yield table["stress"][degree] + table["vowels"][phone]


def _is_flapped(phones: Sequence[str], degrees: Sequence[str], place: int) -> bool:
    """American English taps a T between a vowel (or R) and an unstressed vowel: *butter*, *party*, not *button*."""
    if phones[place] != "T" or not 0 < place < len(phones) - 1 or degrees[place + 1] != "0":
        return False
    return bool(degrees[place - 1] or phones[place - 1] == "R") and phones[place + 2 : place + 3] != ("N",)


def times_of(
    letters: Sequence[Letter], spans: Sequence[tuple[float, float]], sentence: Sentence
) -> tuple[list[Interval], list[Interval]]:
    """Phones and words from the time of every letter, seconds.

    A space has no silence of its own: its time belongs to the phone before it. That of a mark is a pause.
    """
    found: dict[tuple[int, int], tuple[float, float]] = {}
    last: tuple[int, int] | None = None
    for letter, (start, end) in zip(letters, spans, strict=True):
        if letter.phone >= 0:
            last = (letter.word, letter.phone)
        elif letter.symbol != " ":
            last = None
        if last is not None:
            found[last] = (found.get(last, (start, end))[0], end)
    phones = [Interval(*span, sentence.words[word].phones[phone]) for (word, phone), span in found.items()]
    words = []
    for number, word in enumerate(sentence.words):
        own = [span for (place, _), span in found.items() if place == number]
        words.append(Interval(own[0][0], own[-1][1], word.text))
    return phones, words
