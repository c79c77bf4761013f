"""Visual prosody: brows and nods on accented words and phrase ends, from pitch, level, length and stress. Hand-made.

The rules, their figures and the studies they come from stand in ``assets/performance/prosody.toml``. An accent is a
stressed syllable that stands out of the phrase about it; which accents move the brows and which the head is drawn,
since no speaker marks them all. All times come from the utterance and not from frames: the same seed moves alike
at every frame rate.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.errors import InputError
from mien.core.poses import pose_vector, read_table
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.speech.stressed_vowels import StressedWord

__all__ = ["DEFAULT_STRENGTH", "Accent", "HandMadeProsody"]

Floats = NDArray[np.float64]
_REACH = 10.0  # seconds: longer than any gesture of the table

DEFAULT_STRENGTH = 0.5
"""Chosen by looking: seen if one looks for it."""
_FULL = 1.5  # prominence at which the upper figures of a pair hold
_PITCH, _ROLL = channels.ALL.index("headPitch"), channels.ALL.index("headRoll")
_UP = [channels.ALL.index(f"eyeLookUp{side}") for side in ("Left", "Right")]
_DOWN = [channels.ALL.index(f"eyeLookDown{side}") for side in ("Left", "Right")]


@dataclass(frozen=True)
class Accent:
    """A syllable that stands out: the vowel's ``start`` and ``end`` in seconds, and by how much (about 0.25 to 2)."""

    start: float
    end: float
    prominence: float
    word: str


