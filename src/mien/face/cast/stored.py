"""Faces of the cast made once and kept: making one takes seconds, reading it back a fraction of one."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from functools import cache, lru_cache
from hashlib import sha256
from pathlib import Path

from mien.core.assets import assets_folder
from mien.core.errors import InputError, OutputError
from mien.core.temporary_folder import temporary_folder
from mien.face.cast.made_person import Person, person_called
from mien.face.cast.making import make_face
from mien.face.model import Face
from mien.face.storage import read_face, write_face

__all__ = ["cast_face", "face_of_person"]

_KEPT = 64  # faces
_MADE_OF = ("faces/default.npz", "fitting/default.npz", "fitting/people.npz", "render/folds.npz", "faces/looks.toml",
            "faces/cuts.toml")  # fmt: skip


def face_of_person(person: Person) -> Face:
    """A person's face as it is kept in a file, so that it is the same whether it was just made or made long ago."""
    folder = _folder(os.environ)
    path = folder / f"{_digest(person)}.npz" if folder else None
    if path is not None and path.is_file():
        with contextlib.suppress(InputError):  # damaged: made again
            return read_face(path)
    face = make_face(person)
    if path is not None:
        with contextlib.suppress(OutputError):
            write_face(face, path)
            _sweep(path.parent)
            return read_face(path)
    with temporary_folder() as own:
        write_face(face, own / "face.npz")
        return read_face(own / "face.npz")


@lru_cache(maxsize=4)
def cast_face(name: str) -> Face:
    """A face of the cast, or a blend of two (`person_called`)."""
    return face_of_person(person_called(name))


def _folder(environment: Mapping[str, str]) -> Path | None:
    """Where faces are kept; None where nothing can be written."""
    home = environment.get("XDG_CACHE_HOME") or (environment.get("HOME") and f"{environment['HOME']}/.cache")
    if not home:
        return None
    folder = Path(home) / "mien" / "faces"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        return folder if os.access(folder, os.W_OK) else None
    return None


def _digest(person: Person) -> str:
    return sha256(_ground() + repr(person).encode()).hexdigest()[:32]


@cache
def _ground() -> bytes:
    """What a face depends on besides the person: the data and the code that make it."""
    digest = sha256()
    here = Path(__file__).parent
    for path in [assets_folder() / name for name in _MADE_OF] + [
        *sorted(here.glob("*.py")),
        *sorted(here.parent.glob("*.py")),
    ]:
        digest.update(path.read_bytes())
    return digest.digest()


def _sweep(folder: Path) -> None:
    """Only the newest are kept."""
    files = sorted(folder.glob("*.npz"), key=lambda path: path.stat().st_mtime)
    for path in files[:-_KEPT]:
        path.unlink(missing_ok=True)
