"""One recording becomes motion of the recorded person's face: `capture_take`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mien.capture.knowledge import knowledge
from mien.capture.layouts import Layout
from mien.capture.one_camera import solve_spoken
from mien.capture.person import Person, fit_person
from mien.capture.solver import Priors, Solver
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack

__all__ = ["Captured", "Recorded", "capture_take"]

Floats = NDArray[np.float64]

_MOST_MISSING = 0.2  # of the positions of the markers that are used


class Recorded(Protocol):
    """What is asked of a take, which `mien.corpus.take.Take` has."""

    @property
    def markers(self) -> MarkerTrack:
        """Normalised markers."""
        ...

    @property
    def layout(self) -> str:
        """Name of their layout."""
        ...


@dataclass(frozen=True, eq=False)
class Captured:
    """A recording as motion of a face.

    Attributes
    ----------
    channels : ChannelTrack
        `mien.core.channels.WEIGHTS`, 0..1; what markers cannot tell (tongue, gaze) is 0.
    sought : tuple of str
        The channels that were solved for.
    person : Person
        The head and its neutral face: give it to `capture_take` for other recordings of the same person.
    residual : ndarray, shape (frames,)
        Root mean square misfit over the markers that are heard, along the axes that the source sees, mm.
    regions : dict of str to float
        That misfit by region, over all frames, mm.
    filled : float
        Share of marker positions that were missing and interpolated.
    """

    channels: ChannelTrack
    sought: tuple[str, ...]
    person: Person
    residual: Floats
    regions: dict[str, float]
    filled: float

    @property
    def head(self) -> Floats:
        """Coefficients of the person's head in the space of heads, shape (components,), standard deviations."""
        return self.person.head


def capture_take(
    take: Recorded | MarkerTrack | Floats,
    layout: Layout | str | None = None,
    fps: float | str | FrameRate | None = None,
    source: str = "tracker",
    head: Person | None = None,
    priors: Priors | None = None,
    spoken: bool = False,
) -> Captured:
    """Capture a face from its markers.

    Parameters
    ----------
    take : Take, MarkerTrack or ndarray of shape (frames, markers, 3)
        Normalised motion (mm, x to the speaker's left, y up, z forward, the head's own motion taken out). A bare array
        holds all markers of the layout in its order.
    layout : Layout or str
        Whose markers; a take knows its own.
    fps : float, str or FrameRate
        Frames per second of a bare array.
    source : {"tracker", "optical"}
        A tracker on pictures all but guesses depth; optical markers measure it.
    head : Person, optional
        The person, if known from other recordings (`mien.capture.fit_person`); else found in this one. Markers of
        theirs that this recording never shows are done without.
    priors : Priors, optional
        What is held against a solution.
    spoken : bool
        It shows plain speech: of the jaw that a tracker reports a part is believed (`mien.capture.one_camera`).

    Raises
    ------
    InputError
        If the array does not fit the layout, or too few of the person's markers are seen.

    Examples
    --------
    >>> from mien.capture.layouts import load_layout
    >>> places = load_layout("mediapipe-218").places
    >>> still = capture_take(np.repeat(places[None], 10, axis=0), "mediapipe-218", 25)
    >>> float(still.channels.values.max()) < 0.05
    True
    """
    track, layout = _given(take, layout, fps)
    if head is None:
        head = fit_person([track], layout, source)
    place = {name: column for column, name in enumerate(track.names)}
    there = np.asarray(np.isfinite(track.positions).all(axis=2).any(axis=0))
    kept = [n for n, name in enumerate(head.markers) if name in place and there[place[name]]]
    known = head if len(kept) == len(head.markers) else head.with_markers(kept)
    positions, filled = _filled(track.positions[:, [place[name] for name in known.markers]], known.markers)
    fps = float(track.rate.fps)
    if spoken and known.source == "tracker":
        solved = solve_spoken(known, positions, fps, priors)
    else:
        solved = Solver(known, priors).solve(positions, fps)
    values = np.zeros((len(track), len(WEIGHTS)))
    values[:, [WEIGHTS.index(name) for name in head.channels]] = solved.weights
    heard = known.region >= 0
    away = (solved.missed[:, :, :2] ** 2).sum(axis=2)
    return Captured(
        channels=ChannelTrack(WEIGHTS, values, track.rate),
        sought=head.channels,
        person=head,
        residual=np.sqrt(away[:, heard].mean(axis=1)),
        regions={
            region.name: float(np.sqrt(away[:, known.region == number].mean()))
            for number, region in enumerate(knowledge().regions)
            if (known.region == number).any()
        },
        filled=filled,
    )


def _given(
    take: Recorded | MarkerTrack | Floats, layout: Layout | str | None, fps: float | str | FrameRate | None
) -> tuple[MarkerTrack, Layout | str]:
    if isinstance(take, MarkerTrack):
        track = take
    elif isinstance(take, np.ndarray):
        track = _from_array(take, layout, fps)
    elif hasattr(take, "markers"):
        track, layout = take.markers, layout or take.layout
    else:
        raise InputError(f"capture: expected a take, a MarkerTrack or an array of markers, got {type(take).__name__}")
    if not layout:
        raise InputError("capture: expected the name of the markers' layout, such as 'mediapipe-218', got none")
    if not len(track):
        raise InputError("capture: the recording has no frame")
    return track, layout


def _from_array(array: Floats, layout: Layout | str | None, fps: float | str | FrameRate | None) -> MarkerTrack:
    from mien.capture.layouts import load_layout

    if layout is None or fps is None:
        raise InputError("capture: an array of markers needs layout= and fps=")
    known = load_layout(layout) if isinstance(layout, str) else layout
    if array.dtype.kind not in "fiu":
        raise InputError(f"capture: expected numbers, got an array of {array.dtype}")
    if array.ndim != 3 or array.shape[1:] != (len(known.markers), 3):
        raise InputError(
            f"capture: expected (frames, {len(known.markers)} markers of {known.name}, 3), got {array.shape}"
        )
    return MarkerTrack(known.markers, array, FrameRate.of(fps))


def _filled(positions: Floats, names: tuple[str, ...]) -> tuple[Floats, float]:
    """Missing positions interpolated in time; refused where too many are missing."""
    missing = np.asarray(~np.isfinite(positions).all(axis=2))
    share = float(missing.mean())
    if share == 0.0:
        return positions, 0.0
    if share > _MOST_MISSING:
        frame, marker = np.argwhere(missing)[0]
        raise InputError(
            f"capture: {share:.0%} of the marker positions are missing ({_MOST_MISSING:.0%} at most), first "
            f"{names[marker]!r} in frame {frame}; fill gaps first, or leave the recording out"
        )
    positions, times = positions.copy(), np.arange(len(positions))
    for marker in np.flatnonzero(missing.any(axis=0)):
        seen = ~missing[:, marker]
        for axis in range(3):
            positions[:, marker, axis] = np.interp(times, times[seen], positions[seen, marker, axis])
    return positions, share
