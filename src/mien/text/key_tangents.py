"""Curves through keys that each say how the curve comes to them and leaves them, as animators set tangents."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import unknown_name

__all__ = ["TANGENTS", "check_tangents", "tangents_of", "through_tangents"]

Floats = NDArray[np.float64]
TANGENTS = ("auto", "flat", "linear", "step")
_LIKE = {"spline": "auto", "smooth": "flat", "linear": "linear", "hold": "step"}


def check_tangents(tangents: Sequence[str | None], keys: int) -> None:
    """Raise unless there is one for each key, or none at all.

    Raises
    ------
    InputError
        If one is not known.
    """
    for tangent in tangents:
        if tangent is not None and tangent not in TANGENTS:
            raise unknown_name("tangent", str(tangent)[:40], TANGENTS)
    if len(tangents) not in (0, keys):
        raise unknown_name("number of tangents", str(len(tangents)), ("0", str(keys)))


def tangents_of(tangents: Sequence[str | None], interpolation: str) -> tuple[str, ...]:
    """The tangents of keys; those that say nothing have that of their curve's interpolation.

    Examples
    --------
    >>> tangents_of(("step", None), "smooth")
    ('step', 'flat')
    """
    return tuple(tangent or _LIKE[interpolation] for tangent in tangents)


def through_tangents(at: Floats, values: Floats, tangents: Sequence[str], now: Floats) -> Floats:
    """Values at instants of the curve through keys: cubics whose slopes at the keys are those that the keys ask for.

    Parameters
    ----------
    at, values : ndarray, shape (keys,)
        Times, never falling, and values.
    tangents : sequence of {"auto", "flat", "linear", "step"}
        ``"auto"``: no overshoot (the slopes of a monotone cubic, PCHIP); ``"flat"``: level at the key; ``"linear"``:
        straight at the neighbour, as far as that is too; ``"step"``: the key's value until the next key, and before
        it as the key before has it.
    now : ndarray
        Before the first and after the last key the value of that key.

    Examples
    --------
    >>> at, up = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0])
    >>> through_tangents(at, up, ("linear", "step", "flat"), np.array([-1.0, 0.5, 1.5, 2.0])).tolist()
    [0.0, 0.5, 1.0, 0.0]
    """
    if len(at) == 1:
        return np.full(now.shape, values[0])
    span = np.diff(at)
    chord = np.divide(np.diff(values), span, out=np.zeros_like(span), where=span > 0)
    smooth = np.zeros_like(values)
    if (span > 0).all():
        from scipy.interpolate import PchipInterpolator

        smooth = np.asarray(PchipInterpolator(at, values).derivative()(at), dtype=np.float64)
    slope = np.where([tangent == "flat" for tangent in tangents], 0.0, smooth)
    straight = np.array([tangent == "linear" for tangent in tangents])
    held = np.array([tangent == "step" for tangent in tangents])
    leaving = np.where(straight[:-1], chord, slope[:-1])
    coming = np.where(straight[1:] | (held[1:] & straight[:-1]), chord, slope[1:])
    moment = np.clip(now, at[0], at[-1])
    place = np.clip(np.searchsorted(at, moment, side="right") - 1, 0, len(at) - 2)
    width = span[place]
    x = np.divide(moment - at[place], width, out=np.ones_like(moment), where=width > 0)
    cubic = (
        values[place] * (1 + 2 * x) * (1 - x) ** 2
        + leaving[place] * width * x * (1 - x) ** 2
        + values[place + 1] * x**2 * (3 - 2 * x)
        - coming[place] * width * x**2 * (1 - x)
    )
    return np.where(held[place] & (x < 1), values[place], cubic)
