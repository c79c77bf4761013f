"""Optical markers in C3D files, with the sound in an analog channel or in a sound file of the same name.

Source: the C3D user guide (c3d.org). ``POINT:UNITS`` and ``POINT:RATE`` are believed where they can be true; a point
with a negative residual, or exactly at the origin, was not seen.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import found_by_suffix, has_suffix
from mien.corpus.recipes import Recipe
from mien.formats.sound_files import read_audio

__all__ = ["READER", "SPEECH_RATE"]

SPEECH_RATE = 4000.0
"""Analog channels below this rate carry no speech."""
_SOUND_LABEL = re.compile(r"audio|sound|mic|voice|speech", re.IGNORECASE)
_UNITS = {"mm": "mm", "millimeters": "mm", "millimetres": "mm", "cm": "cm", "m": "m", "meters": "m", "metres": "m"}


def _find(source: Path) -> list[Found]:
    return found_by_suffix(source, (".c3d",))


def _read(found: Found, recipe: Recipe) -> Raw:
    path = found.motion
    content = _opened(path)
    labels = [str(label).strip() for label in _value(content, "POINT", "LABELS", [])]
    points, rate = _points(path, content, len(labels)), _rate(path, content, recipe)
    keep = [i for i, label in enumerate(labels) if label and not label.startswith("*")]
    notes = []
    if len(keep) < len(labels):
        notes.append(Note("note", f"{path.name}: {len(labels) - len(keep)} points without a name are left out"))
    names = [recipe.rename.get(labels[i], labels[i]) for i in keep]
    units = recipe.units
    if units == "auto":
        stated = [str(unit).strip().lower() for unit in _value(content, "POINT", "UNITS", [])]
        units = _UNITS.get(stated[0], "") if stated else ""
    try:
        track = MarkerTrack(names, points[:, keep], rate)
    except InputError as problem:
        raise InputError(f"{path}: {problem}") from problem
    audio, more = read_audio(found.sound) if found.sound else (_analog_sound(content), ())
    return Raw(track, units, audio, notes=(*notes, *more))


def _opened(path: Path) -> Any:
    import ezc3d

    if path.stat().st_size < 1024:
        raise InputError(f"{path}: {path.stat().st_size} bytes are too few for a C3D file: is it cut short?")
    try:
        return ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError, IndexError) as problem:
        reason = str(problem).split(". If")[0]
        raise InputError(f"{path}: cannot be read as C3D ({reason}): is it cut short, or of another kind?") from problem


def _value(content: Any, group: str, name: str, default: Any) -> Any:
    parameters = content["parameters"]
    if group not in parameters or name not in parameters[group]:
        return default
    return parameters[group][name]["value"]


def _points(path: Path, content: Any, labels: int) -> NDArray[np.float64]:
    """Positions, shape (frames, points, 3), NaN where unseen."""
    points: NDArray[np.float64] = np.asarray(content["data"]["points"], dtype=np.float64)
    promised = _promised_frames(path)
    if points.shape[1] == 0 or points.shape[2] == 0:
        raise InputError(f"{path}: holds no marker motion ({points.shape[1]} points, {points.shape[2]} frames)")
    if points.shape[2] < promised:
        raise InputError(
            f"{path}: breaks off in frame {points.shape[2]} of {promised}: the file is cut short; copy it again"
        )
    if labels != points.shape[1]:
        raise InputError(f"{path}: {points.shape[1]} points but {labels} names (POINT:LABELS): is it damaged?")
    positions = points[:3].transpose(2, 1, 0).copy()
    residuals = np.asarray(content["data"]["meta_points"]["residuals"])[0].T
    positions[(residuals < 0) | (positions == 0).all(axis=2)] = np.nan
    return positions


def _promised_frames(path: Path) -> int:
    """Frames that the header speaks of (65535 at most); the library counts only those that are there."""
    head = path.read_bytes()[: 512 * 256]
    processor = head[(head[0] - 1) * 512 + 3] if len(head) > (head[0] - 1) * 512 + 3 else 84
    first, last = struct.unpack(">HH" if processor == 86 else "<HH", head[6:10])
    return int(last - first + 1)


def _rate(path: Path, content: Any, recipe: Recipe) -> FrameRate:
    stated = _value(content, "POINT", "RATE", [0.0])
    rate = recipe.fps or (float(stated[0]) if len(stated) else 0.0)
    if not rate > 0:
        raise InputError(f"{path}: its frame rate (POINT:RATE) is {rate:g}; give fps in a recipe")
    return FrameRate.of(round(rate, 4))


def _analog_sound(content: Any) -> Audio | None:
    """The analog channel that carries sound: by its label, or the only one, if sampled fast enough."""
    stated = _value(content, "ANALOG", "RATE", [0.0])
    rate = float(stated[0]) if len(stated) else 0.0
    labels = [str(label) for label in _value(content, "ANALOG", "LABELS", [])]
    named = [i for i, label in enumerate(labels) if _SOUND_LABEL.search(label)]
    channels = named or ([0] if len(labels) == 1 else [])
    if rate < SPEECH_RATE or not channels:
        return None
    samples = np.nan_to_num(np.asarray(content["data"]["analogs"], dtype=np.float64)[0, channels[0]])
    peak = float(np.abs(samples).max(initial=0.0))
    return Audio(samples / peak * 0.9 if peak > 1.0 else samples, round(rate))  # volts of any range


READER = Reader(
    "c3d",
    "C3D files (markers, with an analog sound channel or a sound file of the same name)",
    lambda source: has_suffix(source, (".c3d",)),
    _find,
    _read,
)
