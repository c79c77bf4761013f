"""Filling the frames in which a marker was not seen.

* A short gap (`GapSettings.short` seconds) between seen frames: a cubic spline through the frames around it. Short is
  what the lips cannot do much in: three frames at 120 a second, none at 25, where one frame is a whole closure.
* A long gap, or one at an end: regression from the markers that are seen, through the principal components of how all
  markers move together (`mien.capture.cleaning.lowrank`), bent so that it meets the seen frames on both sides.
* A frame without any marker (the tracker lost the face) has nothing to regress from: a short stretch
  (`GapSettings.bridge` seconds) is bridged by the spline; at an end the nearest seen frame is held up to
  `GapSettings.hold` seconds; anything longer stays NaN and is reported as left.
* A marker that is seen in fewer than `GapSettings.least_seen` of the frames is dropped and reported.

Positions should be normalised first: the components then describe the face and not the head.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from mien.capture.cleaning.lowrank import LowRank
from mien.capture.cleaning.repairs import Repair, complete, runs
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack

__all__ = ["GapSettings", "drop_unseen", "fill_gaps"]

_NEIGHBOURS = 4  # seen frames on each side that shape the curve


@dataclass(frozen=True)
class GapSettings:
    """How gaps are filled.

    Attributes
    ----------
    short : float
        Seconds up to which a gap is bridged by a spline. See docs/tables/cleaning.md.
    rank : int
        Principal components for long gaps.
    bridge : float
        Seconds up to which a stretch without any marker is bridged by a spline.
    hold : float
        Seconds up to which the nearest seen frame is held at an end where the whole face was lost.
    least_seen : float
        Share of the frames, 0..1, in which a marker must be seen to be kept.
    """

    short: float = 0.025
    rank: int = 20
    bridge: float = 0.08
    hold: float = 1.0
    least_seen: float = 0.2


def drop_unseen(track: MarkerTrack, least_seen: float) -> tuple[MarkerTrack, tuple[Repair, ...]]:
    """Leave out the markers that are never seen, or in fewer than a share ``least_seen`` (0..1) of the frames.

    Raises
    ------
    InputError
        If no marker would be left.
    """
    if not len(track):
        raise InputError("marker track: it has no frames")
    share = complete(track.positions).mean(axis=0)
    keep = (share > 0) & (share >= least_seen)
    if not keep.any():
        raise InputError(f"marker track: no marker is seen in {least_seen:.0%} of the {len(track)} frames")
    last = len(track) - 1
    dropped = tuple(
        Repair("dropped", (track.names[m],), 0, last, "never seen" if not share[m] else f"seen in {share[m]:.0%}")
        for m in np.flatnonzero(~keep)
    )
    names = [track.names[m] for m in np.flatnonzero(keep)]
    return MarkerTrack(names, track.positions[:, keep], track.rate), dropped


def fill_gaps(
    track: MarkerTrack, settings: GapSettings | None = None, examples: NDArray[np.float64] | None = None
) -> tuple[MarkerTrack, tuple[Repair, ...]]:
    """Fill the gaps of every marker.

    Parameters
    ----------
    track : MarkerTrack
        Normalised, mm; NaN where a marker was not seen. Each marker must be seen at least once (see `drop_unseen`).
    settings : GapSettings, optional
    examples : ndarray, shape (n, markers, 3), optional
        Frames of the same speaker and markers from other takes, to learn the components from together with the track.

    Returns
    -------
    MarkerTrack
        Without NaN, save for stretches in which the whole face was lost for too long.
    tuple of Repair
        What was filled, in order of frames.

    Raises
    ------
    InputError
        If a marker is never seen, or the examples have other markers.

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> slide = np.arange(9.0)[:, None, None] * np.ones((1, 2, 3))
    >>> slide[4, 0] = np.nan
    >>> filled, repairs = fill_gaps(MarkerTrack(("lip", "chin"), slide, FrameRate.of(120)))
    >>> filled.positions[4, 0].round(9).tolist(), str(repairs[0])
    ([4.0, 4.0, 4.0], 'gap: lip, frames 4..4: spline')
    """
    settings = settings or GapSettings()
    _check(track, examples)
    seen = complete(track.positions)
    positions = np.where(seen[:, :, None], track.positions, np.nan)
    lost = np.asarray(~seen.any(axis=1), dtype=np.bool_)
    fps = track.rate.fps
    repairs = _fill_short(track.names, positions, seen, lost, math.floor(settings.short * fps + 1e-6))
    repairs += _fill_long(track.names, positions, ~lost, settings.rank, examples)
    repairs += _fill_lost(positions, lost, round(settings.bridge * fps), round(settings.hold * fps))
    repairs.sort(key=lambda repair: (repair.first, repair.last, repair.markers))
    return MarkerTrack(track.names, positions, track.rate), tuple(repairs)


def _check(track: MarkerTrack, examples: NDArray[np.float64] | None) -> None:
    never = [name for m, name in enumerate(track.names) if not complete(track.positions[:, m]).any()]
    if never:
        raise InputError(f"markers never seen cannot be filled: {', '.join(never)}; drop them first")
    if examples is not None and examples.shape[1:] != track.positions.shape[1:]:
        raise InputError(f"example frames: expected shape (n, {len(track.names)}, 3), got {examples.shape}")


def _fill_short(
    names: tuple[str, ...],
    positions: NDArray[np.float64],
    seen: NDArray[np.bool_],
    lost: NDArray[np.bool_],
    most: int,
) -> list[Repair]:
    """Bridge short inner gaps in place; gaps in which the whole face was lost are left to `_fill_lost`."""
    repairs = []
    for marker, name in enumerate(names):
        for first, last in runs(~seen[:, marker]):
            inner = first > 0 and last < len(positions) - 1
            if inner and last - first < most and not lost[first : last + 1].all():
                positions[first : last + 1, marker] = _curve(positions[:, marker], seen[:, marker], first, last)
                repairs.append(Repair("gap", (name,), first, last, "spline"))
    return repairs


def _curve(values: NDArray[np.float64], seen: NDArray[np.bool_], first: int, last: int) -> NDArray[np.float64]:
    """Cubic spline through the seen frames around a gap, at the frames of the gap."""
    before = np.flatnonzero(seen[:first])[-_NEIGHBOURS:]
    after = last + 1 + np.flatnonzero(seen[last + 1 :])[:_NEIGHBOURS]
    knots = np.concatenate([before, after])
    bridged: NDArray[np.float64] = CubicSpline(knots, values[knots])(np.arange(first, last + 1))
    return bridged


def _fill_long(
    names: tuple[str, ...],
    positions: NDArray[np.float64],
    present: NDArray[np.bool_],
    rank: int,
    examples: NDArray[np.float64] | None,
) -> list[Repair]:
    """Fill what is left in the frames that show some marker, in place."""
    holes = np.isnan(positions).any(axis=2) & present[:, None]
    if not holes.any():
        return []
    flat = positions.reshape(len(positions), -1)
    poses = flat[present] if examples is None else np.concatenate([flat[present], examples.reshape(len(examples), -1)])
    model = LowRank.fit(poses, rank)
    guess = np.full_like(positions, np.nan)
    for frame in np.flatnonzero(present):
        guess[frame] = model.rebuild(flat[frame]).reshape(-1, 3)
    repairs = []
    for marker, name in enumerate(names):
        for first, last in runs(holes[:, marker]):
            bend = _bend(positions[:, marker] - guess[:, marker], first, last)
            positions[first : last + 1, marker] = guess[first : last + 1, marker] + bend
            repairs.append(Repair("gap", (name,), first, last, "PCA of the other markers"))
    return repairs


def _bend(misfit: NDArray[np.float64], first: int, last: int) -> NDArray[np.float64]:
    """The misfit of the model beside a gap, run linearly across it; at an end of the track it is held."""
    ends = [frame for frame in (first - 1, last + 1) if 0 <= frame < len(misfit) and np.isfinite(misfit[frame]).all()]
    frames = np.arange(first, last + 1)
    if not ends:
        return np.zeros((len(frames), 3))
    return np.stack([np.interp(frames, ends, misfit[ends, axis]) for axis in range(3)], axis=1)


def _fill_lost(positions: NDArray[np.float64], lost: NDArray[np.bool_], bridge: int, hold: int) -> list[Repair]:
    """Bridge, hold or leave the stretches in which no marker was seen, in place."""
    repairs = []
    count = len(positions)
    for first, last in runs(lost):
        length = last - first + 1
        if first > 0 and last < count - 1 and length <= bridge:
            for marker in range(positions.shape[1]):
                positions[first : last + 1, marker] = _curve(positions[:, marker], ~lost, first, last)
            method = "spline"
        elif (first == 0 or last == count - 1) and length <= hold:
            positions[first : last + 1] = positions[last + 1 if first == 0 else first - 1]
            method = "nearest seen frame held"
        else:
            method = "left empty: too long to fill"
        repairs.append(Repair("lost face", (), first, last, method))
    return repairs
