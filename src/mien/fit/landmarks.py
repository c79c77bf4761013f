"""Named landmarks on heads, and the files they are given in.

`LANDMARKS` (``assets/fitting/landmarks.toml``) says what each name means and where it lies on the default face. A file
gives some of them, in one of three notations::

    name,x,y,z          CSV: three numbers, or one: the number of a vertex, counted from 0
    nose_tip,0,-35,42

    {"nose_tip": [0, -35, 42], "chin": 733}      JSON

    nose_tip = [0, -35, 42]                      TOML
    chin = 733

or the 68 points of iBUG's scheme (Sagonas et al. 2013) in their order: a ``.pts`` file, or a CSV of 68 rows of numbers.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.border import guarded
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import parsed_json, read_plain_text
from mien.core.table_rows import parsed_table

__all__ = ["Landmark", "known_landmarks", "needed_landmarks", "other_side", "places_of_landmarks", "read_landmarks"]

_KINDS = {".csv": "CSV", ".json": "JSON", ".toml": "TOML", ".pts": "PTS"}
_IBUG: dict[str, tuple[int, ...]] = {  # counted from 0; the mean of several
    "eye_outer_right": (36,), "eye_inner_right": (39,), "eye_inner_left": (42,), "eye_outer_left": (45,),
    "nose_tip": (30,), "nose_bridge": (27,), "nose_base": (33,), "nose_wing_right": (31,), "nose_wing_left": (35,),
    "lip_corner_right": (48,), "lip_corner_left": (54,), "lip_upper_outer": (51,), "lip_lower_outer": (57,),
    "lip_upper_inner": (62,), "lip_lower_inner": (66,), "chin_bottom": (8,), "lid_upper_right": (37, 38),
    "lid_lower_right": (40, 41), "lid_upper_left": (43, 44), "lid_lower_left": (46, 47), "brow_outer_right": (17,),
    "brow_middle_right": (19,), "brow_inner_right": (21,), "brow_inner_left": (22,), "brow_middle_left": (24,),
    "brow_outer_left": (26,),
}  # fmt: skip


@dataclass(frozen=True)
class Landmark:
    """A named place on a head.

    Attributes
    ----------
    vertex : int
        Of the default face's skin.
    needed : bool
        Whether a head is sought where it is not given.
    words : str
    """

    vertex: int
    needed: bool
    words: str


@cache
def known_landmarks() -> dict[str, Landmark]:
    """All landmarks by name.

    Examples
    --------
    >>> known_landmarks()["nose_tip"].words
    'the foremost point of the nose'
    """
    path = asset("fitting/landmarks.toml")
    return {name: Landmark(**facts) for name, facts in tomllib.loads(path.read_text(encoding="utf-8")).items()}


def needed_landmarks() -> tuple[str, ...]:
    """Names of those without which the head is sought in the mesh."""
    return tuple(name for name, landmark in known_landmarks().items() if landmark.needed)


def other_side(name: str) -> str:
    """The landmark of the other side, or the same where there is none.

    Examples
    --------
    >>> other_side("eye_inner_left"), other_side("chin")
    ('eye_inner_right', 'chin')
    """
    if name.endswith("_left"):
        return name[:-5] + "_right"
    return name[:-6] + "_left" if name.endswith("_right") else name


@guarded("landmarks")
def read_landmarks(path: str | Path, width: int = 3) -> dict[str, tuple[float, ...]]:
    """Read a file of landmarks: each name with ``width`` numbers, or with one (the number of a vertex).

    Raises
    ------
    InputError
        If the file is missing or not understood, a name is unknown or comes twice, or numbers are wrong; with the line
        where the notation has lines.
    """
    path = Path(path)
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise InputError(
            f"{path}: landmarks are read from .csv, .json, .toml or .pts, not from {path.suffix or 'no suffix'!r}"
        )
    return parsed_landmarks(read_plain_text(path, "landmarks")[0], kind, str(path), width)


def parsed_landmarks(text: str, kind: str, where: str, width: int) -> dict[str, tuple[float, ...]]:
    """Landmarks out of a text in one of the notations; `read_landmarks` says more."""
    points = _sixty_eight(text, width) if kind in ("CSV", "PTS") else None
    if points is not None:
        return {name: tuple(points[list(numbers)].mean(axis=0).tolist()) for name, numbers in _IBUG.items()}
    if kind == "PTS":
        raise InputError(f"{where}: no iBUG file: 68 rows of {width} numbers are expected")
    if kind == "CSV":
        return _from_csv(text, where, width)
    try:
        data = parsed_json(text, object_pairs_hook=_once) if kind == "JSON" else tomllib.loads(text)
    except (ValueError, RecursionError) as problem:
        raise InputError(f"{where}: no {kind} ({problem})") from problem
    if isinstance(data, dict) and isinstance(data.get("landmarks"), dict):
        data = data["landmarks"]
    return checked_landmarks(data, where, width)


def _sixty_eight(text: str, width: int) -> NDArray[np.float64] | None:
    """The 68 rows of numbers of a text that holds nothing else but iBUG's frame and a head line."""
    rows = []
    for line in text.replace(",", " ").splitlines():
        words = line.split()
        if not words or words[0].lower().rstrip(":") in ("version", "n_points", "{", "}", "x", "#"):
            continue
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            return None
    if len(rows) != 68 or {len(row) for row in rows} - {width, width + 1} or len({len(row) for row in rows}) > 1:
        return None
    points = np.array(rows)[:, -width:]  # (a number before the coordinates is the point's own)
    return points if np.isfinite(points).all() else None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{next(name for name in names if names.count(name) > 1)!r} comes twice")
    return found


