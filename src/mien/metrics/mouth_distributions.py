"""Distributions that add up over takes: how fast the lips move, how often they turn, how far each class opens.

Each is a histogram (or a count), so that the tallies of takes can be added and a bootstrap over takes is a product.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.metrics.dynamics import CLASSES, openings_by_class, turns

__all__ = ["distributions", "median_of", "p99_of", "range_of"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SPEEDS = np.arange(0.0, 1002.0, 2.0)  # mm/s
_OPENINGS = np.arange(0.0, 50.1, 0.1)  # mm


def distributions(opening: Array, times: Array, phones: Tier, counted: Mask) -> dict[str, Array]:
    """What is counted in one take: ``speeds``, ``turns`` (count, seconds), ``opening CLASS`` (`CLASSES`).

    Parameters
    ----------
    opening : ndarray, shape (frames,)
        Millimetres.
    times : ndarray, shape (frames,)
        Seconds, evenly spaced.
    phones : Tier
    counted : ndarray of bool, shape (frames,)
    """
    step = float(times[1] - times[0]) if len(times) > 1 else 1.0
    both = counted[:-1] & counted[1:]
    found = {
        "speeds": _histogram(np.abs(np.diff(opening))[both] / step, _SPEEDS),
        "turns": np.array([turns(opening[counted]), counted.sum() * step]),
    }
    by_class = openings_by_class(opening, phones, times, counted)
    return found | {f"opening {kind}": _histogram(by_class.get(kind, np.empty(0)), _OPENINGS) for kind in CLASSES}


def p99_of(counts: Array) -> Array:
    """The 99th percentile of speeds, mm/s, from histograms of shape (..., bins): shape (...)."""
    return _percentile(0.99, _SPEEDS)(counts)


def median_of(counts: Array) -> Array:
    """The median of openings, mm, from histograms of shape (..., bins): shape (...)."""
    return _percentile(0.5, _OPENINGS)(counts)


def range_of(counts: Array) -> Array:
    """From a quarter to three quarters of the openings, mm, from histograms of shape (..., bins): shape (...)."""
    return np.asarray(_percentile(0.75, _OPENINGS)(counts) - _percentile(0.25, _OPENINGS)(counts))


def _histogram(values: Array, edges: Array) -> Array:
    inside = np.clip(values, edges[0], edges[-1] - 1e-9)
    return np.histogram(inside, edges)[0].astype(np.float64)


def _percentile(share: float, edges: Array) -> Callable[[Array], Array]:
    """By straight lines inside a bin; NaN for an empty histogram."""

    def value(counts: Array) -> Array:
        rows = counts.reshape(-1, counts.shape[-1])
        sums = np.cumsum(rows, axis=1)
        wanted = share * sums[:, -1:]
        place = np.argmax(sums >= wanted, axis=1)
        every = np.arange(len(rows))
        inside = rows[every, place]
        before = sums[every, place] - inside
        with np.errstate(invalid="ignore", divide="ignore"):
            part = np.where(inside > 0, (wanted[:, 0] - before) / inside, 0.0)
        found = edges[place] + part * (edges[1] - edges[0])
        return np.where(sums[:, -1] > 0, found, np.nan).reshape(counts.shape[:-1])

    return value
