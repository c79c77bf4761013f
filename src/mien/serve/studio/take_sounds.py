"""Uploaded sound: measured before it is decoded whole, and decoded in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from mien.core.audio import Audio
from mien.core.errors import Note
from mien.serve.studio.lru_store import new_id
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits

__all__ = ["read_sound"]

_PATIENCE = 60.0  # seconds that decoding may take


def read_sound(content: bytes, folder: Path, limits: Limits) -> tuple[Audio, tuple[Note, ...]]:
    """Read an uploaded sound.

    Parameters
    ----------
    content : bytes
        A file of any kind that `mien.formats.sound_files.read_audio` reads.
    folder : Path
        Where it lies while it is read.

    Raises
    ------
    FieldError
        If it cannot be read, or is too long.
    """
    if not content:
        raise FieldError("sound", "the file is empty")
    path, out = folder / f"{new_id()}.sound", folder / f"{new_id()}.npy"
    path.write_bytes(content)
    try:
        told = _decoded(path, limits.seconds, out)
        if "error" in told:
            raise FieldError("sound", str(told["error"]).replace(str(path), "the sound"))
        audio = Audio(np.load(out, allow_pickle=False), int(str(told["rate"])))
    finally:
        path.unlink(missing_ok=True)
        out.unlink(missing_ok=True)
    notes = told["notes"]
    assert isinstance(notes, list)
    return audio, tuple(Note(kind, message.replace(path.name, "the sound")) for kind, message in notes)


def _decoded(path: Path, most: float, out: Path) -> dict[str, object]:
    command = [sys.executable, "-m", "mien.serve.studio.sound_worker", str(path), str(most), str(out)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_PATIENCE, check=False)
        told = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise FieldError("sound", f"the sound could not be decoded within {_PATIENCE:.0f} s") from None
    except ValueError as problem:  # the decoder has crashed
        raise FieldError("sound", "the sound cannot be decoded: the file is damaged") from problem
    return dict(told)
