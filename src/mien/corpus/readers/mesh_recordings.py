"""Meshes of one topology, a file a frame, as 3D corpora of speech keep them; some of their vertices are the markers.

Files: ``.ply`` and ``.obj`` (VOCASET, Multiface), ``.vl`` (BIWI: a count and that many places in 32 bits, little
endian), ``.bin`` (Multiface: places alone). The last number in a file's name is its frame. `Recipe.vertices` says which
vertex each marker of the layout is; the import finds them by fitting the default face to one of the meshes.
"""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.core.limits import check_size
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import SOUND, TRANSCRIPTS, Beside, listed
from mien.corpus.recipes import Recipe
from mien.formats.ply_rows import read_ply_rows
from mien.formats.sound_files import read_audio

__all__ = ["READER", "mesh_with_faces", "vertices_of"]

Floats = NDArray[np.float64]

_SUFFIXES = (".ply", ".obj", ".vl", ".bin")
_NUMBER = re.compile(r"(\d+)\D*\Z")


def _sequences(source: Path) -> dict[Path, list[Path]]:
    """Folders of two or more frames, with one file for each frame number, the first kind of `_SUFFIXES`."""
    folders: dict[Path, list[Path]] = defaultdict(list)
    for path in listed(source) if source.is_dir() else ():
        if path.suffix.lower() in _SUFFIXES and _NUMBER.search(path.stem):
            folders[path.parent].append(path)
    found = {}
    for folder, files in folders.items():
        kind = min((path.suffix.lower() for path in files), key=_SUFFIXES.index)
        frames = sorted((path for path in files if path.suffix.lower() == kind), key=_number)
        if len(frames) > 1 and len({_number(path) for path in frames}) == len(frames):
            found[folder] = frames
    return found


def _number(path: Path) -> int:
    match = _NUMBER.search(path.stem)
    return int(match[1]) if match else 0


def vertices_of(path: Path) -> Floats:
    """Places of a mesh's vertices in the file's order, shape (n, 3).

    Raises
    ------
    InputError
        If the file is damaged.
    """
    suffix = path.suffix.lower()
    if suffix == ".ply":
        table = read_ply_rows(path)["vertex"]
        return np.stack([table[axis][0] for axis in "xyz"], axis=1)
    if suffix == ".obj":
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], np.float64).reshape(-1, 3)
    raw = path.read_bytes()
    if suffix == ".vl":
        count = int(np.frombuffer(raw, "<u4", 1)[0]) if len(raw) >= 4 else -1
        if len(raw) != 4 + 12 * count:
            raise InputError(f"{path}: damaged .vl file: {len(raw)} bytes for {count} vertices")
        raw = raw[4:]
    return np.frombuffer(raw, "<f4").astype(np.float64).reshape(-1, 3)


def mesh_with_faces(source: Path, first: Path) -> Path:
    """The mesh that shows how the vertices of a frame hang together: itself, or one of as many vertices in the source.

    Raises
    ------
    InputError
        If there is none.
    """
    if first.suffix.lower() in (".ply", ".obj"):
        return first
    count = len(vertices_of(first))
    for path in listed(source):
        if path.suffix.lower() in (".ply", ".obj") and len(vertices_of(path)) == count:
            return path
    raise InputError(f"{source}: expected an .obj or .ply of {count} vertices, with the faces of {first.name}")


def _find(source: Path) -> list[Found]:
    beside = Beside(source)
    return [
        Found(folder.name, frames[0], beside.near(folder, SOUND), beside.near(folder, TRANSCRIPTS))
        for folder, frames in sorted(_sequences(source).items())
    ]


def _read(found: Found, recipe: Recipe) -> Raw:
    layout = load_layout(recipe.layout)
    missing = [name for name in layout.markers if name not in recipe.vertices]
    if missing:
        raise InputError(f"recipe {recipe.name}: no vertex for the marker {missing[0]!r} of {layout.name}")
    numbers = [recipe.vertices[name] for name in layout.markers]
    frames = _sequences(found.motion.parent)[found.motion.parent]
    first = _number(frames[0])
    length = _number(frames[-1]) - first + 1
    check_size("frames", length, str(found.motion.parent))
    places = np.full((length, len(numbers), 3), np.nan)  # a frame that is missing is a gap
    for path in frames:
        vertices = vertices_of(path)
        if max(numbers) >= len(vertices):
            raise InputError(f"{path}: {len(vertices)} vertices, expected more than {max(numbers)}")
        places[_number(path) - first] = vertices[numbers]
    if not recipe.fps:
        raise InputError(f"recipe {recipe.name}: give fps, meshes do not say it")
    audio, notes = read_audio(found.sound) if found.sound else (None, ())
    units = "" if recipe.units == "auto" else recipe.units
    return Raw(MarkerTrack(layout.markers, places, FrameRate.of(recipe.fps)), units, audio, notes=notes)


READER = Reader(
    "meshes",
    "folders of numbered meshes of one topology (.ply, .obj, .vl, .bin), with sound of the folder's name",
    lambda source: source.is_dir() and bool(_sequences(source)),
    _find,
    _read,
)
