"""Faces as GLB: the shipped one, and those that were uploaded."""

from __future__ import annotations

import contextlib
import json
import re
import shutil
from collections import defaultdict
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from mien.core.assets import asset
from mien.core.errors import InputError, OutputError
from mien.core.files import replace_when_complete
from mien.core.plain_text import parsed_json
from mien.face.library import known_faces, load_face
from mien.face.model import Face
from mien.serve.studio.light_glb import light_glb
from mien.serve.studio.lru_store import Kept, Missing, new_id
from mien.serve.studio.page_folds import folds_of_face
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits

__all__ = ["DEFAULT_FACE", "FaceShelf", "ForeignFace"]

DEFAULT_FACE = "default"
_MOST_PICTURE = 100_000  # bytes


@dataclass(frozen=True)
class ForeignFace:
    """An uploaded GLB.

    Attributes
    ----------
    path : Path
        Where it lies, under a name of the server's.
    report : dict
        What of it can be driven.
    name : str
        The name of its file.
    """

    path: Path
    report: dict[str, Any]
    name: str


class FaceShelf:
    """The faces that a studio can show; those in its folder are there again when it is opened the next time."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder = folder
        self._foreign: Kept[ForeignFace] = Kept(
            "face", limits.faces, limits.kept_bytes, lambda face: _removed(face.path)
        )
        self._own: dict[str, bytes] = {}
        self._lock, self._locks = Lock(), defaultdict[str, Lock](Lock)  # one face does not wait for another
        for about in sorted(folder.glob("*/about.json"), key=lambda path: path.stat().st_mtime):
            with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
                told = parsed_json(about.read_text("utf-8"))
                path = about.parent / "face.glb"
                size = path.stat().st_size
                self._foreign.put(ForeignFace(path, told["report"], str(told["name"])), size, about.parent.name)

    def own_glb(self, name: str) -> bytes:
        """A face of mien's at rest, every channel that it has as a morph target of that name; made once and kept."""
        kept = self._folder.parent / "shipped" / f"{name}-{version('mien')}-{_digest(name)}-light2.glb"
        with self._lock:
            lock = self._locks[name]
        with lock:
            if name in self._own:
                return self._own[name]
            try:
                content = kept.read_bytes()
            except OSError:
                content = light_glb(_resting_glb(name))
                with contextlib.suppress(OSError, OutputError):
                    kept.parent.mkdir(exist_ok=True)
                    with replace_when_complete(kept) as unfinished:
                        unfinished.write_bytes(content)
            self._own[name] = content
            return content

    def picture(self, name: str) -> bytes:
        """A small picture of a face, JPEG; raises `mien.serve.studio.lru_store.Missing`."""
        path = asset(f"faces/pictures/{name}.jpg") if name in known_faces() else self._picture(name)
        if not path.is_file():
            raise Missing("there is no picture of this face")
        return path.read_bytes()

    def keep_picture(self, name: str, content: bytes) -> None:
        """Keep the small picture, JPEG, that a page has drawn of an uploaded face."""
        if not content.startswith(b"\xff\xd8\xff") or len(content) > _MOST_PICTURE:
            raise FieldError("face", f"a picture of a face is a JPEG of at most {_MOST_PICTURE // 1000} kB")
        with replace_when_complete(self._picture(name)) as unfinished:
            unfinished.write_bytes(content)

    def _picture(self, name: str) -> Path:
        return self._foreign.get(name).path.with_name("picture.jpg")

    def listed(self) -> list[dict[str, Any]]:
        """All of them by id, with their names."""
        shipped = sorted(known_faces(), key=lambda name: (name != DEFAULT_FACE, name))
        return [
            {"face": name, "name": name, "own": False, "picture": asset(f"faces/pictures/{name}.jpg").is_file()}
            for name in shipped
        ] + [
            {"face": face.path.parent.name, "name": face.name, "own": True,
             "picture": face.path.with_name("picture.jpg").is_file(), "report": face.report}
            for face in self._foreign
        ]  # fmt: skip

    def add(self, content: bytes, name: str = "") -> tuple[str, ForeignFace]:
        """Keep an uploaded GLB.

        Raises
        ------
        FieldError
            If it is none, or has no morph target that can be driven; of ``head`` if it has no target at all, so that
            `mien.serve.studio.heads` may give it some.
        """
        field = "face"
        from mien.face.foreign.known_face import known_face

        path = self._folder / new_id() / "face.glb"
        path.parent.mkdir()  # of its own: a GLB may name files beside it, and there are none
        path.write_bytes(content)
        try:
            known = known_face(path)
            field = "face" if known.moves or any(mesh.targets for mesh in known.meshes) else "head"
            known.require_motion()
            face = ForeignFace(path, _checked_report(path), name or "a face of yours")
            about = json.dumps({"name": face.name, "report": face.report})
            with replace_when_complete(path.parent / "about.json") as unfinished:
                unfinished.write_text(about, "utf-8")
        except InputError as problem:
            _removed(path)
            raise FieldError(field, str(problem).replace(str(path), "the GLB")) from problem
        except BaseException:
            _removed(path)
            raise
        return self._foreign.put(face, len(content), path.parent.name), face

    def glb(self, name: str) -> bytes:
        """A face as GLB; raises `mien.serve.studio.lru_store.Missing`."""
        return self.own_glb(name) if name in known_faces() else self._foreign.get(name).path.read_bytes()

    def folds(self, name: str) -> dict[str, Any]:
        """The folds of a face's skin (`mien.serve.studio.page_folds`); nothing for an uploaded one."""
        return folds_of_face(name) if name in known_faces() else {}

    def holds(self, name: str) -> bool:
        """Whether there is a face of this id."""
        return name in known_faces() or name in self._foreign

    def called(self, name: str) -> str:
        """What a face is called."""
        return name if name in known_faces() else self._foreign.get(name).name

    def shape(self, name: str) -> Face:
        """A face with a target for each channel that moves it; raises `mien.serve.studio.lru_store.Missing`.

        Raises
        ------
        FieldError
            If an uploaded one cannot be laid out.
        """
        from mien.face.foreign.drawn import drawn_face
        from mien.face.foreign.known_face import known_face

        if name in known_faces():
            return load_face(name)
        path = self._foreign.get(name).path
        try:
            return _one_word_each(drawn_face(known_face(path), pictures=False).by_channels())
        except InputError as problem:
            raise FieldError("config", str(problem).replace(str(path), "the GLB")) from problem

    def to_write(self, name: object) -> Path | None:
        """The uploaded GLB of an id, to be driven; None for the shipped ones.

        Raises
        ------
        FieldError
            If there is none of this id.
        """
        if name is None or name in known_faces():
            return None
        if not isinstance(name, str) or name not in self._foreign:
            raise FieldError("face", "there is no such face (any more): open the GLB again")
        return self._foreign.get(name).path


