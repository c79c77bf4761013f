"""Dynamics: how fast the lips move, how they shake, and how far each kind of phone opens the mouth.

Nothing here asks whether the estimate is right at an instant: these are distributions, and good speech has them as
recorded even where it differs in timing.

Conventions
-----------
* Speed is that of the lip opening between frames, mm/s; p99 is its 99th percentile.
* A turn is an instant at which the opening changes direction and swings by `SWING` or more before it turns again.
* Jitter is the size of frame-to-frame noise that would look like the third difference of the lips
  (`mien.metrics.track_jitter`).
* Phone classes are `CLASSES`; a phone's opening is the least (closures) or the middle one of its frames.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.metrics.face_track import FaceTrack
from mien.metrics.mouth import mouth_pair
from mien.metrics.pairing import frontal
from mien.metrics.track_jitter import third_differences
from mien.metrics.trajectory import velocity

__all__ = ["CLASSES", "SWING", "evaluate", "openings_by_class", "summary_by_class", "turns", "validate"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SWING = 2.0
"""Millimetres that the opening must swing for a change of direction to count."""
CLASSES: Mapping[str, frozenset[str]] = {
    "bilabial": frozenset({"P", "B", "M"}),
    "labiodental": frozenset({"F", "V"}),
    "rounded": frozenset({"W", "UW", "OW", "AO", "UH", "OY"}),
    "open": frozenset({"AA", "AE", "AH", "AW", "AY"}),
    "front": frozenset({"IY", "IH", "EY", "EH"}),
    "coronal": frozenset({"T", "D", "N", "S", "Z", "L", "TH", "DH", "SH", "ZH", "CH", "JH", "R", "ER", "Y"}),
    "velar": frozenset({"K", "G", "NG", "HH"}),
}
"""Kinds of English phones by what they ask of the lips."""
_FEWEST_PHONES = 4


def validate(reference: FaceTrack, estimate: FaceTrack) -> None:
    """Refuse two faces whose lips cannot be compared (`mien.metrics.mouth.mouth_pair`)."""
    mouth_pair(reference, estimate)


def evaluate(reference: FaceTrack, estimate: FaceTrack, *, counted: Mask | None = None) -> dict[str, float]:
    """Compare the dynamics of two mouths.

    Returns
    -------
    dict of str to float
        ``speed_p99_reference_mm_s``, ``speed_p99_estimate_mm_s`` and ``speed_p99_ratio``; ``turns_reference_s`` and
        ``turns_estimate_s``: turns per second; ``jitter_reference_mm``, ``jitter_estimate_mm``; where phones are known,
        for each of `CLASSES` that occurs ``opening_CLASS_reference_mm``, ``opening_CLASS_estimate_mm`` (medians) and
        ``opening_CLASS_range_ratio`` (from quarter to three quarters, estimate over reference; from 4 phones on).

    Raises
    ------
    InputError
        As `validate`.
    """
    pair, sites = mouth_pair(reference, estimate, counted)
    held, scores = pair.counted, {}
    moving = held & np.append(held[1:], False)
    seconds = held.sum() / pair.fps
    curves: dict[str, Array] = {}
    for kind, positions in (("reference", pair.reference), ("estimate", pair.estimate)):
        curves[kind] = frontal(positions, *sites.opening)
        speeds = np.abs(velocity(curves[kind], pair.fps)[moving])
        scores[f"speed_p99_{kind}_mm_s"] = float(np.percentile(speeds, 99)) if len(speeds) else float("nan")
        scores[f"turns_{kind}_s"] = turns(curves[kind][held]) / float(seconds)
        scores[f"jitter_{kind}_mm"] = _jitter(positions[:, sites.lips], held)
    fastest = scores["speed_p99_reference_mm_s"]
    scores["speed_p99_ratio"] = scores["speed_p99_estimate_mm_s"] / fastest if fastest > 0 else float("nan")
    phones = reference.phones or estimate.phones
    if phones is not None:
        scores |= _by_class(curves, phones, pair.times, held)
    return scores


def turns(opening: Array) -> int:
    """How often a curve changes direction with a swing of `SWING` mm or more on both sides.

    Examples
    --------
    >>> turns(np.array([0.0, 5.0, 0.0, 5.0, 4.5, 5.0, 0.0]))
    3
    """
    if not len(opening):
        return 0
    count, direction, low, high = 0, 0, float(opening[0]), float(opening[0])
    for value in opening.tolist():
        low, high = min(low, value), max(high, value)
        if direction >= 0 and high - value >= SWING:
            count += direction > 0
            direction, low, high = -1, value, value
        elif direction <= 0 and value - low >= SWING:
            count += direction < 0
            direction, low, high = 1, value, value
    return count


def openings_by_class(opening: Array, phones: Tier, times: Array, held: Mask) -> dict[str, Array]:
    """The opening of every phone, by kind: the least of a bilabial's or labiodental's frames, else that at its middle.

    Parameters
    ----------
    opening : ndarray, shape (frames,)
        Millimetres.
    phones : Tier
    times : ndarray, shape (frames,)
        Seconds.
    held : ndarray of bool, shape (frames,)
        Frames that count; a phone with a frame that does not is left out.

    Raises
    ------
    InputError
        If opening and times differ in length.
    """
    if opening.shape != times.shape:
        raise InputError(f"expected one opening for each time, got shapes {opening.shape} and {times.shape}")
    found: dict[str, list[float]] = {name: [] for name in CLASSES}
    for phone in phones:
        kind = next((name for name, members in CLASSES.items() if phone.label in members), None)
        inside = (times >= phone.start - 1e-9) & (times < phone.end - 1e-9)
        if not inside.any():
            inside[int(np.argmin(np.abs(times - phone.middle)))] = True
        if kind is None or not held[inside].all():
            continue
        least = kind in ("bilabial", "labiodental")
        found[kind].append(float(opening[inside].min()) if least else float(np.interp(phone.middle, times, opening)))
    return {name: np.array(values) for name, values in found.items() if values}


def _by_class(curves: Mapping[str, Array], phones: Tier, times: Array, held: Mask) -> dict[str, float]:
    one, other = (openings_by_class(curves[kind], phones, times, held) for kind in ("reference", "estimate"))
    return summary_by_class([one], [other])


def summary_by_class(
    reference: Sequence[Mapping[str, Array]], estimate: Sequence[Mapping[str, Array]]
) -> dict[str, float]:
    """Medians and spreads of openings by class, over all takes together."""
    scores: dict[str, float] = {}
    for name in CLASSES:
        one, other = (
            np.concatenate([take[name] for take in takes if name in take] or [np.empty(0)])
            for takes in (reference, estimate)
        )
        if not len(one) or not len(other):
            continue
        scores[f"opening_{name}_reference_mm"] = float(np.median(one))
        scores[f"opening_{name}_estimate_mm"] = float(np.median(other))
        ranges = [float(np.subtract(*np.percentile(values, [75, 25]))) for values in (one, other)]
        if len(one) >= _FEWEST_PHONES and ranges[0] > 0:
            scores[f"opening_{name}_range_ratio"] = ranges[1] / ranges[0]
    return scores


def _jitter(positions: Array, held: Mask) -> float:
    whole = np.convolve(held, np.ones(4), mode="valid") == 4
    if not positions.shape[1] or not whole.any():
        return float("nan")
    values = third_differences(np.where(held[:, None, None], positions, 0.0))[whole]
    return float(np.sqrt(values.mean()))
