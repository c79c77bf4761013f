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
from mien.core.utterance import PAUSE
from mien.metrics.face_track import FaceTrack
from mien.metrics.mouth import mouth_pair
from mien.metrics.pairing import Pair, frontal
from mien.metrics.trajectory import correlation, validate

__all__ = [
    "DETECTABLE_MS",
    "evaluate",
    "is_undetectable",
    "lag_of_best_correlation",
    "onset",
    "onset_lag",
    "validate",
    "validate_faces",
]

DETECTABLE_MS = (-125.0, 45.0)
"""ITU-R BT.1359-1: a shift between these is not noticed."""
MOST_LAG = 0.2
"""Seconds to each side within which the best lag is looked for."""
ONSET_BEFORE, ONSET_AFTER = 0.2, 0.4
"""Seconds about the first phone in which the mouth's first opening is looked for."""
MOST_LAG_OF_FACES = 0.5
"""The same for two files of which nobody said that they share a clock."""
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


def lag_of_best_correlation(recorded: Array, synthesised: Array, fps: float, most: float = MOST_LAG) -> float:
    """Milliseconds by which the synthesised curve lags where it fits the recorded one best.

    Correlation is taken at whole frames up to ``most`` seconds to each side, over the frames that both have; a parabola
    through the best and its neighbours gives the part of a frame. NaN if a curve does not move, or if it fits best at
    the end of that range: the true lag may lie beyond it.

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
    reach = min(round(most * fps), len(recorded) // 2)
    lags = np.arange(-reach, reach + 1)
    scores = np.array([_correlation_at(recorded, synthesised, int(lag)) for lag in lags])
    if np.isnan(scores).all():
        return float("nan")
    best = int(np.nanargmax(scores))
    if not 0 < best < len(scores) - 1:
        return float("nan")
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


# ------------------------------------------------------------ of two faces in motion


def validate_faces(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces whose lips cannot be compared (`mien.metrics.mouth.mouth_pair`)."""
    mouth_pair(reference, estimate)


def evaluate(
    reference: FaceTrack, estimate: FaceTrack, *, counted: NDArray[np.bool_] | None = None
) -> dict[str, float]:
    """Find the time between two mouths.

    Returns
    -------
    dict of str to float
        ``lag_ms``: shift at which the openings correlate best, NaN if a mouth does not move or no shift within
        `MOST_LAG_OF_FACES` is best; ``opening_r_at_lag``: the correlation there, by whole frames; ``lag_unnoticed``:
        1 if the lag lies between -125 and +45 ms (ITU-R BT.1359-1), 0 if not; ``onset_lag_ms``: difference of the first
        openings, where phones are known.

    Raises
    ------
    InputError
        As `validate_faces`.
    """
    pair, sites = mouth_pair(reference, estimate, counted)
    one, other = (frontal(positions, *sites.opening) for positions in (pair.reference, pair.estimate))
    first, last = np.flatnonzero(pair.counted)[[0, -1]]
    stretch = [_bridged(curve, pair)[first : last + 1] for curve in (one, other)]
    lag = lag_of_best_correlation(stretch[0], stretch[1], pair.fps, MOST_LAG_OF_FACES)
    scores = {
        "lag_ms": lag,
        "opening_r_at_lag": _at(stretch[0], stretch[1], round(lag * pair.fps / 1000)) if np.isfinite(lag) else lag,
        "lag_unnoticed": float(is_undetectable(lag)) if np.isfinite(lag) else float("nan"),
    }
    phones = reference.phones or estimate.phones
    spoken = [phone for phone in phones or () if phone.label not in (PAUSE, "")]
    if spoken:
        seen = np.isfinite(one) & np.isfinite(other)
        scores["onset_lag_ms"] = onset_lag(one[seen], other[seen], pair.times[seen], spoken[0].start)
    return scores


def _bridged(curve: Array, pair: Pair) -> Array:
    """The curve with straight lines over frames that do not count."""
    return np.asarray(np.interp(pair.times, pair.times[pair.counted], curve[pair.counted]))


def _at(reference: Array, estimate: Array, frames: int) -> float:
    """Correlation of the reference with the estimate taken that many frames later."""
    if frames >= 0:
        return correlation(reference[: len(reference) - frames], estimate[frames:])
    return correlation(reference[-frames:], estimate[:frames])
