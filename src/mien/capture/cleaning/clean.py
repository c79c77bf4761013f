"""`clean`: every step of cleaning, in order, with a report of what was done.

Units and axes are put right; markers hardly ever seen are dropped; each frame is laid on a neutral one
(`normalise`), so that the later steps see the face and not the head; exchanged markers get their names back; spikes are
emptied; gaps are filled; the mended rigid markers place every frame anew; and the jitter is taken out group by group.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from mien.capture.cleaning.faults import Fault, find_faults, frozen, not_seen
from mien.capture.cleaning.gaps import GapSettings, drop_unseen, fill_gaps
from mien.capture.cleaning.groups import MarkerGroups
from mien.capture.cleaning.impossible_motion import UNITS, guess_axes, guess_units, say_axes
from mien.capture.cleaning.normalise import Normalised, apply, columns, least_squares, neutral_frame, three_point
from mien.capture.cleaning.repairs import Repair, complete, runs
from mien.capture.cleaning.spikes import SpikeSettings, remove_spikes
from mien.capture.cleaning.swaps import SwapSettings, mend_swaps
from mien.capture.cleaning.tracker_jitter import JitterSettings, jitter, smooth_group, smooth_head
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack

__all__ = ["CleanSettings", "Cleaned", "CleaningReport", "clean"]


@dataclass(frozen=True)
class CleanSettings:
    """How a recording is cleaned; see the settings of each step.

    Attributes
    ----------
    normalise : {"least squares", "three point"}
        Over all rigid markers, or exactly as Deng et al. 2006 over nose and corners of the eyes.
    scale : bool
        Fit a scale per frame too (trackers that see pixels); with least squares only.
    head_hz : float
        Cut-off of the head's motion; 0 leaves it alone.
    swaps, spikes, gaps : settings of the steps; None leaves out the step (gaps are always filled)
    upper_face, mouth : JitterSettings or None
        None leaves the jitter of that group alone.

    Raises
    ------
    InputError
        If a scale is asked for with three points.
    """

    normalise: Literal["least squares", "three point"] = "least squares"
    scale: bool = False
    head_hz: float = 6.0
    swaps: SwapSettings | None = field(default_factory=SwapSettings)
    spikes: SpikeSettings | None = field(default_factory=SpikeSettings)
    gaps: GapSettings = field(default_factory=GapSettings)
    upper_face: JitterSettings | None = field(default_factory=JitterSettings)
    mouth: JitterSettings | None = field(default_factory=JitterSettings)

    def __post_init__(self) -> None:
        if self.scale and self.normalise == "three point":
            raise InputError("clean: three points give no scale; use normalise='least squares' with scale=True")


@dataclass(frozen=True)
class CleaningReport:
    """What was found and done.

    Attributes
    ----------
    faults : tuple of Fault
        Of the recording as it came.
    repairs : tuple of Repair
    reference_frame : int or None
        The neutral frame chosen; None if the caller gave one.
    filled : float
        Share of the kept marker positions that were filled, 0..1.
    empty : float
        Share of the frames left empty, 0..1.
    jitter_before, jitter_after : float
        Of the mouth over the whole take, mm (see `jitter.jitter`); motion counts too, so compare the two only.
    """

    faults: tuple[Fault, ...]
    repairs: tuple[Repair, ...]
    reference_frame: int | None
    filled: float
    empty: float
    jitter_before: float
    jitter_after: float

    def of(self, kind: str) -> tuple[Repair, ...]:
        """The repairs of one kind."""
        return tuple(repair for repair in self.repairs if repair.kind == kind)

    def as_text(self) -> dict[str, str]:
        """For the manifest of a corpus: every value a text; long lists are counted and their head is shown."""
        text = {f"cleaning: {kind}": _listed(self.of(kind)) for kind in dict.fromkeys(r.kind for r in self.repairs)}
        warnings = [fault for fault in self.faults if fault.severity == "warn"]
        if warnings:
            text["cleaning: warnings"] = _listed(tuple(warnings))
        if self.reference_frame is not None:
            text["cleaning: neutral frame"] = str(self.reference_frame)
        text["cleaning: filled"] = f"{self.filled:.4f}"
        text["cleaning: left empty"] = f"{self.empty:.4f}"
        text["cleaning: jitter of the mouth, mm"] = f"{self.jitter_before:.3f} before, {self.jitter_after:.3f} after"
        return text


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Clean motion.

    Attributes
    ----------
    track : MarkerTrack
        Normalised, mm; without NaN save in frames that the report calls left empty.
    head : ndarray, shape (frames, 4, 4)
        ``head @ track`` is where the markers were recorded, but for noise and repairs; NaN in empty frames.
    report : CleaningReport
    """

    track: MarkerTrack
    head: NDArray[np.float64]
    report: CleaningReport


