"""Bare meshes out of OBJ, PLY, STL, glTF and USD files.

OBJ: `mien.face.obj.read_obj`, with the picture that its material names; where a picture is used, vertices are split
at the seams of their texture places (copies stand behind all others, so numbers stay those of the file). PLY: ASCII
and binary, any number of corners, colours of vertices. glTF: `mien.fit.mesh_glb`.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.limits import file_beside
from mien.core.pictures import opened_picture
from mien.face.foreign.gltf_document import is_gltf
from mien.face.obj import obj_rows, read_obj
from mien.fit.head_parts import GivenMesh
from mien.fit.mesh_glb import read_glb_mesh
from mien.fit.mesh_stl import read_stl
from mien.fit.mesh_usd import USD_SUFFIXES, read_usd_mesh
from mien.formats.ply_rows import read_ply_rows

__all__ = ["read_mesh", "read_picture"]

_LARGEST = 1e9  # of whatever unit; a head in micrometres has 3e5
Floats = NDArray[np.float64]


def read_picture(path: str | Path) -> NDArray[np.uint8]:
    """A picture as sRGB bytes (height, width, 3), turned upright by its EXIF orientation.

    Raises
    ------
    InputError
        If it is missing or no picture.
    """
    from PIL import ImageOps

    with opened_picture(path) as picture:
        return np.asarray(ImageOps.exif_transpose(picture).convert("RGB"))


@guarded("a mesh")
def read_mesh(path: str | Path, texture: str | Path | None = None) -> GivenMesh:
    """Read a mesh by its suffix, with a picture for its surface if one is given.

    Raises
    ------
    InputError
        If the file is missing, damaged, of another kind, or has no faces.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        mesh, texture = _read_obj(path, texture)
    elif suffix == ".ply":
        mesh = _read_ply(path)
    elif suffix == ".stl":
        mesh = _unpainted(*read_stl(path))
    elif suffix in USD_SUFFIXES:
        mesh = _unpainted(*read_usd_mesh(path))
    elif is_gltf(path):
        mesh = read_glb_mesh(path)
    else:
        told = "a head is read from .obj, .ply, .stl, .glb, .gltf, .vrm or .usd"
        raise InputError(f"{path}: {told}, not from {suffix or 'no suffix'!r}")
    if not len(mesh.triangles):
        raise InputError(f"{path} has no faces: a head's surface is needed, not points or lines")
    _check_surface(path, mesh)
    if texture is None:
        return mesh
    if not mesh.uv.any():
        raise InputError(f"{path} has no texture places for the picture {texture}")
    return GivenMesh(mesh.vertices, mesh.triangles, mesh.uv, mesh.colours, read_picture(texture))


def _check_surface(path: Path, mesh: GivenMesh) -> None:
    """Refuse points that all lie together or beyond all measure, and faces that span nothing."""
    size = float(np.ptp(mesh.vertices, axis=0).max())
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] for corner in range(3))
    if size < _LARGEST and np.abs(np.cross(b - a, c - a)).sum() > 0:
        return
    raise InputError(
        f"{path}: no surface: its points lie together, in a line, or are beyond all measure ({size:.3g} wide)"
    )


def _unpainted(vertices: Floats, triangles: NDArray[np.int32], colours: Floats | None = None) -> GivenMesh:
    colours = np.ones((len(vertices), 3)) if colours is None else colours
    return GivenMesh(vertices, triangles, np.zeros((len(vertices), 2)), colours)


def _read_obj(path: Path, texture: str | Path | None) -> tuple[GivenMesh, str | Path | None]:
    """An OBJ file; the picture that its material names, unless one is given or there are several."""
    read = read_obj(path)
    mesh = GivenMesh(read.vertices, read.triangles, read.uv, read.colours)
    texture = texture if texture is not None else _picture_of_material(path)
    return (mesh, None) if texture is None else (_split_at_seams(path, mesh), texture)


def _lines(path: Path, *kinds: str) -> list[list[str]]:
    """The fields of an OBJ or MTL file's lines of some kinds."""
    return [row for _, *row in obj_rows(path) if row[0] in kinds]


