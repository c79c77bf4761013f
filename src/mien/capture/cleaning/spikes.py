"""Spikes: a marker that flies off alone for a frame or a few and comes back.

A lip that closes for a /b/ at 25 frames a second also leaves and comes back within three frames, so a jump alone
proves nothing. What tells a spike is that the other markers know nothing of it. A marker is taken for a spike only if

* for `SpikeSettings.longest` seconds at most, it is off the straight line between the frames before and after by more
  than `SpikeSettings.jump` millimetres;
* none of its nearest markers does the same at that time;
* it misses the place that all other markers give it (through the principal components of the face, learned from the
  rest of the take) by more than the larger of `SpikeSettings.surprise` millimetres and `SpikeSettings.times` times its
  usual miss.

The frames found are emptied; filling them is the work of `mien.capture.cleaning.gaps`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.lowrank import LowRank
from mien.capture.cleaning.repairs import Repair, complete, runs
from mien.core.tracks import MarkerTrack

__all__ = ["SpikeSettings", "remove_spikes"]

_NEIGHBOURS = 6
_USUAL_FRAMES = 100  # so many, evenly spread, say how far a marker usually is from where the others put it
_ALIKE = 0.5  # two markers do the same if their jumps differ by less than this share of the jump


@dataclass(frozen=True)
class SpikeSettings:
    """What counts as a spike.

    Attributes
    ----------
    jump : float
        Least distance from the line between the frames around it, mm.
    surprise : float
        Least distance from where the other markers put it, mm.
    times : float
        The same as a multiple of the marker's usual (median) distance from there.
    longest : float
        Seconds a spike may last; one frame always may.
    rank : int
        Principal components of the face.
    """

    jump: float = 3.0
    surprise: float = 2.5
    times: float = 4.0
    longest: float = 0.12
    rank: int = 12


@dataclass(frozen=True)
class _Flight:
    """A marker off its path for some frames, by at least ``height`` mm in each."""

    height: float
    marker: int
    first: int
    last: int


def remove_spikes(track: MarkerTrack, settings: SpikeSettings | None = None) -> tuple[MarkerTrack, tuple[Repair, ...]]:
    """Empty (NaN) the frames in which a marker flew off on its own.

    Parameters
    ----------
    track : MarkerTrack
        Normalised, mm.
    settings : SpikeSettings, optional

    Returns
    -------
    MarkerTrack
        With NaN in place of spikes.
    tuple of Repair
        One per marker and run of frames.
    """
    settings = settings or SpikeSettings()
    if len(track) < 3 or len(track.names) < 3:
        return track, ()
    neighbours = _nearest(track.positions)
    wild = np.zeros(track.positions.shape[:2], dtype=np.bool_)
    heights = np.zeros(wild.shape)
    for flight in _flights(track.positions, settings, track.rate.fps):
        span = slice(flight.first, flight.last + 1)
        known = wild[:, flight.marker]
        borders = known[max(0, flight.first - 1) : flight.last + 2]
        if known[span].all() or (borders[[0, -1]] & ~known[span][[0, -1]]).any():
            continue  # seen already, or measured from a frame that is wild itself
        if not _is_alone(track.positions, flight, neighbours[flight.marker]):
            continue
        if _surprises(track.positions, flight, known, settings):
            wild[span, flight.marker] = True
            heights[span, flight.marker] = np.maximum(heights[span, flight.marker], flight.height)
    repairs = []
    for marker, name in enumerate(track.names):
        for first, last in runs(wild[:, marker]):
            height = heights[first : last + 1, marker].max()
            repairs.append(Repair("spike", (name,), first, last, f"{height:.1f} mm off its path: emptied"))
    repairs.sort(key=lambda repair: (repair.first, repair.markers))
    positions = np.where(wild[:, :, None], np.nan, track.positions)
    return MarkerTrack(track.names, positions, track.rate), tuple(repairs)


def _flights(positions: NDArray[np.float64], settings: SpikeSettings, fps: float) -> list[_Flight]:
    """Runs of frames in which a marker is off its path and back again, the highest first."""
    longest = min(max(1, round(settings.longest * fps)), len(positions) - 2)
    # A marker that never goes half the jump from one frame to the next cannot be off a line between frames by all.
    steps = np.nan_to_num(np.linalg.norm(np.diff(positions, axis=0), axis=2)).max(axis=0)
    able = np.flatnonzero(2 * steps >= settings.jump)
    found = []
    for length in range(1, longest + 1):
        lowest = np.full((len(positions) - length + 1, len(able)), np.inf)
        for offset in range(length):
            lowest = np.minimum(lowest, np.linalg.norm(_step(positions[:, able], length, offset), axis=2))
        for first, place in np.argwhere(lowest > settings.jump):
            height = float(lowest[first, place])
            found.append(_Flight(height, int(able[place]), int(first), int(first) + length - 1))
    found.sort(key=lambda flight: (-flight.height, flight.marker, flight.first))
    return found


def _step(positions: NDArray[np.float64], length: int, offset: int) -> NDArray[np.float64]:
    """For runs of ``length`` from every first frame: how far frame ``offset`` of the run is off the line around it.

    The line runs from the frame before the run to the one after; beyond an end of the track the other one is held.
    """
    starts = np.arange(len(positions) - length + 1)
    before, after = starts - 1, starts + length
    one = positions[np.where(before < 0, after, before)]
    other = positions[np.where(after >= len(positions), before, after)]
    share = (offset + 1) / (length + 1)
    return np.asarray(positions[starts + offset] - (one + (other - one) * share), dtype=np.float64)


def _nearest(positions: NDArray[np.float64]) -> NDArray[np.intp]:
    """Columns of the nearest markers of each, by their median places."""
    places = np.full(positions.shape[1:], np.inf)
    seen = complete(positions)
    for marker in np.flatnonzero(seen.any(axis=0)):
        places[marker] = np.median(positions[seen[:, marker], marker], axis=0)
    with np.errstate(invalid="ignore"):
        distance = np.linalg.norm(places[:, None] - places[None], axis=2)
    distance[np.isnan(distance)] = np.inf
    np.fill_diagonal(distance, np.inf)
    return np.argsort(distance, axis=1, kind="stable")[:, :_NEIGHBOURS]


def _is_alone(positions: NDArray[np.float64], flight: _Flight, neighbours: NDArray[np.intp]) -> bool:
    """Whether no neighbour makes the same jump in the middle of the run."""
    length = flight.last - flight.first + 1
    window = positions[max(0, flight.first - 1) : flight.last + 2][:, [flight.marker, *neighbours]]
    place = min(flight.first, 1)
    steps = _step(window, length, length // 2)[place]
    unlike = np.linalg.norm(steps[1:] - steps[0], axis=1)
    return bool(not (unlike < _ALIKE * np.linalg.norm(steps[0])).any())


def _surprises(
    positions: NDArray[np.float64], flight: _Flight, known: NDArray[np.bool_], settings: SpikeSettings
) -> bool:
    """Whether the marker is far from where the other markers put it, in every frame of the run.

    Nothing is learned from the run itself, nor from frames in which the marker is ``known`` to be wild.
    """
    span = np.arange(flight.first, flight.last + 1)
    seen = complete(positions)[:, flight.marker]
    rest = np.setdiff1d(np.flatnonzero(seen & ~known), span)
    if len(rest) < 3:
        return True
    model = LowRank.fit(positions[rest].reshape(len(rest), -1), settings.rank)
    blind = positions.copy()
    blind[:, flight.marker] = np.nan

    def miss(frame: np.intp) -> float:
        put = model.rebuild(blind[frame].reshape(-1)).reshape(-1, 3)[flight.marker]
        return float(np.linalg.norm(positions[frame, flight.marker] - put))

    usual = float(np.median([miss(frame) for frame in rest[:: 1 + len(rest) // _USUAL_FRAMES]]))
    return min(miss(frame) for frame in span) > max(settings.surprise, settings.times * usual)
