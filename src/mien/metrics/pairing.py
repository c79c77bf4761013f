"""Two faces in motion side by side: the landmarks that both have, frame for frame, and the frames that count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.metrics.face_track import FaceTrack
from mien.metrics.scored_takes import MARGIN
from mien.metrics.trajectory import correlation, velocity

__all__ = ["Pair", "agreement", "constant_offset", "frontal", "paired", "speech_frames"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FEWEST = 4
"""Frames that both must show for anything to be scored."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Landmarks of both, on the reference's frames.

    Attributes
    ----------
    names : tuple of str
    reference, estimate : ndarray, shape (frames, landmarks, 3)
        Millimetres.
    counted : ndarray of bool, shape (frames,)
        Frames that are scored.
    times : ndarray, shape (frames,)
    fps : float
    """

    names: tuple[str, ...]
    reference: Array
    estimate: Array
    counted: Mask
    times: Array
    fps: float


def speech_frames(phones: Tier | None, times: Array, fps: float) -> Mask:
    """Frames from two before the first phone to two after the last; all frames where no phone is known."""
    spoken = [phone for phone in phones or () if phone.label not in (PAUSE, "")]
    if not spoken:
        return np.ones(len(times), dtype=bool)
    first, last = (int(np.floor(instant * fps + 1e-6)) for instant in (spoken[0].start, spoken[-1].end))
    frames = np.arange(len(times))
    return (frames >= first - MARGIN) & (frames <= last + MARGIN)


def paired(
    reference: FaceTrack, estimate: FaceTrack, names: Sequence[str], counted: Mask | None = None, least: int = 1
) -> Pair:
    """Bring some landmarks of both on the reference's frames, as far as both last.

    Parameters
    ----------
    reference, estimate : FaceTrack
        The estimate is resampled to the reference's frame rate.
    names : sequence of str
        Landmarks that are wanted; those that one of them lacks are left out.
    counted : ndarray of bool, shape (frames of the reference,), or None
        Frames to score; None takes those of the reference's speech, or all where its phones are not known.
    least : int
        Landmarks that must be left.

    Raises
    ------
    InputError
        If too few landmarks or frames are left.
    """
    seen_in = [track.seen for track in (reference, estimate)]
    common = [name for name in names if all(name in seen for seen in seen_in)]
    if len(common) < least:
        tracks = (reference, estimate)
        lacking = next((t.name for t, seen in zip(tracks, seen_in, strict=True) if not set(names) & seen), "")
        where = f"{lacking} has none" if lacking else f"only {len(common)} are in both"
        raise InputError(f"needs {least} of the landmarks {', '.join(list(names)[:4])}... in both; {where}")
    frames = min(len(reference.landmarks), reference.rate.frames_covering(estimate.times[-1] + 1e-9))
    frames = min(len(reference.landmarks), frames + 1)
    one = reference.places(common)[:frames]
    other = estimate.only(common).resampled(reference.rate, frames).places(common)
    times, fps = reference.times[:frames], reference.rate.fps
    wanted = speech_frames(reference.phones, times, fps) if counted is None else counted[:frames]
    seen = np.isfinite(one).all(axis=(1, 2)) & np.isfinite(other).all(axis=(1, 2))
    if (wanted & seen).sum() < FEWEST:
        raise InputError(
            f"{reference.name} and {estimate.name}: {int((wanted & seen).sum())} frames show both, {FEWEST} are needed"
        )
    return Pair(tuple(common), one, other, wanted & seen, times, fps)


def constant_offset(pair: Pair) -> Array:
    """Mean of estimate less reference over the counted frames, shape (landmarks, 3), mm.

    It is what two different faces, or two reference frames, differ by all the time.
    """
    held = pair.counted
    return np.asarray((pair.estimate[held] - pair.reference[held]).mean(axis=0))


def frontal(positions: Array, one: int, other: int) -> Array:
    """Distance of two landmarks as seen from the front (x and y), shape (frames,), mm.

    A tracker of one camera guesses depth, so that the distance in space would compare guesses.
    """
    return np.asarray(np.linalg.norm((positions[:, one] - positions[:, other])[:, :2], axis=1))


def agreement(
    name: str, reference: Array, estimate: Array, counted: Mask, fps: float, unit: str = "mm"
) -> dict[str, float]:
    """What is said of two curves that should be one.

    Returns
    -------
    dict
        ``NAME_r``, ``NAME_velocity_r``: Pearson's correlations of the curves and of their steps between frames;
        ``NAME_spread``: standard deviation of the estimate over the reference's; ``NAME_bias_UNIT``: mean of estimate
        less reference, signed; ``NAME_error_UNIT``: root of the mean squared difference without that bias;
        ``NAME_absolute_UNIT``: mean absolute difference, bias in it. NaN where a curve does not move.

    Examples
    --------
    >>> curve = np.sin(np.arange(50) / 3)
    >>> scores = agreement("opening", curve, 2 * curve + 1, np.ones(50, dtype=bool), 25.0)
    >>> round(scores["opening_r"], 6), round(scores["opening_spread"], 6)
    (1.0, 2.0)
    """
    x, y = reference[counted], estimate[counted]
    moving = counted & np.append(counted[1:], False)
    speeds = [velocity(curve, fps)[moving] for curve in (reference, estimate)]
    spread = float(x.std())
    return {
        f"{name}_r": correlation(x, y),
        f"{name}_velocity_r": correlation(speeds[0], speeds[1]) if moving.sum() > 1 else float("nan"),
        f"{name}_spread": float(y.std()) / spread if spread > 1e-9 else float("nan"),
        f"{name}_bias_{unit}": float((y - x).mean()),
        f"{name}_error_{unit}": float((y - x).std()),
        f"{name}_absolute_{unit}": float(np.abs(y - x).mean()),
    }
