"""Motion without an end, made block by block: signs of life and an expression for a stream that may go on for hours.

Models make motion for a stretch of known length. Here stretches follow one another: each begins `OVERLAP` before the
one ahead of it ends, and takes over on a half cosine. Lids are never faded, which would show half a blink: the more
closed of the two is shown.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.motion.performer import ExpressionModel, IdleModel
from mien.text.score import UNDIRECTED, Score

__all__ = ["BLOCK", "OVERLAP", "EndlessMotion", "endless_expression", "endless_idle"]

Floats = NDArray[np.float64]

BLOCK, OVERLAP = 12.0, 0.8
"""Seconds of a stretch, and of it that it shares with the next one."""
_LIDS = [channels.ALL.index(f"eyeBlink{side}") for side in ("Left", "Right")]


class EndlessMotion:
    """Frames one after another.

    Parameters
    ----------
    make : callable (duration, generator) -> ndarray, shape (frames, channels)
        Makes one stretch that covers ``duration`` seconds.
    rate : FrameRate
    random : numpy.random.Generator
        The same generator gives the same motion.
    """

    def __init__(
        self, make: Callable[[float, np.random.Generator], Floats], rate: FrameRate, random: np.random.Generator
    ) -> None:
        self._make, self._random = make, random
        self._overlap = max(1, rate.frames_covering(OVERLAP))
        self._block = self._make(BLOCK, random)
        self._place = 0

    def next(self) -> Floats:
        """The next frame, shape (channels,)."""
        if self._place == len(self._block) - self._overlap:
            self._block = self._joined(self._block[self._place :], self._make(BLOCK, self._random))
            self._place = 0
        self._place += 1
        return np.asarray(self._block[self._place - 1].copy())

    def _joined(self, old: Floats, new: Floats) -> Floats:
        share = (1 - np.cos(np.pi * (np.arange(len(old)) + 0.5) / len(old)))[:, None] / 2
        lids = np.maximum(old[:, _LIDS], new[: len(old), _LIDS])
        new[: len(old)] = (1 - share) * old + share * new[: len(old)]
        new[: len(old), _LIDS] = lids
        return new


def endless_idle(
    idle: IdleModel, rate: FrameRate, random: np.random.Generator, score: Score = UNDIRECTED
) -> EndlessMotion:
    """Blinks, glances and head motion, with no regard to what is said; the score's emotions do not change."""

    def make(duration: float, draws: np.random.Generator) -> Floats:
        pause = Tier("phones", (Interval(0.0, duration, PAUSE),))
        nothing = Utterance("", Audio.silence(duration, 1000), Tier("words", ()), pause, "und", "none")
        return idle.perform(nothing, rate, draws, score)

    return EndlessMotion(make, rate, random)


def endless_expression(
    expression: ExpressionModel, score: Score, rate: FrameRate, random: np.random.Generator
) -> EndlessMotion:
    """The emotions of a score that do not change with time."""

    def make(duration: float, draws: np.random.Generator) -> Floats:
        return expression.perform(score, duration, rate, draws)

    return EndlessMotion(make, rate, random)
