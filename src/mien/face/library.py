"""The faces that come with mien, and faces in files of your own."""

from __future__ import annotations

from pathlib import Path
from typing import TypeGuard

from mien.core.assets import assets_in
from mien.core.errors import InputError, unknown_name
from mien.face.default_face import default_face
from mien.face.model import Face
from mien.face.obj import face_of_mesh, read_obj
from mien.face.storage import read_face

__all__ = ["check_face", "is_named_face", "known_faces", "load_face", "portrait"]


_MESHES = (".npz", ".obj", ".glb", ".vrm", ".gltf", ".fbx")
_BARE = (".ply", ".stl", ".usd", ".usda", ".usdc", ".usdz")  # without shapes


def known_faces() -> tuple[str, ...]:
    """Names of the faces that come with mien: the default one, and the cast.

    Examples
    --------
    >>> "default" in known_faces()
    True
    """
    from mien.face.cast.made_person import cast_names

    return ("default", *cast_names())


def is_named_face(name: object) -> TypeGuard[str]:
    """Whether this names a face that comes with mien, or a blend of two (``amara+mei:0.3``), not a file.

    Examples
    --------
    >>> is_named_face("amara"), is_named_face("my-face.npz"), is_named_face("amara+mei:0.3")
    (True, False, True)
    """
    if name == "default":
        return True  # the usual one asks nothing of the cast
    from mien.face.cast.made_person import is_blend

    return isinstance(name, str) and (name in known_faces() or is_blend(name))


def check_face(name: str) -> None:
    """Refuse what names no face, without reading or making one.

    Raises
    ------
    InputError
        If it is neither a name (`is_named_face`) nor a file, or a blend whose share is no number from 0 to 1.

    Examples
    --------
    >>> check_face("amara+mei:0.5")
    """
    from mien.face.cast.made_person import is_blend, person_called

    if is_blend(name):
        person_called(name)
    elif not is_named_face(name) and (not Path(name).is_file() or Path(name).suffix.lower() not in _MESHES + _BARE):
        raise _no_face(name)


def portrait(name: str) -> Path | None:
    """A small picture of a face that comes with mien, 160 by 200 pixels, ``.jpg``; None for a face that has none.

    Examples
    --------
    >>> portrait("amara").suffix
    '.jpg'
    """
    return assets_in("faces/portraits", ".jpg").get(name)


def load_face(name: str | Path = "default") -> Face:
    """Read a face by its name, or from a face file.

    Parameters
    ----------
    name : str or Path
        One of `known_faces`, or two of the cast and the share of the second (``amara+mei:0.3``); the path of a
        ``.npz`` file that `mien.face.storage.write_face` wrote, or of an ``.obj`` file: that one has no morph targets
        and is moved by a parameter tree (`mien.face.deformers.deformed_by`); or of a face of another maker (``.glb``,
        ``.vrm``, ``.gltf``), laid out in mm with targets named by channels.

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
    kind = Path(name).suffix.lower()
    if kind in (".glb", ".vrm", ".gltf", ".fbx"):
        from mien.face.foreign.known_face import face_by_channels

        return face_by_channels(name)
    if kind in _BARE:
        raise InputError(f"{name} is a bare mesh, without shapes: 'mien face fit {name} -o FACE.npz' gives it some")
    if isinstance(name, Path) or str(name).endswith(".npz"):
        return read_face(name)
    if name == "default":
        return default_face()
    if not is_named_face(name):
        raise _no_face(name)
    from mien.face.cast.stored import cast_face

    return cast_face(name)


def _no_face(name: str) -> InputError:
    kind = Path(name).suffix.lower()
    if not kind or "/" in kind:
        return unknown_name("face", name, known_faces())
    if kind in _MESHES + _BARE:
        return InputError(f"there is no face file {name}")
    return InputError(
        f"{name} is no face: that is a name from 'mien faces' or a file of a mesh ({' '.join(_MESHES)}), not a {kind}"
    )