def clean(
    track: MarkerTrack,
    groups: MarkerGroups,
    settings: CleanSettings | None = None,
    reference: NDArray[np.float64] | None = None,
    sound_seconds: float | None = None,
    examples: NDArray[np.float64] | None = None,
) -> Cleaned:
    """Clean a recording.

    Parameters
    ----------
    track : MarkerTrack
        As read. Metres, centimetres and exchanged axes are put right.
    groups : MarkerGroups
    settings : CleanSettings, optional
    reference : ndarray, shape (markers, 3), optional
        Neutral frame, mm and mien's axes, for all markers of the track: give all takes of a session the same one. The
        default is the most neutral frame of the take.
    sound_seconds : float, optional
        Length of the sound, to be checked.
    examples : ndarray, shape (n, markers, 3), optional
        Normalised frames of other takes, to fill long gaps from.

    Raises
    ------
    InputError
        If the recording cannot be used: the message lists the faults.
    """
    settings = settings or CleanSettings()
    faults = find_faults(track, groups, sound_seconds)
    grave = [str(fault) for fault in faults if fault.severity == "refuse"]
    if grave:
        raise InputError("; ".join(grave))
    track, repairs = _put_right(track, groups)
    names = track.names
    track, dropped = drop_unseen(track, settings.gaps.least_seen)
    groups = _without_dropped(groups, dropped)
    kept = [names.index(name) for name in track.names]
    frame = None
    if reference is None:
        frame = neutral_frame(track, groups.upper_lip, groups.lower_lip, groups.rigid)
        reference = track.positions[frame]
    else:
        reference = reference[kept]
    mended, head, more = _mended(
        track, groups, settings, reference, examples[:, kept] if examples is not None else None
    )
    final = _placed(MarkerTrack(track.names, apply(head, mended.positions), track.rate), groups, settings, reference)
    smooth, smooth_motion = _smoothed(final, groups, settings)
    mouth = columns(track, groups.mouth)
    report = CleaningReport(
        faults,
        (*repairs, *dropped, *more),
        frame,
        _share_filled(track, smooth),
        float(np.isnan(smooth.positions).any(axis=(1, 2)).mean()),
        jitter(final.track.positions[:, mouth]),
        jitter(smooth.positions[:, mouth]),
    )
    return Cleaned(smooth, smooth_motion, report)


def _put_right(track: MarkerTrack, groups: MarkerGroups) -> tuple[MarkerTrack, tuple[Repair, ...]]:
    """Empty what was not seen or frozen; millimetres; mien's axes."""
    last = len(track) - 1
    positions = np.where(not_seen(track.positions)[:, :, None], np.nan, track.positions)
    track = MarkerTrack(track.names, positions, track.rate)
    repairs = []
    units = guess_units(track)
    if units is not None and units != "millimetres":
        repairs.append(Repair("units", (), 0, last, f"{units} to millimetres"))
        positions = positions * UNITS[units]
    axes = guess_axes(track, groups)
    if axes is not None and not np.array_equal(axes, np.eye(3)):
        repairs.append(Repair("axes", (), 0, last, say_axes(axes)))
        positions = positions @ axes.T
    for marker, first, end in frozen(track):
        repairs.append(Repair("frozen", (track.names[marker],), first, end, "emptied"))
        positions[first : end + 1, marker] = np.nan
    return MarkerTrack(track.names, positions, track.rate), tuple(repairs)


