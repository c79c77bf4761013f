"""What is wrong with a recording, found before anything is done to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.groups import MarkerGroups
from mien.capture.cleaning.impossible_motion import extent, guess_axes, guess_units, say_axes
from mien.capture.cleaning.repairs import complete, runs
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack

__all__ = ["Fault", "Severity", "find_faults", "frozen", "not_seen"]

Severity = Literal["refuse", "repair", "warn"]

_FROZEN_SECONDS, _FROZEN_FRAMES = 0.25, 5
_SELDOM_SEEN = 0.2
_SLIGHT_SECONDS, _GRAVE_SECONDS = 0.1, 0.5
_USUAL_RATES = (24, 25, 30, 50, 60, 100, 120, 200, 240)


@dataclass(frozen=True)
class Fault:
    """One fault of a recording.

    Attributes
    ----------
    severity : {"refuse", "repair", "warn"}
        Cannot be used; `clean` mends it; usable as it is, but someone should know.
    message : str
        What was expected, what came, the likely cause.
    marker : str or None
        The marker concerned; None for all.
    frame : int or None
        The first frame concerned; None for the whole recording.
    """

    severity: Severity
    message: str
    marker: str | None = None
    frame: int | None = None

    def __str__(self) -> str:
        where = [f"marker {self.marker!r}"] if self.marker is not None else []
        where += [f"frame {self.frame}"] if self.frame is not None else []
        return f"{', '.join(where)}: {self.message}" if where else self.message


def find_faults(
    track: MarkerTrack, groups: MarkerGroups | None = None, sound_seconds: float | None = None
) -> tuple[Fault, ...]:
    """List the faults of a recording, gravest first.

    Parameters
    ----------
    track : MarkerTrack
        As read: meant to be millimetres and mien's axes, which is checked.
    groups : MarkerGroups, optional
        Which marker is what; without it the axes cannot be checked.
    sound_seconds : float, optional
        Length of the sound that belongs to the motion.

    Examples
    --------
    >>> metres = MarkerTrack(("brow", "chin"), [[[0.0, 0.12, 0.0], [0.0, 0.001, 0.0]]], FrameRate.of(120))
    >>> [fault.message for fault in find_faults(metres)]
    ['expected millimetres, got a face 0.119 units large: these are likely metres']
    """
    if not len(track) or not track.names:
        return (Fault("refuse", f"expected motion, got {len(track)} frames of {len(track.names)} markers"),)
    if not_seen(track.positions).all():
        return (Fault("refuse", "no marker is seen in any frame: the tracker never found the face"),)
    seen = MarkerTrack(
        track.names, np.where(not_seen(track.positions)[:, :, None], np.nan, track.positions), track.rate
    )
    faults = [*_of_names(track, groups), *_of_size(seen), *_of_numbers(track), *_of_sight(seen), *_of_freezing(seen)]
    if groups is not None:
        faults += _of_axes(seen, groups)
    if sound_seconds is not None:
        faults += _of_length(len(track), track.rate, sound_seconds)
    order = {"refuse": 0, "repair": 1, "warn": 2}
    return tuple(sorted(faults, key=lambda fault: order[fault.severity]))


def not_seen(positions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where a marker was not seen (frames, markers): NaN, infinite, or exactly at the origin, as some systems write."""
    missing: NDArray[np.bool_] = ~complete(positions) | (positions == 0.0).all(axis=2)
    return missing


def frozen(track: MarkerTrack) -> list[tuple[int, int, int]]:
    """Stretches in which one marker keeps exactly its place while most others move: (marker, first, last).

    The first frame of a stretch is not in it: that one was seen.
    """
    least = max(_FROZEN_FRAMES, round(_FROZEN_SECONDS * track.rate.fps))
    still = np.zeros(track.positions.shape[:2], dtype=bool)
    still[1:] = (np.diff(track.positions, axis=0) == 0).all(axis=2)
    alone = still & (still.mean(axis=1, keepdims=True) < 0.5)
    return [
        (marker, first, last)
        for marker in range(len(track.names))
        for first, last in runs(alone[:, marker])
        if last - first + 1 >= least
    ]


def _of_names(track: MarkerTrack, groups: MarkerGroups | None) -> Iterator[Fault]:
    for name in groups.names if groups is not None else ():
        if name not in track.names:
            yield Fault("refuse", "the layout names this marker, but the recording lacks it: another layout?", name)


