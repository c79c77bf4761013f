"""What is counted in one take for one model; every metric is read from sums of these.

A tally is a mapping from a family of metrics to a vector. Tallies add up, so that a metric may be taken in each take
and averaged, or over the frames of all takes pooled; and a bootstrap over takes is a product with their counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.metrics.closure import closure_counts, shut_together
from mien.metrics.distance import squared_distances
from mien.metrics.mouth_distributions import distributions
from mien.metrics.pairing import frontal
from mien.metrics.scored_takes import Recording
from mien.metrics.sync import is_undetectable, lag_of_best_correlation, onset_lag
from mien.metrics.track_jitter import third_differences
from mien.metrics.trajectory import moments, separation, velocity

__all__ = ["Tally", "tally"]

_STILL = 1e-9  # mm

Array = NDArray[np.float64]
Tally = Mapping[str, Array]


def tally(
    recording: Recording,
    synthesised: Array,
    counted: NDArray[np.bool_],
    offset: Array | None = None,
    *,
    from_the_front: bool = False,
) -> Tally:
    """Compare a synthesised mouth with the recorded one.

    Parameters
    ----------
    recording : Recording
    synthesised : ndarray, shape (frames, markers, 3)
        Millimetres, one frame for each of the recording, the same markers.
    counted : ndarray of bool, shape (frames,)
        Frames to score.
    offset : ndarray, shape (markers, 3), or None
        Taken off the synthesised markers before distances are taken, mm; openings and closures keep it.
    from_the_front : bool
        Take opening and width in x and y alone.

    Returns
    -------
    mapping of str to ndarray
        ``distance``, ``lip_distance``, ``frontal`` (lips in x and y) and ``lips`` (sum, count), ``jitter`` (sum,
        count), the moments of ``opening``, ``width``, ``opening_velocity`` and ``width_velocity``, ``closure`` and
        ``shut`` (4 counts each), ``sync`` (lag, onset lag, whether the lag goes unnoticed; each followed by its
        count), and what `mien.metrics.mouth_distributions` counts.

    Raises
    ------
    InputError
        If the model made another number of frames or markers, or numbers that are not finite.
    """
    recorded, sites = recording.positions, recording.sites
    if synthesised.shape != recorded.shape or not np.isfinite(synthesised).all():
        raise InputError(
            f"take {recording.take.name!r}: expected finite positions of shape {recorded.shape} from the model, "
            f"got shape {synthesised.shape}"
        )
    laid = synthesised if offset is None else synthesised - offset
    squared = squared_distances(recorded[counted], laid[counted])
    between = frontal if from_the_front else separation
    openings = [between(positions, *sites.opening) for positions in (recorded, synthesised)]
    flat = ((recorded - laid)[counted][:, sites.lips, :2] ** 2).sum(axis=2)
    result = {
        "distance": np.array([squared.sum(), squared.size]),
        "lip_distance": np.array([squared[:, sites.lips].sum(), squared[:, sites.lips].size]),
        "frontal": np.array([flat.sum(), flat.size]),
        "lips": np.array([squared[:, sites.lips].max(axis=1).sum(), len(squared)]),
        "jitter": _jitter(synthesised, counted),
        "closure": _closure(recording, openings[1], counted),
        "shut": _shut(recording, openings, counted),
        "sync": _sync(recording, openings),
        **distributions(openings[1], recording.times, recording.take.phones, counted),
    }
    for name, (one, other) in (("opening", sites.opening), ("width", sites.width)):
        curves = [between(positions, one, other) for positions in (recorded, synthesised)]
        result[name] = moments(curves[0][counted], curves[1][counted])
        speeds = [velocity(curve, recording.fps) for curve in curves]
        moving = counted & np.isfinite(speeds[0])
        result[f"{name}_velocity"] = moments(speeds[0][moving], speeds[1][moving]) if moving.any() else np.zeros(6)
    return result


def _jitter(positions: Array, counted: NDArray[np.bool_]) -> Array:
    """Over runs of four counted frames."""
    whole = np.convolve(counted, np.ones(4), mode="valid") == 4
    if len(positions) < 4 or not whole.any():
        return np.zeros(2)
    values = third_differences(np.where(counted[:, None, None], positions, 0.0))[whole]
    return np.array([values.sum(), values.size])


def _closure(recording: Recording, opening: Array, counted: NDArray[np.bool_]) -> Array:
    if not recording.sites.inner:
        return np.zeros(4)
    counts = closure_counts(opening, recording.times, recording.take.phones, counted)
    return np.array([counts.bilabials, counts.found, counts.closed_frames, counts.right_frames], dtype=np.float64)


def _shut(recording: Recording, curves: Sequence[Array], counted: NDArray[np.bool_]) -> Array:
    return shut_together(curves[0], curves[1], counted, recording.fps) if recording.sites.inner else np.zeros(4)


def _sync(recording: Recording, curves: Sequence[Array]) -> Array:
    """Lags of the whole take between two openings; where one cannot be known its count is 0."""
    held = recording.speech
    lag = lag_of_best_correlation(curves[0][held], curves[1][held], recording.fps)
    seen = np.isfinite(curves[0])
    late = onset_lag(curves[0][seen], curves[1][seen], recording.times[seen], recording.first_phone)
    moves = all(curve[held].std() > _STILL for curve in curves)  # without a lag in range it is not in sync either
    values = [lag, late, float(np.isfinite(lag) and is_undetectable(lag)) if moves else np.nan]
    return np.array([part for v in values for part in (np.nan_to_num(v), float(np.isfinite(v)))])