def checked_landmarks(data: Any, where: str, width: int) -> dict[str, tuple[float, ...]]:
    """Landmarks out of a mapping of names to a number or a list of numbers."""
    if not isinstance(data, Mapping):
        raise InputError(f"{where}: expected names with their places, got {type(data).__name__}")
    found = {}
    for name, value in data.items():
        numbers = value if isinstance(value, list) else [value]
        found[_checked_name(name, where)] = _checked_numbers(numbers, f"{where}: {name}", width)
    if not found:
        raise InputError(f"{where} holds no landmarks")
    return found


def _from_csv(text: str, where: str, width: int) -> dict[str, tuple[float, ...]]:
    found: dict[str, tuple[float, ...]] = {}
    table = parsed_table(text, where, "landmarks")
    for line, row in table.rows:
        cells = [table.spelt(cell) for cell in row]
        while not cells[-1]:
            cells.pop()
        if cells[0].startswith("#") or (line == 1 and cells[0].lower() in ("name", "landmark")):
            continue
        name = _checked_name(cells[0], f"{where}:{line}")
        if name in found:
            raise InputError(f"{where}:{line}: {name!r} comes twice")
        try:
            numbers: list[Any] = [float(cell) if width > 1 or "." in cell else int(cell) for cell in cells[1:]]
        except ValueError as problem:
            raise InputError(f"{where}:{line}: {problem}") from problem
        found[name] = _checked_numbers(numbers, f"{where}:{line}: {name}", width)
    if not found:
        raise InputError(f"{where} holds no landmarks")
    return found


def _checked_name(name: Any, where: str) -> str:
    if name not in known_landmarks():
        problem = unknown_name("landmark", str(name), known_landmarks())
        raise InputError(f"{where}: {problem}")
    return str(name)


def _checked_numbers(numbers: list[Any], where: str, width: int) -> tuple[float, ...]:
    if not all(isinstance(n, int | float) and not isinstance(n, bool) and np.isfinite(n) for n in numbers):
        raise InputError(f"{where}: expected numbers, got {numbers!r}")
    if len(numbers) == 1 and width == 3:
        if numbers[0] != int(numbers[0]) or numbers[0] < 0:
            raise InputError(f"{where}: one number is a vertex, counted from 0; got {numbers[0]:g}")
    elif len(numbers) != width:
        one = " or one (the number of a vertex)" if width == 3 else ""
        raise InputError(f"{where}: expected {width} numbers{one}, got {len(numbers)}")
    return tuple(float(n) for n in numbers)


def places_of_landmarks(
    given: Mapping[str, tuple[float, ...]], vertices: NDArray[np.float64], where: str
) -> dict[str, NDArray[np.float64]]:
    """Landmarks as places (3,), vertex numbers looked up.

    Raises
    ------
    InputError
        If a vertex is not on the mesh.
    """
    places = {}
    for name, numbers in given.items():
        if len(numbers) == 1 and int(numbers[0]) >= len(vertices):
            raise InputError(f"{where}: {name}: vertex {int(numbers[0])} is not among the mesh's {len(vertices)}")
        places[name] = vertices[int(numbers[0])] if len(numbers) == 1 else np.array(numbers)
    return places
