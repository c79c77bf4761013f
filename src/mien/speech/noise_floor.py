"""How loud the noise is in each band, and what is left without it, from sound that is still coming in.

The estimate follows the lower envelope of the power quickly down and slowly up; what lies above it is speech, weak
bands just after strong ones are masked, and the gain is smoothed over neighbouring bands: the noise removal of CMU
Sphinx (after Kim, Stern 2012, "Power-normalized cepstral coefficients", whose asymmetric filter it is).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["NoiseFloor"]

_SMOOTH = 0.7
_RISE, _FALL = 0.995, 0.5
_FORGET, _MASKED = 0.85, 0.2
_MOST_GAIN = 20.0
_REACH = 4
_LEAST = 1.0  # power of 16-bit sound that is nothing

Floats = NDArray[np.float64]


class NoiseFloor:
    """Takes powers of bands row by row and gives them back without their noise.

    Parameters
    ----------
    bands : int

    Examples
    --------
    >>> floor = NoiseFloor(3)
    >>> hiss = np.full((200, 3), 1e6)
    >>> bool(np.all(floor.push(hiss)[-1] < 0.2e6))
    True
    >>> floor.noise.round(-3).tolist()
    [1000000.0, 1000000.0, 1000000.0]
    """

    def __init__(self, bands: int) -> None:
        self.noise: Floats = np.zeros(bands)
        """Power of the noise in each band, as it is now believed."""
        self._power: Floats | None = None
        self._signal, self._peak = np.zeros(bands), np.zeros(bands)
        places = np.arange(bands)
        self._low, self._high = np.maximum(places - _REACH, 0), np.minimum(places + _REACH, bands - 1) + 1

    def push(self, powers: Floats) -> Floats:
        """Powers of some rows without the noise, shape (rows, bands)."""
        found = np.empty_like(powers)
        for row, power in zip(found, powers, strict=True):
            if self._power is None:
                self._power, self.noise, self._signal = power.copy(), power.copy(), power / _MOST_GAIN
            self._power = _SMOOTH * self._power + (1 - _SMOOTH) * power
            self.noise = _followed(self.noise, self._power)
            signal = np.maximum(self._power - self.noise, _LEAST)
            self._signal = _followed(self._signal, signal)
            peak = self._peak * _FORGET
            self._peak = np.maximum(signal, peak)
            signal = np.maximum(np.where(signal < _FORGET * peak, peak * _MASKED, signal), self._signal)
            gain = np.clip(signal / np.maximum(self._power, 1e-9), 1 / _MOST_GAIN, _MOST_GAIN)
            sums = np.concatenate([[0.0], np.cumsum(gain)])
            row[:] = power * (sums[self._high] - sums[self._low]) / (self._high - self._low)
        return found


def _followed(envelope: Floats, value: Floats) -> Floats:
    keep = np.where(value >= envelope, _RISE, _FALL)
    return np.asarray(keep * envelope + (1 - keep) * value)
