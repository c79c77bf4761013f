"""ARKit face capture: CSV of Live Link Face, with a sound or video file of the same name.

The 52 weights say how strongly a face does something, not where its points are. They move the default face, whose
surface then carries the markers of the layout; the weights are kept as channels of the take.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import Layout, load_layout
from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.table_rows import first_row
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import SOUND, TRANSCRIPTS, VIDEO, Beside, listed
from mien.corpus.recipes import Recipe
from mien.face.library import load_face
from mien.face.posing import Poser, head_rotation
from mien.formats.livelink import COLUMNS, read_livelink
from mien.formats.sound_files import read_audio

__all__ = ["READER", "carried_markers"]

Floats = NDArray[np.float64]


def _is_livelink(path: Path) -> bool:
    if path.suffix.lower() != ".csv":
        return False
    header = [cell.lower() for cell in first_row(path)]
    return COLUMNS[0].lower() in header and "jawopen" in header


def _find(source: Path) -> list[Found]:
    beside = Beside(source)
    files = [path for path in listed(source) if _is_livelink(path)]
    return [Found(p.stem, p, beside.near(p, (*SOUND, *VIDEO)), beside.near(p, TRANSCRIPTS)) for p in files]


def _read(found: Found, recipe: Recipe) -> Raw:
    channels, told = read_livelink(found.motion, FrameRate.of(recipe.fps) if recipe.fps else None)
    if not len(channels):
        raise InputError(f"{found.motion}: holds no frame of motion")
    audio, notes = read_audio(found.sound) if found.sound else (None, ())
    layout = load_layout(recipe.layout or "face-102")
    return Raw(
        carried_markers(channels, layout), "mm", audio, channels.select(ARKIT), _head_motion(channels), (*told, *notes)
    )


def carried_markers(channels: ChannelTrack, layout: Layout) -> MarkerTrack:
    """Where the markers of a layout go when channels move the default face, the head held still.

    Parameters
    ----------
    channels : ChannelTrack
    layout : Layout

    Returns
    -------
    MarkerTrack
        Millimetres, in the axes of the face.

    Examples
    --------
    >>> track = ChannelTrack(("jawOpen",), [[0.0], [1.0]], FrameRate.of(30))
    >>> chin = carried_markers(track, load_layout("mpeg4-32")).positions[:, -1, 1]
    >>> bool(chin[0] - chin[1] > 10)
    True
    """
    poser = _poser()
    parts, vertices, offsets = _ties(layout)
    rows = channels.select(ARKIT).values
    places = np.empty((len(rows), len(layout.markers), 3))
    for frame, row in enumerate(rows):
        posed = poser.pose(row).parts
        places[frame] = offsets + [posed[part].vertices[vertex] for part, vertex in zip(parts, vertices, strict=True)]
    return MarkerTrack(layout.markers, places, channels.rate)


@cache
def _poser() -> Poser:
    return Poser(load_face(), ARKIT)


def _ties(layout: Layout) -> tuple[list[int], list[int], Floats]:
    """For each marker the part and vertex nearest to its place, and what it is away from there."""
    face = load_face()
    carriers = [
        i for i, part in enumerate(face.parts) if part.name == "skin" or part.name in {e.part for e in face.eyes}
    ]
    parts, vertices, offsets = [], [], []
    for place in layout.places:
        best = (np.inf, 0, 0)
        for number in carriers:
            away = np.linalg.norm(face.parts[number].vertices - place, axis=1)
            nearest = int(np.argmin(away))
            best = min(best, (float(away[nearest]), number, nearest))
        parts.append(best[1])
        vertices.append(best[2])
        offsets.append(place - face.parts[best[1]].vertices[best[2]])
    return parts, vertices, np.array(offsets, dtype=np.float64)


def _head_motion(channels: ChannelTrack) -> Floats:
    """The head's turns about its pivot, shape (frames, 4, 4)."""
    pivot = np.array(load_face().head_pivot)
    angles = channels.select(("headYaw", "headPitch", "headRoll")).values
    motion = np.tile(np.eye(4), (len(angles), 1, 1))
    for frame, (yaw, pitch, roll) in enumerate(angles):
        motion[frame, :3, :3] = head_rotation(yaw, pitch, roll)
        motion[frame, :3, 3] = pivot - motion[frame, :3, :3] @ pivot
    return motion


READER = Reader(
    "livelink",
    "CSV files of Live Link Face (ARKit weights) with a sound or video file of the same name",
    lambda source: any(_is_livelink(path) for path in listed(source)),
    _find,
    _read,
)
