"""Optical markers in C3D files, with the sound in an analog channel or in a sound file of the same name.

Source: the C3D user guide (c3d.org). ``POINT:UNITS`` and ``POINT:RATE`` are believed where they can be true; a point
with a negative residual, or exactly at the origin, was not seen.
"""

from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.limits import load_arrays
from mien.core.temporary_folder import temporary_folder
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers import c3d_worker
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import found_by_suffix, has_suffix
from mien.corpus.recipes import Recipe
from mien.formats.sound_files import read_audio

__all__ = ["READER", "SPEECH_RATE"]

SPEECH_RATE = 4000.0
"""Analog channels below this rate carry no speech."""
_SOUND_LABEL = re.compile(r"audio|sound|mic|voice|speech", re.IGNORECASE)
_COMPUTED = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
"""Lists of points that are no places: Vicon keeps what it computes among the markers."""
_UNNAMED = re.compile(r"(.*:)?(|\*.*|u_\d+|un(labell?ed|assigned|ame)[ _*]*\d*)", re.IGNORECASE)
"""Points that nobody named: Vicon's ``*12``, ``U_12``, Qualisys' ``uname*12``, Motive's ``Unlabeled 12``."""
_MIPS = 86
_UNITS = {"mm": "mm", "millimeters": "mm", "millimetres": "mm", "cm": "cm", "m": "m", "meters": "m", "metres": "m"}


def _find(source: Path) -> list[Found]:
    return found_by_suffix(source, (".c3d",))


def _read(found: Found, recipe: Recipe) -> Raw:
    path = found.motion
    content = _opened(path)
    labels = [str(label).strip() for label in content.value("POINT:LABELS", [])]
    points, rate = _points(path, content, len(labels)), _rate(path, content, recipe)
    computed = {str(label).strip() for kind in _COMPUTED for label in content.value(f"POINT:{kind}", [])}
    keep = [i for i, label in enumerate(labels) if not _UNNAMED.fullmatch(label) and label not in computed]
    notes = []
    figures = sum(label in computed and not _UNNAMED.fullmatch(label) for label in labels)
    if figures:
        notes.append(Note("note", f"{path.name}: {figures} angles, forces and the like are left out"))
    if unnamed := len(labels) - len(keep) - figures:
        notes.append(Note("note", f"{path.name}: {unnamed} points without a name are left out"))
    bare = _without_subject([labels[i] for i in keep])
    if bare and bare[0] != labels[keep[0]]:
        notes.append(Note("note", f"{path.name}: the names of its points begin with a subject's: left out"))
    names = [recipe.rename.get(labels[i], recipe.rename.get(name, name)) for i, name in zip(keep, bare, strict=True)]
    units = recipe.units
    if units == "auto":
        stated = [str(unit).strip().lower() for unit in content.value("POINT:UNITS", [])]
        units = _UNITS.get(stated[0], "") if stated else ""
    try:
        track = MarkerTrack(names, points[:, keep], rate)
    except InputError as problem:
        raise InputError(f"{path}: {problem}") from problem
    audio, more = read_audio(found.sound) if found.sound else (_analog_sound(content), ())
    return Raw(track, units, audio, notes=(*notes, *more))


def _without_subject(labels: list[str]) -> list[str]:
    """Names without what all of them begin with up to a colon, as Vicon writes subjects; several subjects stay apart.

    Examples
    --------
    >>> _without_subject(["Anna:LBRO", "Anna:RBRO"]), _without_subject(["Anna:LBRO", "Ben:LBRO"])
    (['LBRO', 'RBRO'], ['Anna:LBRO', 'Ben:LBRO'])
    """
    heads = {label.rpartition(":")[0] for label in labels}
    bare = [label.rpartition(":")[2] for label in labels]
    whole = len(heads) == 1 and all(bare) and len(set(bare)) == len(bare)
    return bare if whole else labels


@dataclass(frozen=True)
class _Content:
    """What a C3D file holds: arrays as the library gives them, and parameters by ``GROUP:NAME``."""

    points: NDArray[np.float64]
    residuals: NDArray[np.float64]
    analogs: NDArray[np.float64]
    facts: dict[str, list[Any]]

    def value(self, name: str, default: list[Any]) -> list[Any]:
        """A parameter."""
        return self.facts.get(name, default)


def _opened(path: Path) -> _Content:
    """Read by the library, in a process of its own."""
    if path.stat().st_size < 1024:
        raise InputError(f"{path}: {path.stat().st_size} bytes are too few for a C3D file: is it cut short?")
    if _processor(path.read_bytes()[: 512 * 256]) == _MIPS:
        raise InputError(f"{path}: its numbers are in the order of MIPS (SGI) computers: save it in that of Intel's")
    with temporary_folder() as folder:
        out = folder / "c3d.npz"
        command = [sys.executable, str(Path(c3d_worker.__file__)), str(path), str(out)]
        done = subprocess.run(command, capture_output=True, check=False)
        if done.returncode or not out.exists():
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            reason = "it ends the program that reads it" if done.returncode < 0 else lines[-1][:200] if lines else ""
            raise InputError(f"{path}: cannot be read as C3D ({reason}): is it cut short, or of another kind?")
        arrays = load_arrays(out, path)
    facts = json.loads(arrays["facts"].tobytes())
    return _Content(arrays["points"], arrays["residuals"], arrays["analogs"], facts)


def _points(path: Path, content: _Content, labels: int) -> NDArray[np.float64]:
    """Positions, shape (frames, points, 3), NaN where unseen."""
    points: NDArray[np.float64] = content.points
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
    residuals = content.residuals[0].T
    positions[(residuals < 0) | (positions == 0).all(axis=2)] = np.nan
    return positions


def _promised_frames(path: Path) -> int:
    """Frames that the header speaks of (65535 at most); the library counts only those that are there."""
    with path.open("rb") as file:
        first, last = struct.unpack("<HH", file.read(10)[6:])
    return int(last - first + 1)


def _processor(head: bytes) -> int:
    """What kind of computer the numbers are for: 84 Intel's, 85 DEC's, 86 MIPS."""
    place = (head[0] - 1) * 512 + 3
    return head[place] if 0 <= place < len(head) else 84


def _rate(path: Path, content: _Content, recipe: Recipe) -> FrameRate:
    stated = content.value("POINT:RATE", [0.0])
    rate = recipe.fps or (float(stated[0]) if len(stated) else 0.0)
    if not rate > 0:
        raise InputError(f"{path}: its frame rate (POINT:RATE) is {rate:g}; give fps in a recipe")
    return FrameRate.of(round(rate, 4))


def _analog_sound(content: _Content) -> Audio | None:
    """The analog channel that carries sound: by its label, or the only one, if sampled fast enough."""
    stated = content.value("ANALOG:RATE", [0.0])
    rate = float(stated[0]) if len(stated) else 0.0
    labels = [str(label) for label in content.value("ANALOG:LABELS", [])]
    named = [i for i, label in enumerate(labels) if _SOUND_LABEL.search(label)]
    channels = named or ([0] if len(labels) == 1 else [])
    if rate < SPEECH_RATE or not channels:
        return None
    samples = np.nan_to_num(content.analogs[0, channels[0]])
    peak = float(np.abs(samples).max(initial=0.0))
    return Audio(samples / peak * 0.9 if peak > 1.0 else samples, round(rate))  # volts of any range


READER = Reader(
    "c3d",
    "C3D files (markers, with an analog sound channel or a sound file of the same name)",
    lambda source: has_suffix(source, (".c3d",)),
    _find,
    _read,
)
