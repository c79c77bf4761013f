"""Which syllable of each word of an utterance is stressed, and how high, loud and long it is."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from mien.core.errors import InputError
from mien.core.timeline import Interval
from mien.core.utterance import Utterance
from mien.speech.pitch import level_contour, pitch_contour
from mien.speech.voices.voice_phones import letter_table
from mien.speech.voices.word_stress import stress_of
from mien.text.languages import find_language
from mien.text.languages.tokens import tokens_of
from mien.text.normalisation import spoken_words
from mien.text.phones import is_vowel

__all__ = ["StressedWord", "stressed_words"]


@dataclass(frozen=True)
class StressedWord:
    """A word and its stressed vowel.

    Attributes
    ----------
    text : str
    start, end : float
        Of the word, seconds.
    vowel_start, vowel_end : float
        Of its stressed vowel (of the whole word where it has none), seconds.
    pitch : float
        Highest pitch in the vowel (its 90th percentile), semitones above 100 Hz; NaN where nothing is voiced.
    level : float
        Of the vowel, dBFS.
    weak : bool
        Whether it is a small word that is seldom stressed, such as *the*.
    mark : str
        The punctuation after it: one of ``. ? ! : ; , -``, or ``""``.
    """

    text: str
    start: float
    end: float
    vowel_start: float
    vowel_end: float
    pitch: float
    level: float
    weak: bool
    mark: str


def stressed_words(utterance: Utterance) -> tuple[StressedWord, ...]:
    """The words of an utterance, in order."""
    pitch, level = pitch_contour(utterance.audio), level_contour(utterance.audio)
    semitones = pitch.semitones(100.0)
    found = []
    phones = utterance.phones.intervals
    middles = [phone.middle for phone in phones]
    for word, mark in zip(utterance.words, _marks(utterance), strict=True):
        inside_word = phones[bisect_left(middles, word.start) : bisect_left(middles, word.end)]
        vowel = _stressed_vowel(word, inside_word, utterance.language)
        first, after = np.searchsorted(pitch.times, vowel.start), np.searchsorted(pitch.times, vowel.end, "right")
        inside = semitones[first:after]
        inside = inside[np.isfinite(inside)]
        top = float(np.percentile(inside, 90)) if len(inside) else float("nan")
        loud = float(level.decibels_at(np.linspace(vowel.start, vowel.end, 5)).max())
        weak = word.label in _weak_words(utterance.language)
        found.append(StressedWord(word.label, word.start, word.end, vowel.start, vowel.end, top, loud, weak, mark))
    return tuple(found)


def _stressed_vowel(word: Interval, phones: Sequence[Interval], tag: str) -> Interval:
    vowels = [phone for phone in phones if is_vowel(phone.label)]
    if not vowels:
        return word
    language = find_language(tag) if _is_known(tag) else None
    if tag.lower().startswith("en"):
        degrees = stress_of(word.label.rstrip("."), tuple(phone.label for phone in phones))
        place = degrees.find("1") if len(degrees) == len(vowels) else 0
        return vowels[max(place, 0)]
    if language is not None and language.table.get("stress") == "first":
        return vowels[0]
    return max(vowels, key=lambda phone: phone.duration)


@cache
def _is_known(tag: str) -> bool:
    from mien.text.languages import known_languages

    return tag.lower().partition("-")[0] in ("en", *known_languages())


@cache
def _weak_words(tag: str) -> frozenset[str]:
    if tag.lower().startswith("en"):
        return frozenset(letter_table("kokoro")["words"]["unstressed"].split())
    language = find_language(tag) if _is_known(tag) else None
    return frozenset() if language is None else frozenset(language.table.get("known_by", ()))


def _marks(utterance: Utterance) -> Sequence[str]:
    """The punctuation after each word; none where the text does not count as many words."""
    count, text = len(utterance.words), utterance.text
    marks: list[str] = []
    if not utterance.language.lower().startswith("en"):
        marks = [token.pause for token in tokens_of(text) if token.text]
    elif text.strip():
        try:
            marks = [word.pause for word in spoken_words(text).words]  # knows that "Mr." ends no sentence
        except InputError:  # labels of a TextGrid may hold anything
            return [""] * count
    return marks if len(marks) == count else [""] * count
