"""Parameter trees for the deformation editor: the shipped face's own, and those that were edited or opened."""

from __future__ import annotations

import json
from base64 import b64encode
from dataclasses import asdict, dataclass
from functools import cached_property
from threading import RLock
from typing import Any

import numpy as np

from mien.core.channels import TONGUE
from mien.core.errors import InputError
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.parameter_tree import ParameterTree
from mien.face.tree_config import parse_tree, tree_text
from mien.face.tree_data import check_data, config_data, data_text, influence_data
from mien.face.tree_of_face import tree_of_face
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits

__all__ = ["DEFAULT_RIG", "Rig", "RigShelf"]

DEFAULT_RIG = "default"
_MOST_FAULTS = 50


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
        On the default face.
    """

    content: bytes
    text: str
    tree: ParameterTree

    @property
    def size(self) -> int:
        """Bytes in memory, roughly."""
        return 3 * (len(self.text) + len(self.content))


class RigShelf:
    """The trees of one studio."""

    def __init__(self, limits: Limits) -> None:
        self._kept: Kept[Rig] = Kept("rig", limits.rigs, limits.kept_bytes)
        self._default: Rig | None = None
        self._lock = RLock()

    @cached_property
    def face(self) -> Face:
        """The face that the trees move."""
        return load_face("default")

    @cached_property
    def _vertices(self) -> dict[str, Any]:
        return {part.name: part.vertices for part in self.face.parts}

    def get(self, name: str) -> Rig:
        """A rig by its id; raises `mien.serve.studio.lru_store.Missing`."""
        if name != DEFAULT_RIG:
            return self._kept.get(name)
        with self._lock:
            if self._default is None:
                tree = tree_of_face(self.face)
                text = tree_text(tree, "derived from the morph targets of the default face")
                self._default = Rig(_json(config_data(parse_tree(text))), text, tree)
            return self._default

    def known(self, name: str) -> str:
        """The same id, if there is a rig of it; raises `mien.serve.studio.lru_store.Missing`. Quick, unlike `get`."""
        if name != DEFAULT_RIG:
            self._kept.get(name)
        return name

    def check(self, config: object) -> list[dict[str, Any]]:
        """Every fault of a configuration: its line in the file, its parameter, and what is wrong; at most 50."""
        if not isinstance(config, dict):
            return [{"line": None, "parameter": None, "text": "expected a configuration, an object"}]
        try:
            return [asdict(fault) for fault in check_data(config, self._vertices)[:_MOST_FAULTS]]
        except InputError as problem:
            return [{"line": None, "parameter": None, "text": str(problem)}]

    def save(self, name: str, config: object) -> str:
        """Keep a configuration; under ``default`` it is kept as a new one. Gives its id.

        Raises
        ------
        FieldError
            If it has a fault.
        """
        if name != DEFAULT_RIG:
            self._kept.get(name)
        if not isinstance(config, dict):
            raise FieldError("config", "expected a configuration, an object")
        return self._kept_as(None if name == DEFAULT_RIG else name, _text_of(config), config)

    def open(self, text: str) -> tuple[str, Rig]:
        """Read a configuration file.

        Raises
        ------
        FieldError
            With the lines at fault.
        """
        name = self._kept_as(None, text, None)
        return name, self._kept.get(name)

    def _kept_as(self, name: str | None, text: str, config: dict[str, Any] | None) -> str:
        try:
            parsed = parse_tree(text, "rig.tree")
            tree = parsed.on(self._vertices)
            rig = Rig(_json(config_data(parsed) if config is None else config), text, tree)
        except InputError as problem:
            raise FieldError("config", str(problem)) from problem
        return self._kept.put(rig, rig.size, name)

    def influence(self, name: str) -> dict[str, Any]:
        """What every parameter moves, vertex by vertex."""
        return influence_data(self.get(name).tree)

    @cached_property
    def mesh(self) -> bytes:
        """The face at rest as JSON: for each part its vertices (float32, mm) and triangles (uint32), base64."""

        def packed(values: Any, kind: str) -> str:
            return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")

        parts = [
            {"name": part.name, "vertices": packed(part.vertices, "<f4"), "triangles": packed(part.triangles, "<u4")}
            for part in self.face.parts
        ]
        return json.dumps({"parts": parts}).encode()

    def posed(self, name: str, values: object) -> bytes:
        """Vertices under parameter values, part after part as `parts` lists them: float32, little-endian, mm.

        The plain reference that a page's own posing is held against.
        """
        tree = self.get(name).tree
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
            np.asarray(tree.deform(part.name, part.vertices, row), dtype="<f4").tobytes() for part in self.face.parts
        )

    @cached_property
    def parts(self) -> list[dict[str, Any]]:
        """The parts of the face in order, and where each is in its GLB: mesh and number of the primitive."""
        eyeballs = {eye.part for eye in self.face.eyes}
        told, counts = list[dict[str, Any]](), dict[str, int]()
        for part in self.face.parts:
            mesh = part.name if part.name in eyeballs else ("tongue" if set(part.targets) & set(TONGUE) else "face")
            number = counts.get(mesh, 0)
            counts[mesh] = number + 1
            told.append({"name": part.name, "vertices": len(part.vertices), "mesh": mesh, "primitive": number})
        return told


def _json(config: dict[str, Any]) -> bytes:
    return json.dumps(config, separators=(",", ":")).encode()


def _text_of(config: dict[str, Any]) -> str:
    try:
        return data_text(config)
    except InputError as problem:
        raise FieldError("config", str(problem)) from problem
