"""Jitter: what shakes faster than a face can.

Conventions
-----------
Positions are arrays of shape (frames, markers, 3) in millimetres. The third difference of a smooth motion is nearly
nothing; that of noise which is independent from frame to frame has 1 + 9 + 9 + 1 = 20 times its variance. Jitter is
therefore given as the size of such noise, in mm. Fast speech leaves some third difference too, more at a low frame
rate: compare with the recording's own figure at the same rate, and not with zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["jitter", "third_differences", "validate"]

Array = NDArray[np.float64]


def validate(positions: Array) -> None:
    """Refuse positions that are not (at least 4 frames, markers, 3) and finite."""
    if positions.ndim != 3 or positions.shape[2] != 3 or len(positions) < 4 or not positions.shape[1]:
        raise InputError(f"jitter needs positions of shape (at least 4 frames, markers, 3), got {positions.shape}")
    if not np.isfinite(positions).all():
        raise InputError("jitter needs finite positions; leave out the frames where a marker was not seen")


def third_differences(positions: Array) -> Array:
    """Squared length of the third difference, divided by 20: shape (frames - 3, markers), mm²."""
    validate(positions)
    return np.asarray((np.diff(positions, n=3, axis=0) ** 2).sum(axis=2) / 20.0)


def jitter(positions: Array) -> float:
    """Root of the mean squared third difference over 20, in mm: the noise (3D, RMS) that would look like this.

    Raises
    ------
    InputError
        As `validate`.

    Examples
    --------
    Motion along a parabola has none; noise of 0.1 mm on each axis is found again as 0.1 times the root of 3:

    >>> path = np.arange(50.0)[:, None, None] ** 2 * np.ones((1, 3, 3))
    >>> jitter(path) < 1e-9
    True
    >>> noise = np.random.default_rng(0).normal(0, 0.1, (5000, 3, 3))
    >>> round(jitter(noise), 2)
    0.17
    """
    return float(np.sqrt(third_differences(positions).mean()))
