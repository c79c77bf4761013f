"""Is the mouth on time?

Conventions
-----------
* Curves are lip openings, shape (frames,), mm; lags are in milliseconds. A lag above zero means that the synthesised
  mouth comes later than the recorded one.
* ITU-R BT.1359-1 (1998) speaks of the sound: advanced (+) or delayed (-) against the picture. A mouth that is late is
  a sound that is advanced, so the signs agree: people notice beyond +45 ms and -125 ms, and object beyond
  +90 and -185 ms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.metrics.trajectory import correlation, validate

__all__ = ["DETECTABLE_MS", "is_undetectable", "lag_of_best_correlation", "onset", "onset_lag", "validate"]

DETECTABLE_MS = (-125.0, 45.0)
"""ITU-R BT.1359-1: a shift between these is not noticed."""
MOST_LAG = 0.2
"""Seconds to each side within which the best lag is looked for."""
ONSET_BEFORE, ONSET_AFTER = 0.2, 0.4
"""Seconds about the first phone in which the mouth's first opening is looked for."""
_LEAST_RISE = 1.0  # mm; a mouth that opens less has no onset

Array = NDArray[np.float64]


def is_undetectable(lag_ms: float) -> bool:
    """Whether a lag lies within ITU-R BT.1359-1's thresholds of detection.

    Examples
    --------
    >>> is_undetectable(40.0), is_undetectable(50.0), is_undetectable(-120.0)
    (True, False, True)
    """
    return DETECTABLE_MS[0] <= lag_ms <= DETECTABLE_MS[1]


def lag_of_best_correlation(recorded: Array, synthesised: Array, fps: float) -> float:
    """Milliseconds by which the synthesised curve lags where it fits the recorded one best.

    Correlation is taken at whole frames up to `MOST_LAG` to each side, over the frames that both have; a parabola
    through the best and its neighbours gives the part of a frame. NaN if a curve does not move.

    Raises
    ------
    InputError
        If the curves cannot be compared or ``fps`` is not above 0.

    Examples
    --------
    >>> time = np.arange(100) / 25
    >>> recorded, late = np.sin(9 * time), np.sin(9 * (time - 0.08))
    >>> round(lag_of_best_correlation(recorded, late, 25.0))
    80
    """
    validate(recorded, synthesised)
    if not fps > 0:
        raise InputError(f"a frame rate is above 0, not {fps}")
    most = min(round(MOST_LAG * fps), len(recorded) // 2)
    lags = np.arange(-most, most + 1)
    scores = np.array([_correlation_at(recorded, synthesised, int(lag)) for lag in lags])
    if np.isnan(scores).all():
        return float("nan")
    best = int(np.nanargmax(scores))
    part = 0.0
    if 0 < best < len(scores) - 1:
        left, middle, right = scores[best - 1 : best + 2]
        bend = left - 2 * middle + right
        part = float(0.5 * (left - right) / bend) if bend < 0 else 0.0
    return float((lags[best] + part) / fps * 1000.0)


def _correlation_at(recorded: Array, synthesised: Array, lag: int) -> float:
    """Correlation of the recorded curve with the synthesised one taken ``lag`` frames later."""
    if len(recorded) - abs(lag) < 2:
        return float("nan")
    one = recorded[: len(recorded) - lag] if lag >= 0 else recorded[-lag:]
    other = synthesised[lag:] if lag >= 0 else synthesised[:lag]
    return correlation(one, other)


def onset(opening: Array, times: Array, first_phone: float) -> float:
    """Seconds at which the lips are first half-way to their first opening; NaN if they hardly open.

    Looked for from 0.2 s before the start of the first phone to 0.4 s after it: half-way between the least opening
    ahead of the greatest one and the greatest one, as last passed on the way up; between frames by a straight line.

    Examples
    --------
    >>> times = np.arange(25) / 25
    >>> onset(np.clip((times - 0.4) * 50, 0, 10), times, first_phone=0.4)
    0.5
    """
    validate(opening, times)
    held = (times >= first_phone - ONSET_BEFORE) & (times <= first_phone + ONSET_AFTER)
    part, clock = opening[held], times[held]
    if len(part) < 2:
        return float("nan")
    top = int(part.argmax())
    least = float(part[: top + 1].min())
    if part[top] - least < _LEAST_RISE:
        return float("nan")
    half = (least + float(part[top])) / 2
    below = int(np.flatnonzero(part[: top + 1] < half)[-1])
    share = (half - part[below]) / (part[below + 1] - part[below])
    return float(round(clock[below] + share * (clock[below + 1] - clock[below]), 9))


def onset_lag(recorded: Array, synthesised: Array, times: Array, first_phone: float) -> float:
    """Milliseconds by which the synthesised mouth first opens later than the recorded one; NaN if one does not open."""
    return (onset(synthesised, times, first_phone) - onset(recorded, times, first_phone)) * 1000.0
