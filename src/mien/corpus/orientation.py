"""Markers brought into the order of a layout, and a reference frame into the axes of the face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import apply, best_similarity
from mien.capture.layouts import Layout
from mien.core.errors import InputError, Note
from mien.core.tracks import MarkerTrack

__all__ = ["in_layout_order", "upright"]

Floats = NDArray[np.float64]


def in_layout_order(track: MarkerTrack, layout: Layout, source: str) -> tuple[MarkerTrack, tuple[Note, ...]]:
    """The markers of a layout in its order; those that the recording lacks are NaN, those it has beyond are left out.

    Raises
    ------
    InputError
        If fewer than three rigid markers of the layout are there.
    """
    there = {name: number for number, name in enumerate(track.names)}
    positions = np.full((len(track), len(layout.markers), 3), np.nan)
    for number, name in enumerate(layout.markers):
        if name in there:
            positions[:, number] = track.positions[:, there[name]]
    extra = [name for name in track.names if name not in layout.markers]
    notes = []
    if extra:
        notes.append(Note("note", f"{source}: {len(extra)} markers beyond {layout.name}: {', '.join(extra[:8])}"))
    rigid = [name for name in layout.rigid if name in there]
    if len(rigid) < 3:
        raise InputError(
            f"{source}: expected three rigid markers of {layout.name} or more ({', '.join(layout.rigid[:4])}...), "
            f"got {len(rigid)}; is it another layout, or do the names need [rename] in a recipe?"
        )
    return MarkerTrack(layout.markers, positions, track.rate), tuple(notes)


def upright(reference: Floats, layout: Layout, markers: Sequence[str]) -> Floats:
    """A reference frame turned and moved, not scaled, into the axes of the face: laid on the layout's rigid markers.

    Parameters
    ----------
    reference : ndarray, shape (markers, 3)
        Of all markers of the layout, mm; NaN where one is missing.
    layout : Layout
    markers : sequence of str
        Those to lay on their places.
    """
    index = [i for i in layout.index(markers) if np.isfinite(reference[i]).all()]
    turn = best_similarity(reference[index], layout.places[index], np.ones(len(index)), scale=False)
    return np.asarray(apply(turn[None], reference[None])[0])
