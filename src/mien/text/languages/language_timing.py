"""From phones in a language's own signs to what models move: English phones, with key shapes of their own."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np

from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.text.languages.language import Language

__all__ = ["heard_as", "in_english_phones", "native_tier"]


class TimedPhone(Protocol):
    """A phone as the aligner found it; ``word`` is the number of its word, -1 in a pause."""

    @property
    def label(self) -> str: ...
    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def word(self) -> int: ...


def heard_as(phones: Sequence[str], language: Language) -> tuple[str, ...]:
    """What the English acoustic model is to look for in a word.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> heard_as(("p", "f", "yː"), find_language("de"))
    ('P', 'F', 'UW')
    """
    found = tuple(segment.heard for phone in phones for segment in language.segments(phone))
    return found or ("AH",)


def native_tier(phones: Sequence[TimedPhone], words: Sequence[Sequence[str]], language: Language) -> Tier:
    """The phones of a language in time, from what was aligned for them (`heard_as`).

    Parameters
    ----------
    phones : sequence of AlignedPhone
        In order, pauses among them.
    words : sequence of sequences of str
        The language's phones of each word.
    language : Language
    """
    found: list[Interval] = []
    numbered: dict[int, list[TimedPhone]] = {}
    for phone in phones:
        numbered.setdefault(phone.word, []).append(phone)
    done: set[int] = set()
    for phone in phones:
        if phone.word < 0:
            found.append(Interval(phone.start, phone.end, PAUSE))
        elif phone.word not in done:
            done.add(phone.word)
            found += _word(numbered[phone.word], words[phone.word], language)
    return Tier("phones", tuple(found))


def _word(timed: Sequence[TimedPhone], phones: Sequence[str], language: Language) -> list[Interval]:
    found, place = [], 0
    for phone in phones:
        count = len(language.segments(phone))
        if count:
            found.append(Interval(timed[place].start, timed[place + count - 1].end, phone))
        place += count
    return found or [Interval(timed[0].start, timed[-1].end, PAUSE)]


def in_english_phones(native: Tier, language: Language) -> tuple[Tier, tuple[tuple[str, ...], ...]]:
    """The phones of a language as English ones (ARPAbet), and the key shapes of each that is not made like it.

    A long phone becomes one long phone; a phone of several segments shares its time among them evenly; one without a
    sound of its own gives its time to the phone before it.

    Returns
    -------
    phones : Tier
    shapes : tuple of tuple of str
        One for each phone; empty where the English phone's own shapes do.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> native = Tier("phones", (Interval(0.0, 0.2, "yː"), Interval(0.2, 0.3, "t"), Interval(0.3, 0.5, "SIL")))
    >>> phones, shapes = in_english_phones(native, find_language("fi"))
    >>> [phone.label for phone in phones], shapes
    (['UW', 'T', 'SIL'], (('front_round',), (), ()))
    """
    found: list[Interval] = []
    shapes: list[tuple[str, ...]] = []
    for phone in native:
        segments = () if phone.label == PAUSE else language.segments(phone.label)
        if phone.label == PAUSE or not (segments or found):
            found.append(Interval(phone.start, phone.end, PAUSE))
            shapes.append(())
        elif not segments:
            found[-1] = Interval(found[-1].start, phone.end, found[-1].label)
        else:
            edges = np.linspace(phone.start, phone.end, len(segments) + 1).tolist()
            found += [Interval(a, b, s.articulation) for s, (a, b) in zip(segments, pairwise(edges), strict=True)]
            shapes += [segment.shapes for segment in segments]
    return Tier("phones", tuple(found)), tuple(shapes)