def _one_word_each(face: Face) -> Face:
    """The same face, its parts called so that a line of a tree can name them."""
    names = {part.name: re.sub(r"[^\w.-]+", "_", part.name) for part in face.parts}
    parts = tuple(replace(part, name=names[part.name]) for part in face.parts)
    return replace(face, parts=parts, eyes=tuple(replace(eye, part=names[eye.part]) for eye in face.eyes))


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
    from mien.face.foreign.recognition import EMPTY

    report = inspect_face(path)
    meshes: list[dict[str, Any]] = []
    for mesh in report.meshes:
        driven = {target.name: target.driven_by for target in mesh.driven}
        unknown = [target.name for target in mesh.targets if not target.driven_by and target.still != EMPTY]
        meshes.append({"mesh": mesh.name, "driven": driven, "unknown": unknown, **asdict(mesh)})
    told = report.as_dict() | {"meshes": meshes, "verdict": report.verdict()}
    del told["path"]
    return told


def _digest(name: str) -> str:
    """Changes with the face."""
    face, found = load_face(name), sha256()
    for part in face.parts:
        found.update(np.ascontiguousarray(part.vertices).tobytes())
        for target in sorted(part.targets):
            found.update(target.encode())
    return found.hexdigest()[:16]


def _resting_glb(name: str) -> bytes:
    from mien.animation.animation import imported
    from mien.core import channels
    from mien.core.timeline import FrameRate
    from mien.core.tracks import ChannelTrack
    from mien.formats.gltf import GlbBuilder

    rest = ChannelTrack(channels.ALL, np.zeros((1, len(channels.ALL))), FrameRate.of(30))
    return GlbBuilder(load_face(name), "performance").build(imported(rest, "the studio"))