def _without_dropped(groups: MarkerGroups, dropped: tuple[Repair, ...]) -> MarkerGroups:
    gone = [name for repair in dropped for name in repair.markers]
    needed = {groups.upper_lip, groups.lower_lip} & set(gone)
    if needed:
        raise InputError(f"markers {sorted(needed)} are hardly ever seen, but the opening of the lips needs them")
    return groups.without(gone)


def _mended(
    track: MarkerTrack,
    groups: MarkerGroups,
    settings: CleanSettings,
    reference: NDArray[np.float64],
    examples: NDArray[np.float64] | None,
) -> tuple[MarkerTrack, NDArray[np.float64], tuple[Repair, ...]]:
    """Swaps, spikes and gaps mended in the head; the head's motion, without NaN; and the repairs."""
    rough = least_squares(track, groups.rigid, reference, settings.scale, robust=True)
    head, repairs = _bridged_head(rough)
    in_head = apply(np.asarray(np.linalg.inv(head), dtype=np.float64), track.positions)
    mended = MarkerTrack(track.names, in_head, track.rate)
    if settings.swaps is not None:
        rest = reference if np.isfinite(reference).all() else None
        mended, more = mend_swaps(mended, settings.swaps, rest)
        repairs += more
    if settings.spikes is not None:
        mended, more = remove_spikes(mended, settings.spikes)
        repairs += more
    mended, more = fill_gaps(mended, settings.gaps, examples)
    return mended, head, repairs + more


def _bridged_head(rough: Normalised) -> tuple[NDArray[np.float64], tuple[Repair, ...]]:
    """Head motion with frames that could not be placed put between their neighbours; held at the ends."""
    lost = ~complete(rough.head, 2)
    if lost.all():
        raise InputError("no frame shows three rigid markers: the head cannot be placed")
    if not lost.any():
        return rough.head, ()
    known, head = np.flatnonzero(~lost), rough.head.copy()
    scale = np.cbrt(np.linalg.det(head[known, :3, :3]))
    frames = np.clip(np.flatnonzero(lost), known[0], known[-1])
    turns = Rotation.from_matrix(head[known, :3, :3] / scale[:, None, None])
    between = Slerp(known, turns)(frames) if len(known) > 1 else Rotation.concatenate([turns] * len(frames))
    head[lost, :3, :3] = between.as_matrix() * np.interp(frames, known, scale)[:, None, None]
    for axis in range(3):
        head[lost, axis, 3] = np.interp(frames, known, head[known, axis, 3])
    head[lost, 3] = (0.0, 0.0, 0.0, 1.0)
    method = "fewer than three rigid markers: placed between its neighbours"
    return head, tuple(Repair("head", (), first, last, method) for first, last in runs(lost))


def _placed(
    recorded: MarkerTrack, groups: MarkerGroups, settings: CleanSettings, reference: NDArray[np.float64]
) -> Normalised:
    if settings.normalise == "three point":
        return three_point(recorded, groups.nose, groups.left_eye, groups.right_eye, reference)
    return least_squares(recorded, groups.rigid, reference, settings.scale)


def _smoothed(
    final: Normalised, groups: MarkerGroups, settings: CleanSettings
) -> tuple[MarkerTrack, NDArray[np.float64]]:
    track = final.track
    if settings.upper_face is not None:
        track = smooth_group(track, groups.upper_face, settings.upper_face)
    if settings.mouth is not None:
        track = smooth_group(track, groups.mouth, settings.mouth)
    return track, smooth_head(final.head, track.rate, settings.head_hz)


def _share_filled(before: MarkerTrack, after: MarkerTrack) -> float:
    missing = np.isnan(before.positions).any(axis=2) & np.isfinite(after.positions).all(axis=2)
    return float(missing.mean())


def _listed(items: tuple[Repair, ...] | tuple[Fault, ...], most: int = 5) -> str:
    head = "; ".join(str(item) for item in items[:most])
    return f"{len(items)}: {head}" + ("; ..." if len(items) > most else "")
