"""Raw motion becomes motion in the head: the cleaning that a recipe asks for, and what was done, in few words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.clean import Cleaned, CleanSettings, clean
from mien.capture.cleaning.faults import find_faults
from mien.capture.cleaning.perspective import to_millimetres
from mien.capture.cleaning.spikes import SpikeSettings
from mien.capture.cleaning.swaps import SwapSettings
from mien.capture.cleaning.tracker_jitter import JitterSettings
from mien.capture.layouts import Layout
from mien.core.errors import InputError, Note
from mien.core.tracks import MarkerTrack
from mien.corpus.orientation import in_layout_order, upright
from mien.corpus.readers.raw_recordings import Raw
from mien.corpus.recipes import Recipe

__all__ = ["Settled", "reference_of", "settled"]

_MOST_REPAIRS_SAID = 6
_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Settled:
    """Motion in the head, in the order of the layout.

    Attributes
    ----------
    track : MarkerTrack
        NaN only for markers that were dropped, and where nothing could be filled.
    head : ndarray, shape (frames, 4, 4)
        ``head @ track`` is where the markers were recorded.
    filled : int
        Marker positions that were filled.
    dropped : tuple of str
        Markers hardly ever seen: NaN throughout.
    notes : tuple of Note
    """

    track: MarkerTrack
    head: Floats
    filled: int
    dropped: tuple[str, ...]
    notes: tuple[Note, ...]


def reference_of(raw: Raw, recipe: Recipe, layout: Layout, source: str) -> Floats:
    """The frame of a recording to lay all others on, upright in the axes of the face.

    Returns
    -------
    ndarray, shape (markers, 3)
        Millimetres; pixels are scaled so that the layout's scale holds in this very frame.

    Raises
    ------
    InputError
        If no frame will do.
    """
    if raw.head is not None:
        return np.array(in_layout_order(raw.markers, layout, source)[0].positions[0])
    recorded, _ = _metric(raw, recipe, layout, source)
    cleaned = _cleaned(recorded, recipe, layout, None, None, source)
    complete = np.isfinite(recorded.positions).all(axis=(1, 2))
    frame = int(cleaned.report.reference_frame or 0)
    if recipe.reference == "first" and complete.any():
        frame = int(np.argmax(complete))
    reference = np.array(_in_full(cleaned.track, layout).positions[frame])
    if raw.units == "pixels" and layout.scale is not None:
        first, second, distance = layout.scale
        one, other = layout.index([first, second])
        reference *= distance / np.linalg.norm(reference[one] - reference[other])
    return upright(reference, layout, layout.rigid)


def settled(raw: Raw, recipe: Recipe, layout: Layout, reference: Floats, source: str) -> Settled:
    """Clean a recording and lay it on the reference frame.

    Parameters
    ----------
    raw : Raw
        Motion whose head a reader took out already (``raw.head``) is only checked.
    recipe : Recipe
    layout : Layout
    reference : ndarray, shape (markers, 3)
        As `reference_of` gives it for one recording of the speaker.
    source : str
        Named in messages.

    Raises
    ------
    InputError
        If the recording cannot be used.
    """
    seconds = raw.audio.duration if raw.audio is not None else None
    recorded, notes = _metric(raw, recipe, layout, source)
    if raw.head is not None:
        grave = [f.message for f in find_faults(recorded, None, seconds) if f.severity == "refuse"]
        if grave:
            raise InputError(f"{source}: {'; '.join(grave)}")
        return Settled(recorded, raw.head, 0, (), notes)
    cleaned = _cleaned(recorded, recipe, layout, reference, seconds, source)
    names = cleaned.track.names
    head, track = _held(cleaned.head), cleaned.track
    filled = round(cleaned.report.filled * len(recorded) * len(names))
    dropped = tuple(name for name in layout.markers if name not in names)
    return Settled(_in_full(track, layout), head, filled, dropped, (*notes, *_told(cleaned, source)))


def _metric(raw: Raw, recipe: Recipe, layout: Layout, source: str) -> tuple[MarkerTrack, tuple[Note, ...]]:
    """Markers in the order of the layout; pixels in millimetres."""
    track, notes = in_layout_order(raw.markers, layout, source)
    if raw.units != "pixels":
        factor = _MM.get(raw.units, 1.0)
        return MarkerTrack(track.names, track.positions * factor, track.rate), notes
    if layout.scale is None:
        raise InputError(f"{source}: layout {layout.name} has no [scale], so pixels cannot become millimetres")
    first, second, distance = layout.scale
    metric = to_millimetres(track, (first, second), distance, mirrored=recipe.mirrored)
    return metric.track, (*notes, Note("note", metric.assumption))


def _cleaned(
    track: MarkerTrack,
    recipe: Recipe,
    layout: Layout,
    reference: Floats | None,
    seconds: float | None,
    source: str,
) -> Cleaned:
    settings = CleanSettings(
        normalise="three point" if recipe.method == "three-point" else "least squares",
        scale=recipe.method == "similarity",
        head_hz=CleanSettings.head_hz if recipe.filter_jitter else 0.0,
        swaps=SwapSettings() if recipe.mend else None,
        spikes=SpikeSettings() if recipe.mend else None,
        upper_face=JitterSettings() if recipe.filter_jitter else None,
        mouth=JitterSettings() if recipe.filter_jitter else None,
    )
    try:
        return clean(track, layout.motion_groups(), settings, reference, seconds)
    except InputError as problem:
        raise InputError(f"{source}: {problem}") from problem


def _held(head: Floats) -> Floats:
    """The head's motion without holes: an empty frame keeps that of the nearest frame that is not."""
    placed = np.flatnonzero(np.isfinite(head).all(axis=(1, 2)))
    nearest = placed[np.argmin(np.abs(placed[None] - np.arange(len(head))[:, None]), axis=1)]
    return np.asarray(head[nearest])


def _in_full(track: MarkerTrack, layout: Layout) -> MarkerTrack:
    """All markers of the layout again; those dropped are NaN."""
    positions = np.full((len(track), len(layout.markers), 3), np.nan)
    positions[:, layout.index(track.names)] = track.positions
    return MarkerTrack(layout.markers, positions, track.rate)


def _told(cleaned: Cleaned, source: str) -> tuple[Note, ...]:
    """Faults that were not mended, each; repairs, the first few."""
    report = cleaned.report
    said = [Note("warning", f"{source}: {fault}") for fault in report.faults if fault.severity == "warn"]
    said += [Note("note", f"{source}: {repair}") for repair in report.repairs[:_MOST_REPAIRS_SAID]]
    if len(report.repairs) > _MOST_REPAIRS_SAID:
        said.append(Note("note", f"{source}: {len(report.repairs) - _MOST_REPAIRS_SAID} more repairs of these kinds"))
    return tuple(said)