class HandMadeProsody:
    """Brow raises, nods, and what marks the end of a phrase or a question.

    Parameters
    ----------
    strength : float
        0 (nothing moves) to 1.

    Raises
    ------
    InputError
        If the strength is out of range.
    """

    def __init__(self, strength: float = DEFAULT_STRENGTH, table: str = "prosody.toml") -> None:
        if not 0 <= strength <= 1:
            raise InputError(f"a strength of visual prosody runs from 0 (off) to 1, not {strength:g}")
        self.strength = strength
        self._table = read_table(table)
        self._brow = pose_vector(self._table["brow"]["pose"], f"{table}, brow")

    def perform(
        self, utterance: Utterance, words: Sequence[StressedWord], rate: FrameRate, random: np.random.Generator
    ) -> Floats:
        """Channels of brows, head and eyes for every frame that covers the sound, shape (frames, channels).

        ``words`` are those of the utterance (`mien.speech.stressed_vowels.stressed_words`).
        """
        times = rate.times(rate.frames_covering(utterance.duration))
        values = np.zeros((len(times), len(channels.ALL)), order="F")  # channels that rest take no memory
        if self.strength == 0 or not words:
            return values
        brow, pitch, roll = np.zeros(len(times)), np.zeros(len(times)), np.zeros(len(times))
        for accent in self.accents(words):
            chance, near = random.random(2), _near(times, accent.start, accent.end)
            brow[near] = np.maximum(brow[near], self._raised(times[near], accent, chance[0]))
            pitch[near] += self._nod(times[near], accent, chance[1])
        for last, nxt in zip(words, [*words[1:], None], strict=True):
            pause = (nxt.start if nxt else utterance.duration + 1.0) - last.end
            if pause >= self._table["end"]["shortest_pause"]:
                near = _near(times, last.start, last.end)
                side = 1.0 if random.random() < 0.5 else -1.0
                if last.mark == "?":
                    raised, up, tipped = self._question(times[near], last, side)
                    brow[near] = np.maximum(brow[near], raised)
                    pitch[near] += up
                    roll[near] += tipped
                else:
                    pitch[near] -= self._sinking(times[near], last)
        moved = np.flatnonzero(self._brow)
        values[:, moved] = brow[:, None] * self._brow[moved]
        values[:, _PITCH], values[:, _ROLL] = pitch, roll
        turned = pitch / self._table["eyes"]["degrees"]
        values[:, _UP] = np.clip(-turned, 0, None)[:, None]
        values[:, _DOWN] = np.clip(turned, 0, None)[:, None]
        for place in {*moved, _PITCH, _ROLL, *_UP, *_DOWN}:
            values[:, place] *= self.strength
        return values

    def accents(self, words: Sequence[StressedWord]) -> list[Accent]:
        """Syllables that stand out, in order of time, none nearer to a stronger one than the table allows."""
        rule = self._table["prominence"]
        found = [
            Accent(word.vowel_start, word.vowel_end, value, word.text)
            for word, value in zip(words, self.prominences(words), strict=True)
            if value >= rule["least"]
        ]
        kept: list[Accent] = []  # in order of time
        for accent in sorted(found, key=lambda accent: -accent.prominence):
            place = bisect_left(kept, accent.start, key=lambda other: other.start)
            if all(abs(accent.start - other.start) >= rule["apart"] for other in kept[max(0, place - 1) : place + 1]):
                kept.insert(place, accent)
        return kept

    def prominences(self, words: Sequence[StressedWord]) -> Floats:
        """How far the stressed syllable of each word stands out of the phrase about it, shape (words,)."""
        rule: dict[str, float] = self._table["prominence"]
        middles = np.array([(word.vowel_start + word.vowel_end) / 2 for word in words])
        lengths = np.log([max(word.vowel_end - word.vowel_start, 0.01) for word in words])
        columns = {
            "pitch": np.array([word.pitch for word in words]),
            "level": np.array([word.level for word in words]),
        }
        phrase = (
            np.searchsorted(middles, middles - rule["about"]),
            np.searchsorted(middles, middles + rule["about"], "right"),
        )
        value = rule["length"] * np.clip((lengths - np.median(lengths)) / rule["length_unit"], -1.5, 2)
        for name, column in columns.items():
            about = np.array([_median(column[first:after]) for first, after in zip(*phrase, strict=True)])
            over = np.nan_to_num((column - about) / rule[f"{name}_unit"])
            value += rule[name] * np.clip(over, -1.5, 2)
        value += rule["weak_word"] * np.array([word.weak for word in words])
        value += rule["last_of_phrase"] * np.array([bool(word.mark) and not word.weak for word in words])
        return np.asarray(value + (rule["least"] if len(words) == 1 else 0.0))

    def _raised(self, times: Floats, accent: Accent, chance: float) -> Floats:
        rule = self._table["brow"]
        if chance >= _between(rule["share"], accent.prominence, self._least):
            return np.zeros(len(times))
        start = accent.start - rule["lead"]
        shape = _hill(times, start, rule["rise"], max(accent.end, start + rule["rise"]), rule["fall"])
        return np.asarray(_between(rule["amount"], accent.prominence, self._least) * shape)

    def _nod(self, times: Floats, accent: Accent, chance: float) -> Floats:
        rule = self._table["nod"]
        if chance >= _between(rule["share"], accent.prominence, self._least):
            return np.zeros(len(times))
        middle = (accent.start + accent.end) / 2
        down = _hill(times, middle - rule["rise"], rule["rise"], middle, rule["fall"])
        lift = _hill(times, middle - 2 * rule["rise"], rule["rise"] * 0.8, middle - rule["rise"], rule["rise"])
        return np.asarray(_between(rule["degrees"], accent.prominence, self._least) * (rule["before"] * lift - down))

    def _sinking(self, times: Floats, word: StressedWord) -> Floats:
        rule = self._table["end"]
        return np.asarray(
            rule["degrees"] * _hill(times, word.end - rule["settle"], rule["settle"], word.end + 0.1, rule["return"])
        )

    def _question(self, times: Floats, word: StressedWord, side: float) -> tuple[Floats, Floats, Floats]:
        rule = self._table["question"]
        shape = _hill(times, word.vowel_start - rule["rise"] / 2, rule["rise"], word.end + rule["hold"], rule["fall"])
        return rule["brow"] * shape, rule["degrees"] * shape, side * rule["roll"] * shape

    @property
    def _least(self) -> float:
        return float(self._table["prominence"]["least"])


def _median(values: Floats) -> float:
    """Of what is known of them; NaN if nothing is."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")


def _near(times: Floats, start: float, end: float) -> slice:
    """The frames about a stretch: nothing that is done to it reaches farther, and a long line has many of them."""
    return slice(*np.searchsorted(times, [start - _REACH, end + _REACH]).tolist())


def _between(pair: Any, prominence: float, least: float) -> float:
    """From the first figure at the least prominence to the second at `_FULL`."""
    return float(np.interp(prominence, [least, _FULL], pair))


def _hill(times: Floats, start: float, rise: float, end: float, fall: float) -> Floats:
    """0 until ``start``, 1 from ``start + rise`` to ``end``, 0 from ``end + fall``; flanks of least jerk.

    (10 s^3 - 15 s^4 + 6 s^5, Flash and Hogan 1985.)
    """
    end = max(end, start + rise)
    up = np.clip((times - start) / rise, 0, 1)
    down = np.clip((times - end) / fall, 0, 1)
    return np.asarray(_smooth(up) * (1 - _smooth(down)))


def _smooth(s: Floats) -> Floats:
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2))
