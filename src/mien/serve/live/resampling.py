"""Another sample rate, piece by piece, 2 ms late: libraries that do this well hold the sound back by 20 to 60 ms."""

from __future__ import annotations

from functools import lru_cache
from math import gcd

import numpy as np
from numpy.typing import NDArray

__all__ = ["LATE", "StreamResampler"]

LATE = 0.002
"""Seconds that the result needs of the sound after it."""
_CUT = 0.45  # of the lower rate: where the band ends
_BETA = 6.0  # of Kaiser's window: 60 dB


class StreamResampler:
    """A windowed sinc, laid about each sample of the result.

    Parameters
    ----------
    source, target : int
        Samples per second.

    Examples
    --------
    >>> resampler = StreamResampler(48000, 16000)
    >>> wave = np.sin(2 * np.pi * 440 * np.arange(4800) / 48000)
    >>> found = np.concatenate([resampler.push(piece) for piece in np.split(wave, 10)])
    >>> len(found)
    1568
    >>> bool(np.abs(found[50:] - np.sin(2 * np.pi * 440 * np.arange(50, len(found)) / 16000)).max() < 1e-3)
    True
    """

    def __init__(self, source: int, target: int) -> None:
        common = gcd(source, target)
        self._over, self._under = source // common, target // common  # sample n of the result stands at n over / under
        self._reach = round(LATE * source)
        self._weights = _weights(self._under, self._reach, 2 * _CUT * min(1.0, target / source))
        self._kept = np.zeros(self._reach)
        self._first = -self._reach  # number of the first sample that is kept
        self._made = 0  # samples of the result so far

    def push(self, samples: NDArray[np.floating]) -> NDArray[np.float64]:
        """The part of the result that these samples complete."""
        self._kept = np.concatenate([self._kept, samples])
        last = self._first + len(self._kept) - self._reach  # instants before this one have all that they need
        count = max(0, -(-last * self._under // self._over) - self._made)
        near, phase = np.divmod((self._made + np.arange(count)) * self._over, self._under)
        taps = near[:, None] + np.arange(1 - self._reach, self._reach + 1) - self._first
        result = np.einsum("nt,nt->n", self._kept[taps], self._weights[phase])
        self._made += count
        spare = self._made * self._over // self._under - self._reach - self._first
        if spare > 0:
            self._kept, self._first = self._kept[spare:], self._first + spare
        return np.asarray(result)


@lru_cache(maxsize=4)
def _weights(phases: int, reach: int, cut: float) -> NDArray[np.float64]:
    """For each place between two samples the weights of the samples about it, shape (phases, 2 reach)."""
    distance = np.arange(phases)[:, None] / phases - np.arange(1 - reach, reach + 1)
    return np.asarray(np.sinc(distance * cut) * cut * _window(distance / reach))


def _window(place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Kaiser's window, 0 outside -1..1."""
    return np.asarray(np.i0(_BETA * np.sqrt(np.clip(1 - place**2, 0, None))) / np.i0(_BETA) * (np.abs(place) < 1))
