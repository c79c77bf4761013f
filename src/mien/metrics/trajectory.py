"""Lip opening and mouth width over time, their speed, and how alike two such curves are.

Conventions
-----------
A curve is an array of shape (frames,): millimetres for an opening or a width, millimetres per second for its
velocity. Lip opening is the distance of the middles of the inner lips (MediaPipe landmarks 13 and 14), mouth width
the distance of the corners (61 and 291).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = [
    "bias_of",
    "correlation",
    "correlation_of",
    "error_without_bias_of",
    "moments",
    "rms_error",
    "rms_error_of",
    "separation",
    "spread_of",
    "validate",
    "velocity",
]

_STILL = 1e-12
"""Share of a curve's power below which what varies in it is rounding."""

Array = NDArray[np.float64]


def validate(recorded: Array, synthesised: Array) -> None:
    """Refuse curves that cannot be compared.

    Raises
    ------
    InputError
        If they are not of one length, are empty, or hold a number that is not finite.
    """
    if recorded.shape != synthesised.shape or recorded.ndim != 1 or not len(recorded):
        raise InputError(f"expected two curves of one length, got shapes {recorded.shape} and {synthesised.shape}")
    if not (np.isfinite(recorded).all() and np.isfinite(synthesised).all()):
        raise InputError("expected curves of finite numbers; leave out the frames where a marker was not seen")


def separation(positions: Array, one: int, other: int) -> Array:
    """Distance of two markers in every frame, shape (frames,), mm.

    Examples
    --------
    >>> separation(np.array([[[0.0, 0.0, 0.0], [0.0, 3.0, 4.0]]]), 0, 1)
    array([5.])
    """
    return np.asarray(np.linalg.norm(positions[:, one] - positions[:, other], axis=1))


def velocity(curve: Array, fps: float) -> Array:
    """Change to the next frame times the rate, shape (frames,), mm/s; the last frame repeats the one before it.

    Examples
    --------
    >>> velocity(np.array([0.0, 1.0, 3.0]), 25.0)
    array([25., 50., 50.])
    """
    if len(curve) < 2:
        return np.zeros(len(curve))
    steps = np.diff(curve) * fps
    return np.append(steps, steps[-1])


def moments(recorded: Array, synthesised: Array) -> Array:
    """What correlation and error are made from: n, Σx, Σy, Σx², Σy², Σxy, shape (6,).

    Moments of several stretches add up to those of all their frames together.

    Raises
    ------
    InputError
        As `validate`.
    """
    validate(recorded, synthesised)
    x, y = recorded, synthesised
    return np.array([len(x), x.sum(), y.sum(), (x * x).sum(), (y * y).sum(), (x * y).sum()])


def correlation_of(moments: Array) -> Array:
    """Pearson's correlation from moments of shape (..., 6): shape (...); NaN where a curve does not move."""
    n, x, y, xx, yy, xy = np.moveaxis(moments, -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        spread_x, spread_y = xx - x * x / n, yy - y * y / n
        moves = (spread_x > _STILL * xx) & (spread_y > _STILL * yy)
        return np.where(moves, (xy - x * y / n) / np.sqrt(spread_x * spread_y), np.nan)


def spread_of(moments: Array) -> Array:
    """Standard deviation of the synthesised curve over that of the recorded one, from moments; NaN for a still one.

    Examples
    --------
    >>> float(spread_of(moments(np.array([0.0, 1.0, 2.0]), np.array([5.0, 5.5, 6.0]))))
    0.5
    """
    n, x, y, xx, yy, _ = np.moveaxis(moments, -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        recorded, synthesised = xx - x * x / n, yy - y * y / n
        spread = np.sqrt(np.maximum(synthesised, 0.0) / recorded)
        return np.where(recorded > _STILL * xx, np.where(synthesised > _STILL * yy, spread, 0.0), np.nan)


def error_without_bias_of(moments: Array) -> Array:
    """Root of the mean squared difference without its mean, from moments of shape (..., 6): shape (...)."""
    n, x, y, xx, yy, xy = np.moveaxis(moments, -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(np.maximum((xx - 2 * xy + yy) / n - ((y - x) / n) ** 2, 0.0)))


def bias_of(moments: Array) -> Array:
    """Mean of synthesised less recorded from moments of shape (..., 6): shape (...)."""
    n, x, y = np.moveaxis(moments, -1, 0)[:3]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((y - x) / n)


def rms_error_of(moments: Array) -> Array:
    """Root of the mean squared difference from moments of shape (..., 6): shape (...)."""
    n, _, _, xx, yy, xy = np.moveaxis(moments, -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(np.maximum(xx - 2 * xy + yy, 0.0) / n))


def correlation(recorded: Array, synthesised: Array) -> float:
    """Pearson's correlation coefficient, -1..1; NaN where one of the curves does not move at all.

    Raises
    ------
    InputError
        As `validate`.

    Examples
    --------
    >>> round(correlation(np.array([0.0, 1.0, 2.0]), np.array([5.0, 7.0, 9.0])), 12)
    1.0
    """
    return float(correlation_of(moments(recorded, synthesised)))


def rms_error(recorded: Array, synthesised: Array) -> float:
    """Root of the mean squared difference, in the unit of the curves.

    Raises
    ------
    InputError
        As `validate`.

    Examples
    --------
    >>> rms_error(np.array([0.0, 0.0]), np.array([3.0, -3.0]))
    3.0
    """
    return float(rms_error_of(moments(recorded, synthesised)))
