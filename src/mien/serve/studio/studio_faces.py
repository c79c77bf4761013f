"""Faces as GLB: the shipped one, and those that were uploaded."""

from __future__ import annotations

import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from mien.core.errors import InputError
from mien.serve.studio.lru_store import Kept, new_id
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits

__all__ = ["DEFAULT_FACE", "FaceShelf", "ForeignFace"]

DEFAULT_FACE = "default"


@dataclass(frozen=True)
class ForeignFace:
    """An uploaded GLB.

    Attributes
    ----------
    path : Path
        Where it lies, under a name of the server's.
    report : dict
        What of it can be driven.
    """

    path: Path
    report: dict[str, Any]


class FaceShelf:
    """The faces that a studio can show."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder = folder
        self._foreign: Kept[ForeignFace] = Kept(
            "face", limits.faces, limits.kept_bytes, lambda face: _removed(face.path)
        )
        self._default: bytes | None = None
        self._lock = Lock()

    def default_glb(self) -> bytes:
        """The shipped face at rest, every channel it has as a morph target of that name."""
        with self._lock:
            if self._default is None:
                self._default = _resting_glb(self._folder / f"{new_id()}.glb")
            return self._default

    def add(self, content: bytes) -> tuple[str, ForeignFace]:
        """Keep an uploaded GLB.

        Raises
        ------
        FieldError
            If it is none, or has no morph target that can be driven.
        """
        from mien.face.foreign.known_face import known_face

        path = self._folder / new_id() / "face.glb"
        path.parent.mkdir()  # of its own: a GLB may name files beside it, and there are none
        path.write_bytes(content)
        try:
            known_face(path).require_motion()
            face = ForeignFace(path, _checked_report(path))
        except InputError as problem:
            _removed(path)
            raise FieldError("face", str(problem).replace(str(path), "the GLB")) from problem
        except BaseException:
            _removed(path)
            raise
        return self._foreign.put(face, len(content)), face

    def glb(self, name: str) -> bytes:
        """A face as GLB; raises `mien.serve.studio.lru_store.Missing`."""
        return self.default_glb() if name == DEFAULT_FACE else self._foreign.get(name).path.read_bytes()

    def to_write(self, name: object) -> Path | None:
        """The uploaded GLB of an id, to be driven; None for the shipped face, which is None or ``"default"``.

        Raises
        ------
        FieldError
            If there is none of this id.
        """
        if name is None or name == DEFAULT_FACE:
            return None
        if not isinstance(name, str) or name not in self._foreign:
            raise FieldError("face", "there is no such face (any more): open the GLB again")
        return self._foreign.get(name).path


def _removed(path: Path) -> None:
    shutil.rmtree(path.parent, ignore_errors=True)


def _checked_report(path: Path) -> dict[str, Any]:
    try:
        return inspected(path)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, RecursionError) as problem:
        raise InputError(f"the GLB's nodes do not hold together ({type(problem).__name__})") from problem


def inspected(path: Path) -> dict[str, Any]:
    """What of a GLB's morph targets and nodes can be driven: by mesh, target and channel."""
    from mien.face.foreign.foreign_report import inspect_face

    report = inspect_face(path)
    meshes: list[dict[str, Any]] = []
    for mesh in report.meshes:
        driven = {target.name: target.driven_by for target in mesh.driven}
        unknown = [target.name for target in mesh.targets if not target.driven_by]
        meshes.append({"mesh": mesh.name, "driven": driven, "unknown": unknown, **asdict(mesh)})
    told = report.as_dict() | {"meshes": meshes}
    del told["path"]
    return told


def _resting_glb(path: Path) -> bytes:
    from mien.animation.animation import imported
    from mien.core import channels
    from mien.core.timeline import FrameRate
    from mien.core.tracks import ChannelTrack
    from mien.face.library import load_face
    from mien.formats.gltf import write_glb

    rest = ChannelTrack(channels.ALL, np.zeros((1, len(channels.ALL))), FrameRate.of(30))
    try:
        write_glb(imported(rest, "the studio"), load_face("default"), path)
        return path.read_bytes()
    finally:
        path.unlink(missing_ok=True)
