"""The GRID corpus: tracked landmarks (``markers.npz`` beside ``meta.json``), or its video, with ``.align`` files.

``markers.npz``: for each name an array (frames, landmarks, 3) of whole numbers, pixels times ``position_scale``,
-32768 where the face was lost. A tracker's own weights (``arkit.npz``) are not read: they follow the mouth less well
than what is captured from its landmarks (`mien.corpus.capturing`).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from mien.capture.layouts import load_layout
from mien.capture.tracker import tracker_python
from mien.core.border import reading
from mien.core.errors import InputError
from mien.core.limits import load_arrays
from mien.core.plain_text import parsed_json
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import SOUND, TRANSCRIPTS, Beside, found_by_suffix, listed
from mien.corpus.readers.video_recordings import read_video
from mien.corpus.recipes import Recipe
from mien.formats.sound_files import read_audio

__all__ = ["READER"]

_SENTENCE = re.compile(r"[bpls][bgrw][abiw][a-z][1-9z][anps]")
_LOST = -32768
_VIDEO = (".mpg", ".mpeg")


def _arrays(source: Path) -> Path | None:
    folder = source if source.is_dir() else source.parent
    path = folder / "markers.npz"
    return path if path.is_file() and (folder / "meta.json").is_file() else None


def _recognises(source: Path) -> bool:
    if source.is_dir() and _arrays(source):
        return True
    return any(path.suffix.lower() in _VIDEO and _SENTENCE.fullmatch(path.stem) for path in listed(source))


def _find(source: Path) -> list[Found]:
    arrays = _arrays(source)
    if source.suffix.lower() in _VIDEO or arrays is None:
        tracker_python()
        return found_by_suffix(source, _VIDEO)
    beside = Beside(arrays.parent)
    names = sorted(_names(arrays))
    here = [(name, arrays.parent / name) for name in names]
    # Path(name + ".x"): the files that share the name of an array, wherever they lie
    return [
        Found(
            name,
            arrays,
            beside.near(place.with_name(f"{name}.npz"), SOUND),
            beside.near(place.with_name(f"{name}.npz"), TRANSCRIPTS),
        )
        for name, place in here
    ]


def _read(found: Found, recipe: Recipe) -> Raw:
    return read_video(found, recipe) if found.motion.suffix.lower() in _VIDEO else _read_arrays(found, recipe)


def _read_arrays(found: Found, recipe: Recipe) -> Raw:
    path, layout = found.motion, load_layout(recipe.layout)
    about = _about(path.parent / "meta.json")
    try:
        names = [layout.landmarks[int(number)] for number in about["landmark_ids"]]
        scale, rate = float(about["position_scale"]), FrameRate.of(about["fps"])
    except (KeyError, TypeError, ValueError) as problem:
        raise InputError(
            f"{path.parent / 'meta.json'}: landmark_ids, position_scale or fps cannot be used ({problem})"
        ) from problem
    counts = _array(path, found.name)
    if counts.shape[1:] != (len(names), 3) or not len(counts):
        raise InputError(f"{path}, {found.name}: expected shape (frames, {len(names)}, 3), got {counts.shape}")
    positions = np.where(counts == _LOST, np.nan, counts / scale)
    audio, notes = read_audio(found.sound) if found.sound else (None, ())
    return Raw(MarkerTrack(names, positions, rate), "pixels", audio, notes=notes)


def _about(path: Path) -> dict[str, Any]:
    try:
        content = parsed_json(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise InputError(f"{path}: cannot be read ({problem})") from problem
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a JSON object, got {type(content).__name__}")
    return content


def _names(path: Path) -> list[str]:
    """The takes of a file, not yet read."""
    with reading(path, "takes in NPZ"), ZipFile(path) as archive:
        return [name.removesuffix(".npy") for name in archive.namelist()]


def _array(path: Path, name: str) -> Any:
    takes = load_arrays(path, only=lambda member: member == name)
    if name not in takes:
        raise InputError(f"{path}: no array {name!r} in it")
    return takes[name]


READER = Reader("grid", "the GRID corpus (markers.npz with meta.json, or its .mpg video)", _recognises, _find, _read)
