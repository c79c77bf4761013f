"""Many moments against many stretches of time, at a cost that grows with both and not with their product."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Interval

__all__ = ["is_within", "places_within", "seconds_away"]

Floats = NDArray[np.float64]


def is_within(spans: Sequence[Interval], times: Floats) -> NDArray[np.bool_]:
    """Whether each moment lies in one of some stretches.

    Parameters
    ----------
    spans : sequence of Interval
        In order, not overlapping.
    times : ndarray, shape (times,)
        Seconds, in any order.

    Examples
    --------
    >>> is_within((Interval(0.0, 1.0, "a"), Interval(2.0, 3.0, "b")), np.array([0.5, 1.0, 2.0, 3.0])).tolist()
    [True, False, True, False]
    """
    ends = np.array([-np.inf, *(span.end for span in spans)])
    return np.asarray(times < ends[np.searchsorted([span.start for span in spans], times, side="right")])


def seconds_away(spans: Sequence[Interval], times: Floats) -> Floats:
    """Seconds from each moment to the nearest of some stretches: 0 inside, infinite if there is none.

    Parameters
    ----------
    spans : sequence of Interval
        In order, not overlapping.
    times : ndarray, shape (times,)
        Seconds, in any order.

    Examples
    --------
    >>> seconds_away((Interval(0.0, 1.0, "a"), Interval(2.0, 3.0, "b")), np.array([0.5, 1.25, 1.75, 4.0])).tolist()
    [0.0, 0.25, 0.25, 1.0]
    """
    starts = np.array([-np.inf, *(span.start for span in spans), np.inf])
    ends = np.array([-np.inf, *(span.end for span in spans)])
    place = np.searchsorted(starts[1:-1], times, side="right")
    return np.asarray(np.maximum(np.minimum(times - ends[place], starts[place + 1] - times), 0.0))


def places_within(times: Floats, start: float, end: float) -> slice:
    """Where moments in order of time lie from ``start`` to ``end``, both included.

    Examples
    --------
    >>> places_within(np.array([0.0, 0.5, 1.0, 1.5]), 0.5, 1.2)
    slice(1, 3, None)
    """
    return slice(int(np.searchsorted(times, start)), int(np.searchsorted(times, end, side="right")))