def _picture_of_material(path: Path) -> Path | None:
    """The one picture (``map_Kd``) that the materials of an OBJ file name, if it lies beside it."""
    found = set()
    for row in _lines(path, "mtllib"):
        materials = _beside(path, " ".join(row[1:]))
        for material in _lines(materials, "map_Kd") if materials else ():
            picture = _beside(path, material[-1])
            if picture is not None:
                found.add(picture)
    return found.pop() if len(found) == 1 else None


def _beside(path: Path, name: str) -> Path | None:
    """A file that an OBJ names, in its folder: of a place on another disk the last name counts."""
    for candidate in (name, name.replace("\\", "/").rpartition("/")[2]):
        with contextlib.suppress(InputError):
            return file_beside(path, candidate)
    return None


def _split_at_seams(path: Path, mesh: GivenMesh) -> GivenMesh:
    """Give vertices with several texture places a copy for each further one, behind all others."""
    rows = _lines(path, "v", "vt", "f")
    places = [[float(row[1]), 1.0 - float(row[2]) if len(row) > 2 else 1.0] for row in rows if row[0] == "vt"]
    if not places:
        return mesh
    corners: list[tuple[int, int]] = []
    points = seen = 0
    for row in rows:
        points, seen = points + (row[0] == "v"), seen + (row[0] == "vt")
        if row[0] == "f":
            own = [_numbers_of(field, points, seen) for field in row[1:]]
            corners += [own[k] for i in range(1, len(own) - 1) for k in (0, i, i + 1)]
    pairs = np.array(corners)
    kinds, first, which = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    number = np.full(len(kinds), -1)
    taken: set[int] = set()
    copies: list[int] = []
    for kind in np.argsort(first, kind="stable"):  # in the order of the file: a vertex keeps its first place
        vertex = int(kinds[kind, 0])
        if vertex in taken:
            number[kind] = len(mesh.vertices) + len(copies)
            copies.append(int(kind))
        else:
            taken.add(vertex)
            number[kind] = vertex
    source = kinds[copies, 0] if copies else np.zeros(0, dtype=np.int64)
    at = np.where(kinds[copies, 1] >= 0, kinds[copies, 1], 0) if copies else source
    return GivenMesh(
        np.concatenate([mesh.vertices, mesh.vertices[source]]),
        number[which.ravel()].reshape(-1, 3).astype(np.int32),
        np.concatenate([mesh.uv, np.array(places)[at]]),
        np.concatenate([mesh.colours, mesh.colours[source]]),
    )


def _numbers_of(field: str, points: int, places: int) -> tuple[int, int]:
    """Numbers from 0 of a corner's vertex and its texture place (-1: none)."""
    parts = field.split("/")
    vertex = int(parts[0])
    place = int(parts[1]) if len(parts) > 1 and parts[1] else 0
    return (vertex - 1 if vertex > 0 else points + vertex), (
        place - 1 if place > 0 else places + place if place else -1
    )


# ------------------------------------------------------------------ PLY


def _read_ply(path: Path) -> GivenMesh:
    try:
        return _ply_mesh(read_ply_rows(path))
    except (ValueError, KeyError, IndexError) as problem:
        raise InputError(f"{path}: damaged PLY file ({problem})") from problem


def _ply_mesh(rows: dict[str, Any]) -> GivenMesh:
    table = rows["vertex"]
    vertices = np.stack([table[axis][0] for axis in "xyz"], axis=1)
    given = rows.get("face", [])
    if isinstance(given, list):
        given = [(f[0], f[i], f[i + 1]) for f in given for i in range(1, len(f) - 1)]
    faces = np.array(given, dtype=np.int64).reshape(-1, 3)
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise ValueError(f"a face names a vertex beyond the {len(vertices)} there are")
    if not np.isfinite(vertices).all():
        raise ValueError("a coordinate is not finite")
    colours = np.ones_like(vertices)
    if {"red", "green", "blue"} <= set(table):
        whole = 1.0 if table["red"][1].startswith(("f", "d")) else 255.0
        colours = np.clip(np.stack([table[c][0] for c in ("red", "green", "blue")], axis=1) / whole, 0, 1)
    return _unpainted(vertices, faces.astype(np.int32), colours)
