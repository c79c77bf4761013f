"""Parameter trees for the deformation editor: those of the faces themselves, and those that were edited or opened."""

from __future__ import annotations

import json
from base64 import b64encode
from dataclasses import asdict, dataclass
from threading import RLock
from typing import Any

import numpy as np

from mien.core.errors import InputError
from mien.face.model import Face
from mien.face.parameter_tree import ParameterTree
from mien.face.tree_config import parse_tree, tree_text
from mien.face.tree_data import check_data, config_data, data_text, influence_data
from mien.face.tree_of_face import tree_of_face
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_faces import DEFAULT_FACE, FaceShelf

__all__ = ["Rig", "RigShelf"]

_MOST_FAULTS = 50
_DERIVED = 3


@dataclass(frozen=True, eq=False)
class Rig:
    """A tree as the editor sees it.

    Attributes
    ----------
    content : bytes
        The configuration as JSON, in the form of `mien.face.tree_data`: as text, since as objects it is large.
    text : str
        The same as a configuration file.
    tree : ParameterTree
        On its face.
    face : str
        Id of the face that it moves.
    """

    content: bytes
    text: str
    tree: ParameterTree
    face: str

    @property
    def size(self) -> int:
        """Bytes in memory, roughly."""
        return 3 * (len(self.text) + len(self.content))


class RigShelf:
    """The trees of one studio. The id of a face is that of the tree derived from its targets.

    Parameters
    ----------
    limits : Limits
    faces : FaceShelf
    """

    def __init__(self, limits: Limits, faces: FaceShelf) -> None:
        self._faces = faces
        self._kept: Kept[Rig] = Kept("rig", limits.rigs, limits.kept_bytes)
        self._derived: Kept[Rig] = Kept("rig", _DERIVED)
        self._shapes: Kept[Face] = Kept("face", _DERIVED)
        self._lock = RLock()

    def face(self, name: str) -> Face:
        """The face of an id with a target for each channel; raises `mien.serve.studio.lru_store.Missing`."""
        with self._lock:
            if name not in self._shapes:
                self._shapes.put(self._faces.shape(name), name=name)
            return self._shapes.get(name)

    def get(self, name: str) -> Rig:
        """A rig by its id, or that of a face; raises `mien.serve.studio.lru_store.Missing`."""
        if name in self._kept or not self._faces.holds(name):
            return self._kept.get(name)
        with self._lock:
            if name not in self._derived:
                tree = tree_of_face(self.face(name))
                text = tree_text(tree, f"derived from the morph targets of the face {self._faces.called(name)}")
                self._derived.put(Rig(_json(config_data(parse_tree(text))), text, tree, name), name=name)
            return self._derived.get(name)

    def face_of(self, name: str) -> str:
        """Id of the face that a rig moves; raises `mien.serve.studio.lru_store.Missing`. Quick, unlike `get`."""
        return name if name not in self._kept and self._faces.holds(name) else self._kept.get(name).face

    def check(self, config: object, face: str = DEFAULT_FACE) -> list[dict[str, Any]]:
        """Every fault of a configuration: its line in the file, its parameter, and what is wrong; at most 50."""
        if not isinstance(config, dict):
            return [{"line": None, "parameter": None, "text": "expected a configuration, an object"}]
        try:
            return [asdict(fault) for fault in check_data(config, self._vertices(face))[:_MOST_FAULTS]]
        except InputError as problem:
            return [{"line": None, "parameter": None, "text": str(problem)}]

    def save(self, name: str, config: object) -> str:
        """Keep a configuration; under the id of a face it is kept as a new one. Gives its id.

        Raises
        ------
        FieldError
            If it has a fault.
        """
        face = self.face_of(name)
        if not isinstance(config, dict):
            raise FieldError("config", "expected a configuration, an object")
        return self._kept_as(name if name in self._kept else None, _text_of(config), config, face)

    def open(self, text: str, face: str = DEFAULT_FACE) -> tuple[str, Rig]:
        """Read a configuration file, for a face.

        Raises
        ------
        FieldError
            With the lines at fault.
        """
        name = self._kept_as(None, text, None, face)
        return name, self._kept.get(name)

    def _kept_as(self, name: str | None, text: str, config: dict[str, Any] | None, face: str) -> str:
        try:
            parsed = parse_tree(text, "rig.tree")
            tree = parsed.on(self._vertices(face))
            rig = Rig(_json(config_data(parsed) if config is None else config), text, tree, face)
        except InputError as problem:
            raise FieldError("config", str(problem)) from problem
        return self._kept.put(rig, rig.size, name)

    def influence(self, name: str) -> dict[str, Any]:
        """What every parameter moves, vertex by vertex."""
        return influence_data(self.get(name).tree)

    def _vertices(self, face: str) -> dict[str, Any]:
        return {part.name: part.vertices for part in self.face(face).parts}

    def mesh(self, name: str) -> bytes:
        """A rig's face at rest as JSON: for each part its vertices (float32, mm) and triangles (uint32), base64."""

        def packed(values: Any, kind: str) -> str:
            return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")

        parts = [
            {"name": part.name, "vertices": packed(part.vertices, "<f4"), "triangles": packed(part.triangles, "<u4")}
            for part in self.face(self.face_of(name)).parts
        ]
        return json.dumps({"parts": parts}).encode()

    def posed(self, name: str, values: object) -> bytes:
        """Vertices under parameter values, part after part as `mesh` lists them: float32, little-endian, mm.

        The plain reference that a page's own posing is held against.
        """
        rig = self.get(name)
        tree = rig.tree
        names = [parameter.name for parameter in tree.parameters]
        row = np.zeros(len(names))
        if not isinstance(values, dict):
            raise FieldError("values", "expected an object: parameter and value")
        for parameter, value in values.items():
            if parameter not in names:
                raise FieldError("values", f"the tree has no parameter {str(parameter)[:40]!r}")
            if isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e6:
                raise FieldError("values", f"{parameter} is a number, not {str(value)[:20]}")
            row[names.index(parameter)] = value
        return b"".join(
            np.asarray(tree.deform(part.name, part.vertices, row), dtype="<f4").tobytes()
            for part in self.face(rig.face).parts
        )


def _json(config: dict[str, Any]) -> bytes:
    return json.dumps(config, separators=(",", ":")).encode()


def _text_of(config: dict[str, Any]) -> str:
    try:
        return data_text(config)
    except InputError as problem:
        raise FieldError("config", str(problem)) from problem
