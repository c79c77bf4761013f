"""Marker positions in CSV or NPZ files, with a sound file of the same name.

CSV: one line per frame; three columns ``NAME_x``, ``NAME_y``, ``NAME_z`` per marker (``.``, ``:`` or a blank may stand
for ``_``); a column ``time`` in seconds, unless the recipe gives fps; a column ``frame`` is passed over. An empty cell
or ``nan``: the marker was not seen. NPZ: ``markers`` (frames, markers, 3), ``names``, and ``fps``, or ``rate`` as
numerator and denominator; ``units`` if it has any. The motion files of a corpus are such files.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import load_arrays
from mien.core.table_rows import first_row, read_rows
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import found_by_suffix, listed
from mien.corpus.recipes import Recipe
from mien.formats.sound_files import read_audio

__all__ = ["READER"]

_COLUMN = re.compile(r"(?P<marker>.+?)[_.: ](?P<axis>[xyz])", re.IGNORECASE)
_IRREGULAR = 0.2  # of a frame: a step in time that differs by more is not one frame


def _is_track(path: Path) -> bool:
    if path.suffix.lower() == ".npz":
        try:
            with ZipFile(path) as archive:
                return {"markers.npy", "names.npy"} <= set(archive.namelist())
        except (OSError, ValueError, BadZipFile, NotImplementedError):
            return False
    if path.suffix.lower() != ".csv":
        return False
    return bool(_triples(first_row(path)))


def _find(source: Path) -> list[Found]:
    return [found for found in found_by_suffix(source, (".csv", ".npz")) if _is_track(found.motion)]


def _read(found: Found, recipe: Recipe) -> Raw:
    path = found.motion
    names, positions, rate, units = _read_npz(path) if path.suffix.lower() == ".npz" else _read_csv(path)
    if recipe.fps:
        rate = FrameRate.of(recipe.fps)
    if rate is None:
        raise InputError(f"{path}: no frame rate in it (column 'time', or array 'fps'); give fps in a recipe")
    try:
        track = MarkerTrack([recipe.rename.get(name, name) for name in names], positions, rate)
    except InputError as problem:
        raise InputError(f"{path}: {problem}") from problem
    if not len(track):
        raise InputError(f"{path}: holds no frame of motion")
    audio, notes = read_audio(found.sound) if found.sound else (None, ())
    return Raw(track, units if recipe.units == "auto" else recipe.units, audio, notes=notes)


Content = tuple[Sequence[str], NDArray[np.float64], FrameRate | None, str]


def _read_npz(path: Path) -> Content:
    file = load_arrays(path)
    if not {"markers", "names"} <= set(file):
        raise InputError(f"{path}: expected arrays 'markers' and 'names', got {', '.join(file)[:80]}")
    names = [str(name) for name in np.atleast_1d(file["names"])]
    positions = np.asarray(file["markers"], dtype=np.float64)
    units = str(file["units"]) if "units" in file else ""
    return names, positions, _npz_rate(path, file), units


def _npz_rate(path: Path, file: Mapping[str, NDArray[np.generic]]) -> FrameRate | None:
    if "rate" in file:
        top, bottom = (int(n) for n in np.atleast_1d(file["rate"]))
        value: Fraction | float = Fraction(top, bottom) if bottom else 0.0
    elif "fps" in file:
        value = float(np.asarray(file["fps"], dtype=np.float64))
    else:
        return None
    if not value > 0:
        raise InputError(f"{path}: its frame rate is {float(value):g}; give fps in a recipe")
    return FrameRate.of(value)


def _triples(header: Sequence[str]) -> dict[str, dict[str, int]]:
    """Columns of each marker by axis; markers without all three are left out."""
    table: dict[str, dict[str, int]] = {}
    for place, column in enumerate(header):
        match = _COLUMN.fullmatch(column.strip())
        if match:
            table.setdefault(match["marker"], {})[match["axis"].lower()] = place
    return {marker: axes for marker, axes in table.items() if len(axes) == 3}


def _read_csv(path: Path) -> Content:
    table = read_rows(path, "a table of markers")
    (_, header), *rows = table.rows
    markers = _triples(header)
    places = [[axes[axis] for axis in "xyz"] for axes in markers.values()]
    positions = np.full((len(rows), len(markers), 3), np.nan)
    times = []
    header = [column.lower() for column in header]
    for frame, (line, row) in enumerate(rows):
        if len(row) != len(header):
            raise InputError(f"{path}, line {line}: {len(header)} columns expected, got {len(row)}: is it cut short?")
        cells = [table.spelt(cell) for cell in row]
        for marker, triple in enumerate(places):
            positions[frame, marker] = [_number(path, line, frame, cells[place]) for place in triple]
        if "time" in header:
            times.append(_number(path, line, frame, cells[header.index("time")]))
    rate = _rate_of(path, times, [line for line, _ in rows]) if "time" in header else None
    return list(markers), positions, rate, ""


def _number(path: Path, line: int, frame: int, cell: str) -> float:
    try:
        return float(cell) if cell else np.nan
    except ValueError as problem:
        raise InputError(f"{path}, line {line} (frame {frame}): expected a number, got {cell!r}") from problem


def _rate_of(path: Path, times: Sequence[float], lines: Sequence[int]) -> FrameRate:
    steps = np.diff(times)
    if not len(steps):
        raise InputError(f"{path}: one frame only, so its frame rate is not known; give fps in a recipe")
    step = float(np.median(steps))
    if not step > 0:
        raise InputError(f"{path}: column 'time' does not run forward (median step {step:g} s); give fps in a recipe")
    odd = np.flatnonzero(~(np.abs(steps - step) <= _IRREGULAR * step))
    if len(odd):
        raise InputError(
            f"{path}, line {lines[odd[0] + 1]} (frame {odd[0] + 1}): {steps[odd[0]]:.4g} s after the frame ahead, "
            f"where {step:.4g} s are usual: frames are missing; keep them as lines with empty cells"
        )
    return FrameRate.of(round((len(times) - 1) / (times[-1] - times[0]), 3))


READER = Reader(
    "tracks",
    "CSV or NPZ files of marker positions with a sound file of the same name",
    lambda source: any(_is_track(path) for path in listed(source)),
    _find,
    _read,
)