def _of_size(track: MarkerTrack) -> Iterator[Fault]:
    units, size = guess_units(track), extent(track)
    if units is None and size > 0:
        cause = "an unknown unit, or markers that are not of one face"
        yield Fault("refuse", f"expected millimetres, got a face {size:.3g} units large: {cause}")
    elif units not in (None, "millimetres"):
        yield Fault("repair", f"expected millimetres, got a face {size:.3g} units large: these are likely {units}")


def _of_numbers(track: MarkerTrack) -> Iterator[Fault]:
    for label, wrong, cause in (
        (
            "infinite positions",
            ~complete(np.nan_to_num(track.positions, posinf=np.nan, neginf=np.nan)),
            "a damaged file",
        ),
        ("positions exactly at the origin", (track.positions == 0.0).all(axis=2), "how some systems write 'not seen'"),
    ):
        for marker in np.flatnonzero(wrong.any(axis=0)):
            frames = np.flatnonzero(wrong[:, marker])
            message = f"{label} in {len(frames)} frames, taken as not seen: {cause}"
            yield Fault("repair", message, track.names[marker], int(frames[0]))


def _of_sight(track: MarkerTrack) -> Iterator[Fault]:
    seen = complete(track.positions)
    lost = np.asarray(~seen.any(axis=1), dtype=np.bool_)
    for first, last in runs(lost):
        yield Fault("repair", f"no marker is seen up to frame {last}: the tracker lost the face", None, first)
    share = seen[~lost].mean(axis=0)
    for marker in np.flatnonzero(share < _SELDOM_SEEN):
        message = (
            "never seen: fallen off, or not tracked" if share[marker] == 0 else f"seen in {share[marker]:.0%} only"
        )
        yield Fault("repair", message, track.names[marker])
    if seen.mean() < 0.5:
        yield Fault("warn", f"only {seen.mean():.0%} of all marker positions are there: expect poor filling")


def _of_freezing(track: MarkerTrack) -> Iterator[Fault]:
    for marker, first, last in frozen(track):
        message = f"does not move at all up to frame {last} while others do: lost, and its last place written on"
        yield Fault("repair", message, track.names[marker], first)
    same = np.zeros(len(track), dtype=bool)
    same[1:] = (np.diff(track.positions, axis=0) == 0).all(axis=(1, 2))
    for first, last in runs(same):
        message = f"every marker stands exactly still up to frame {last}: repeated frames, or a frozen camera"
        yield Fault("warn", message, None, first)


def _of_axes(track: MarkerTrack, groups: MarkerGroups) -> Iterator[Fault]:
    if any(name not in track.names for name in groups.names):
        return
    matrix = guess_axes(track, groups)
    if matrix is None:
        message = "the face stands askew to all axes, or the eyes, nose and lips are never seen together"
        yield Fault("warn", f"axes cannot be checked: {message}")
    elif not np.array_equal(matrix, np.eye(3)):
        mirrored = np.linalg.det(matrix) < 0
        cause = "left-handed axes, or a mirrored picture" if mirrored else "another convention, such as z up"
        yield Fault("repair", f"expected x to the speaker's left, y up, z forward; {say_axes(matrix)}: {cause}")


def _of_length(frames: int, rate: FrameRate, sound_seconds: float) -> Iterator[Fault]:
    motion = float(frames / rate.fraction)
    difference = abs(motion - sound_seconds)
    if difference <= max(_SLIGHT_SECONDS, 1.0 / rate.fps):
        return
    at = min(frames, rate.frame_at(sound_seconds))
    text = f"{frames} frames at {rate} a second are {motion:.2f} s, the sound is {sound_seconds:.2f} s"
    for usual in _USUAL_RATES:
        if usual != rate.fraction and abs(frames / Fraction(usual) - sound_seconds) <= 1.5 / usual:
            yield Fault("refuse", f"{text}: the rate is likely {usual} and not {rate}", None, at)
            return
    if difference > _GRAVE_SECONDS:
        yield Fault("refuse", f"{text}: another take's sound, or one of them is cut off", None, at)
    else:
        yield Fault("warn", f"{text}: one of them starts or stops late", None, at)
