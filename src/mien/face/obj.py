"""Wavefront OBJ: polygon meshes in and out.

Read: ``v`` (with or without vertex colours), ``vt``, ``f`` with any number of corners and negative indices; ``o``,
``g``, ``s``, ``usemtl``, ``mtllib``, ``vn``, ``l``, ``p`` are passed over. All faces make one part: vertex numbers stay
those of the file (counted from 0), which is what tree configurations and example poses go by.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import check_begun
from mien.core.plain_text import text_lines
from mien.face.model import Face, Material, Part

__all__ = ["MESH", "Mesh", "face_of_mesh", "obj_rows", "read_obj", "write_obj"]

MESH = "mesh"
"""Name of the one part of a face made from an OBJ file."""
_LONGEST_JOINED = 1_000_000  # characters
_PASSED_OVER = {"o", "g", "s", "usemtl", "mtllib", "vn", "vp", "l", "p", "cstype", "deg", "curv", "surf", "end", "parm"}


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh as read.

    Attributes
    ----------
    vertices : ndarray of float64, shape (n, 3)
        In the file's own unit.
    triangles : ndarray of int32, shape (t, 3)
        Polygons cut into fans.
    uv : ndarray of float64, shape (n, 2)
        (0, 0) is the picture's upper left corner; zero where the file has none. A vertex with several texture places
        keeps its first.
    colours : ndarray of float64, shape (n, 3)
        sRGB 0..1; ones where the file has none.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uv: NDArray[np.float64]
    colours: NDArray[np.float64]


@guarded("an OBJ file")
def read_obj(path: str | Path) -> Mesh:
    """Read an OBJ file.

    Raises
    ------
    InputError
        If the file is missing or no text, has no vertices, or a line cannot be understood (file and line are named).
    """
    path = Path(path)
    points: list[list[float]] = []
    places: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    place_of: dict[int, int] = {}
    for number, kind, *fields in obj_rows(path):
        try:
            if kind == "v":
                points.append(_numbers(fields, 3, 7))
            elif kind == "vt":
                places.append(_numbers(fields, 1, 3))
            elif kind == "f":
                corners = [_corner(field, len(points), len(places)) for field in fields]
                if len(corners) < 3:
                    raise ValueError(f"a face has three corners or more, not {len(corners)}")
                for vertex, place in corners:
                    if place is not None:
                        place_of.setdefault(vertex, place)
                own = [vertex for vertex, _ in corners]
                triangles += [(own[0], own[i], own[i + 1]) for i in range(1, len(own) - 1)]
            elif kind not in _PASSED_OVER:
                raise ValueError(f"{kind!r} starts no line of an OBJ file")
        except ValueError as problem:
            raise InputError(f"{path}:{number}: {problem}") from problem
    if not points:
        raise InputError(f"{path} holds no vertices: is it an OBJ file?")
    return _mesh(points, places, triangles, place_of)


def obj_rows(path: Path) -> Iterator[tuple[Any, ...]]:
    """Number, kind and fields of each line of an OBJ or MTL file that holds any; a backslash at its end joins two.

    Raises
    ------
    InputError
        If it cannot be read, or is larger than the limits ``mesh`` and ``rows``.
    """
    check_begun(path)
    joined = ""
    for number, line in enumerate(text_lines(path, "mesh"), 1):
        joined += line.partition("#")[0]
        if joined.endswith("\\") and len(joined) < _LONGEST_JOINED:
            joined = joined[:-1] + " "
            continue
        if row := joined.split():
            yield (number, *row)
        joined = ""


def _mesh(
    points: list[list[float]],
    places: list[list[float]],
    triangles: list[tuple[int, int, int]],
    place_of: dict[int, int],
) -> Mesh:
    uv, colours = np.zeros((len(points), 2)), np.ones((len(points), 3))
    for vertex, place in place_of.items():
        found = [*places[place], 0.0][:2]
        uv[vertex] = found[0], 1.0 - found[1]
    coloured = [number for number, point in enumerate(points) if len(point) >= 6]
    if coloured:
        colours[coloured] = np.clip([points[number][3:6] for number in coloured], 0, 1)
    vertices = np.array([point[:3] for point in points])
    return Mesh(vertices, np.array(triangles, dtype=np.int32).reshape(-1, 3), uv, colours)


def _numbers(fields: list[str], least: int, most: int) -> list[float]:
    if not least <= len(fields) <= most:
        raise ValueError(f"expected {least} to {most} numbers, got {len(fields)}")
    numbers = [float(field) for field in fields]
    if not np.isfinite(numbers).all():
        raise ValueError(f"a number is not finite: {' '.join(fields)}")
    return numbers


def _corner(field: str, points: int, places: int) -> tuple[int, int | None]:
    parts = field.split("/")
    vertex = _index(parts[0], points, "vertex")
    place = _index(parts[1], places, "texture place") if len(parts) > 1 and parts[1] else None
    return vertex, place


def _index(text: str, count: int, what: str) -> int:
    number = int(text)
    index = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= index < count:
        raise ValueError(f"{what} {text} is not among the {count} so far")
    return index


def write_obj(path: str | Path, vertices: ArrayLike, triangles: ArrayLike) -> None:
    """Write vertices (n, 3) and triangles (t, 3), counted from 0, as an OBJ file; six decimals.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    points, faces = np.asarray(vertices, dtype=np.float64), np.asarray(triangles) + 1
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    lines += [f"f {a} {b} {c}" for a, b, c in faces]
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def face_of_mesh(mesh: Mesh, name: str) -> Face:
    """A face of one part, `MESH`, that nothing moves yet: a parameter tree can (`mien.face.deformers.with_tree`).

    The mesh is taken as it stands: a tree's configuration is written in its unit and axes.
    """
    count = len(mesh.vertices)
    part = Part(
        name=MESH,
        vertices=mesh.vertices.astype(np.float32),
        triangles=mesh.triangles,
        uv=mesh.uv.astype(np.float32),
        colours=mesh.colours.astype(np.float32),
        material=Material("skin", (0.80, 0.62, 0.53), roughness=0.6, scatter=0.3),
        head_weight=np.ones(count, np.float32),
    )
    return Face(name, (part,), (), (0.0, 0.0, 0.0), {}, "")
