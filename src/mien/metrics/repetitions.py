"""How far the recordings themselves go: a word's motion told from the other times it was said.

A model that is given phones and their times alone cannot know how this repetition of a word differs from the others.
Here the word is told as the mean of the others, brought to this one's phone times. It uses takes of the test, so it
is a yardstick and no contender; and no bound: a few repetitions make a rough mean, and a model that draws on all takes
can do better.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Interval
from mien.metrics.scored_takes import Recording

__all__ = ["LEAST", "Repetitions"]

LEAST = 3
"""Other repetitions in the same company that are enough to be averaged; else less company is asked for."""
_POINTS = 4  # looks at each phone
_OUTSIDE = 0.12  # seconds kept before and after the word, for the frames at the edges of speech

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Spoken:
    """One time that a word was said: its looks in time and the mouth at each."""

    take: str
    word: str
    phones: tuple[str, ...]
    before: str
    after: str
    times: Array
    shapes: Array

    @property
    def company(self) -> tuple[tuple[str | tuple[str, ...], ...], ...]:
        """What it must share with another repetition: all of the first, or else of the second, ..."""
        own = (self.word, self.phones)
        return (*own, self.before, self.after), (*own, "*", self.after), (*own, self.before, "*"), own


class Repetitions:
    """All words said in some recordings.

    Parameters
    ----------
    recordings : iterable of Recording
    """

    def __init__(self, recordings: Iterable[Recording]) -> None:
        self._by_company: dict[tuple[str | tuple[str, ...], ...], list[_Spoken]] = {}
        for recording in recordings:
            for spoken in _words(recording):
                for company in spoken.company:
                    self._by_company.setdefault(company, []).append(spoken)

    def mouth(self, recording: Recording) -> tuple[Array, NDArray[np.bool_]]:
        """The mouth of a take as the other takes have its words.

        Returns
        -------
        positions : ndarray, shape (frames, markers, 3)
            Millimetres; where no other take says the word, the mean of the take itself.
        known : ndarray of bool, shape (frames,)
            Where another take says it.
        """
        flat = recording.positions.reshape(len(recording.times), -1)
        result = np.tile(flat[recording.speech].mean(axis=0), (len(flat), 1))
        known = np.zeros(len(flat), dtype=bool)
        for spoken in _words(recording):
            others = self._others(spoken)
            held = (recording.times >= spoken.times[0] - 1e-9) & (recording.times <= spoken.times[-1] + 1e-9)
            held &= ~known | (recording.times >= spoken.times[1] - 1e-9)  # a word's own frames win over its outside
            if others is None or not held.any():
                continue
            now = recording.times[held]
            result[held] = np.stack([np.interp(now, spoken.times, column) for column in others.T], axis=1)
            known |= held
        return result.reshape(recording.positions.shape), known

    def _others(self, spoken: _Spoken) -> Array | None:
        """Mean shapes of the other takes, in the closest company that at least `LEAST` of them share."""
        for company in spoken.company:
            others = [s.shapes for s in self._by_company.get(company, ()) if s.take != spoken.take]
            if len(others) >= LEAST:
                return np.asarray(np.mean(others, axis=0))
        return None


def _words(recording: Recording) -> list[_Spoken]:
    """The words of a take in order, each with what is said before and after it."""
    seen = np.isfinite(recording.positions).all(axis=(1, 2))
    clock = recording.times[seen]
    flat = recording.positions[seen].reshape(len(clock), -1)
    words = recording.take.words.intervals
    labels = ["", *(word.label.lower() for word in words), ""]
    result = []
    for place, word in enumerate(words):
        phones = [p for p in recording.take.phones if word.start <= p.middle < word.end]
        if phones:
            times = _looks(phones)
            shapes = np.stack([np.interp(times, clock, column) for column in flat.T], axis=1)
            label, symbols = labels[place + 1], tuple(p.label for p in phones)
            spoken = _Spoken(recording.take.name, label, symbols, labels[place], labels[place + 2], times, shapes)
            result.append(spoken)
    return result


def _looks(phones: list[Interval]) -> Array:
    """Instants at equal shares of each phone, with one before and one after the word."""
    shares = np.arange(_POINTS) / _POINTS
    inside = np.concatenate([phone.start + shares * phone.duration for phone in phones])
    end = phones[-1].end
    return np.concatenate([[inside[0] - _OUTSIDE], inside, [end, end + _OUTSIDE]])
