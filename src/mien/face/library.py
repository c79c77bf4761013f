"""The faces that come with mien, and faces in files of your own."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from mien.core.assets import asset
from mien.core.errors import unknown_name
from mien.face.model import Face
from mien.face.obj import face_of_mesh, read_obj
from mien.face.storage import read_face

__all__ = ["known_faces", "load_face"]


def _folder() -> Path:
    return asset("faces")


def known_faces() -> tuple[str, ...]:
    """Names of the faces that come with mien.

    Examples
    --------
    >>> "default" in known_faces()
    True
    """
    return tuple(sorted(path.stem for path in _folder().glob("*.npz")))


def load_face(name: str | Path = "default") -> Face:
    """Read a face by its name, or from a face file.

    Parameters
    ----------
    name : str or Path
        One of `known_faces`, the path of a ``.npz`` file that `mien.face.storage.write_face` wrote, or of an ``.obj``
        file: that one has no morph targets and is moved by a parameter tree (`mien.face.deformers.deformed_by`).

    Raises
    ------
    InputError
        If the name is not known, or if the file is missing or damaged.

    Examples
    --------
    >>> face = load_face("default")
    >>> sorted(part.name for part in face.parts if part.name.startswith("eye"))
    ['eye_left', 'eye_right']
    """
    if str(name).lower().endswith(".obj"):
        return face_of_mesh(read_obj(name), Path(name).stem)
    if isinstance(name, Path) or str(name).endswith(".npz"):
        return read_face(name)
    if name not in known_faces():
        raise unknown_name("face", str(name), known_faces())
    return _own(str(name))


@lru_cache(maxsize=1)
def _own(name: str) -> Face:
    return read_face(_folder() / f"{name}.npz")
