"""As large and as quick as recorded: what least squares takes off a motion is given back.

A model that minimises a squared error answers with means, and means are smaller and slower than what they are the mean
of. Toda and Tokuda 2007 ("A speech parameter generation algorithm considering global variance") met the same in
speech synthesis. Here each component ``c(t)`` of the answer is made to have the variance and the mean squared velocity
of the recordings:

    y(t) = o + g (c(t) - o + s (2 c(t) - c(t - d) - c(t + d)))

g is its gain and s its sharpness, both learned; d is `APART`, o the mouth at rest where it is known (lips that are shut
stay shut, and those that are nearly shut, as in /w/, stay nearly so), else the mean. Where a component is hardly
predicted at all, its gain is held back (`MOST_GAIN`): what is not known cannot be made larger.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

__all__ = ["APART", "RecordedSpread", "instants_about"]

APART = 0.04
"""Seconds (d): as far apart as the frames of most cameras."""
MOST_GAIN = 1.4
MOST_SHARPNESS = 0.3
_STEP = 0.01
_BLOCK = 4096  # frames

Floats = NDArray[np.float64]


def instants_about(times: Floats) -> Floats:
    """The instants at which components are needed: before, at and after each time, shape (3 * frames,)."""
    return np.concatenate([times - APART, times, times + APART])


class RecordedSpread:
    """Gain and sharpness of components.

    Attributes
    ----------
    centre_, gain_, sharpness_ : ndarray, shape (components,)
    """

    def fit(self, recorded: Sequence[Floats], answered: Sequence[Floats], rest: Floats | None = None) -> Self:
        """Learn from pieces of recorded motion and what the model answers there.

        Parameters
        ----------
        recorded : sequence of ndarray, shape (frames, components)
            Neighbouring rows are neighbouring frames.
        answered : sequence of ndarray, shape (3 * frames, components)
            At `instants_about` the same frames.
        rest : ndarray, shape (components,), or None
            The mouth at rest; None takes the mean of what is answered.
        """
        before, at, after = (np.concatenate(parts) for parts in zip(*(np.split(a, 3) for a in answered), strict=True))
        bend = 2 * at - before - after
        borders = np.cumsum([len(piece) for piece in recorded])[:-1]
        self.centre_ = at.mean(axis=0) if rest is None else rest
        wanted = np.concatenate(recorded).std(axis=0)
        wanted_speed = _speed(np.concatenate(recorded), borders)
        count = at.shape[1]
        self.gain_, self.sharpness_ = np.ones(count), np.zeros(count)
        for k in range(count):
            best = np.inf
            for sharpness in np.arange(0.0, MOST_SHARPNESS + _STEP / 2, _STEP):
                curve = at[:, k] + sharpness * bend[:, k]
                spread = float(curve.std())
                if spread <= 0 or wanted_speed[k] <= 0:
                    break
                gain = float(np.clip(wanted[k] / spread, 1.0, MOST_GAIN))
                missed = abs(np.log(max(gain * float(_speed(curve[:, None], borders)[0]), 1e-12) / wanted_speed[k]))
                if missed < best:
                    best, self.gain_[k], self.sharpness_[k] = missed, gain, sharpness
        return self

    def restore(self, centre: Floats, gain: Floats, sharpness: Floats) -> Self:
        """Take what was learned before."""
        self.centre_, self.gain_, self.sharpness_ = centre, gain, sharpness
        return self

    def of(self, answer: Callable[[Floats], Floats], times: Floats) -> Floats:
        """What a model answers at the given times, as large and as quick as recorded, shape (frames, components)."""
        found = np.empty((len(times), len(self.centre_)))
        for first in range(0, len(times), _BLOCK):  # a long line is not held many times over
            here = slice(first, first + _BLOCK)
            before, at, after = np.split(answer(instants_about(times[here])), 3)
            away = at - self.centre_ + self.sharpness_ * (2 * at - before - after)
            found[here] = self.centre_ + self.gain_ * away
        return found


def _speed(curves: Floats, borders: NDArray[np.int64]) -> Floats:
    """Root of the mean squared step from frame to frame, shape (components,); not across ``borders``."""
    steps = np.delete(np.diff(curves, axis=0), borders - 1, axis=0)
    return np.asarray(np.sqrt((steps**2).mean(axis=0))) if len(steps) else np.zeros(curves.shape[1])
