"""A GLB of about a quarter of the size, for the web and for games.

Whole numbers instead of decimals (``KHR_mesh_quantization``, which three.js, Babylon, Godot, Unity's and Blender's
importers know): places in steps of `_STEP`, normals in 1/127, weights of joints in 1/255, keys in 1/65535. Skin, eyes
and teeth have fewer triangles (`mien.formats.reduced_meshes`), with the normals of the whole mesh. ARKit's 52 targets
without mien's further ones, movements below `_LEAST_MOVE` left out, pictures of at most 1024 pixels a side.
``EXT_meshopt_compression`` (not in Blender) makes half of that.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ARKIT, TONGUE
from mien.core.errors import MissingPartError
from mien.face.model import Eye, Face, Part
from mien.face.subset import subset
from mien.formats.face_motion import linear_light
from mien.formats.gltf import METRES, GlbBuilder
from mien.formats.gltf_buffer import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, MeshoptBuffer
from mien.formats.reduced_meshes import reduced_face

__all__ = ["CompactBuilder", "check_meshopt"]

_LEAST_MOVE = 0.1
"""Millimetres at weight 1 below which a vertex is not moved: a third of a pixel of a face that fills a screen."""
_STEP = 0.05
"""Millimetres between neighbouring places: one byte holds a motion of up to 6.3 mm, as most targets have."""
_FIBRES = ("hair", "brows", "lashes")
"""Materials too fine for a motion to show in their light."""
_SIDE, _QUALITY = 1024, 85

Floats = NDArray[np.float32]


class CompactBuilder(GlbBuilder):
    """As `GlbBuilder`, in whole numbers."""

    extensions: tuple[str, ...] = ("KHR_mesh_quantization",)

    def __init__(self, face: Face, clip: str = "performance", meshopt: bool = False) -> None:
        super().__init__(face, clip)
        self.face, self._numbers = reduced_face(face)
        self._packed = meshopt
        if meshopt:
            check_meshopt()
            self.extensions, self.buffer = (*self.extensions, "EXT_meshopt_compression"), MeshoptBuffer()
            used = {part.name: _as_used(part) for part in self.face.parts}
            self.face = replace(self.face, parts=tuple(subset(part, *used[part.name]) for part in self.face.parts))
            self._numbers = {name: old[used[name][0]] for name, old in self._numbers.items()}
        reach = max(float(np.abs(part.vertices).max(initial=0.0)) for part in face.parts)
        moves = [np.abs(t.offsets).max(initial=0.0) for part in face.parts for t in part.targets.values()]
        self.step = max(_STEP, max(reach, float(max(moves, default=0.0))) / 32_767)  # mm

    def _targets(self, parts: Sequence[Part], extra: tuple[str, ...]) -> tuple[str, ...]:
        if extra != TONGUE:
            return ARKIT
        return tuple(name for name in ARKIT if any(name in part.targets for part in parts))

    def _primitive(self, part: Part, vertices: Floats) -> dict[str, Any]:
        index = part.triangles.reshape(-1).astype(np.uint16 if len(vertices) <= 65_535 else np.uint32)
        add = self.buffer.add
        attributes = {
            "POSITION": add(np.rint(vertices / self.step).astype(np.int16), ARRAY_BUFFER, bounds=True),
            "NORMAL": add(_signed(self._at_rest(part), np.int8), ARRAY_BUFFER, normalized=True),
        }
        if part.material.texture is not None:
            inside = part.uv.min() >= 0 and part.uv.max() <= 1
            places = np.rint(part.uv * 65_535).astype(np.uint16) if inside else part.uv.astype(np.float32)
            attributes["TEXCOORD_0"] = add(places, ARRAY_BUFFER, normalized=bool(inside))
        if not np.all(part.colours == 1.0):
            colours = np.rint(255 * linear_light(part.colours)).astype(np.uint8)
            attributes["COLOR_0"] = add(colours, ARRAY_BUFFER, normalized=True)
        return {
            "attributes": attributes,
            "indices": add(index, ELEMENT_ARRAY_BUFFER),
            "material": self._material(part.material),
        }

    def _at_rest(self, part: Part) -> Floats:
        return self._normals.at_rest(part)[self._numbers[part.name]]

    def _joints(self, joints: NDArray[np.uint8], weights: Floats) -> tuple[int, int]:
        whole = np.rint(255 * weights).astype(np.uint8)
        whole[:, 0] = 255 - whole[:, 1:].sum(axis=1)
        if self._packed or (joints != joints[0]).any() or (whole != whole[0]).any():
            return self.buffer.add(joints, ARRAY_BUFFER), self.buffer.add(whole, ARRAY_BUFFER, normalized=True)
        longest = max(len(part.vertices) for part in self.face.parts)  # one view serves all that move as one
        return (
            self.buffer.add_constant(joints[0], len(joints), longest),
            self.buffer.add_constant(whole[0], len(joints), longest, normalized=True),
        )

    def _target(self, part: Part, name: str) -> dict[str, int]:
        moved = np.zeros((len(part.vertices), 3))
        if name in part.targets:
            target = part.targets[name]
            np.add.at(moved, target.vertices, target.offsets)
        rows = np.flatnonzero(np.linalg.norm(moved, axis=1) >= _LEAST_MOVE)
        whole = np.rint(moved[rows] / self.step)
        steps = np.zeros(moved.shape, np.int8 if np.abs(whole).max(initial=0) <= 127 else np.int16)
        steps[rows] = whole
        add, add_sparse = self.buffer.add, self.buffer.add_sparse
        packed = self._packed and len(rows) > 0  # its zeros cost nothing there
        places = add(steps, ARRAY_BUFFER, bounds=True) if packed else add_sparse(steps, rows=rows)
        if part.material.name in _FIBRES:
            return {"POSITION": places}
        turned = np.zeros(moved.shape, np.int8)
        if len(rows):
            turned[rows] = _signed(self._normals.change(part, name)[self._numbers[part.name]][rows], np.int8)
        if packed:
            return {"POSITION": places, "NORMAL": add(turned, ARRAY_BUFFER, normalized=True)}
        return {"POSITION": places, "NORMAL": add_sparse(turned, normalized=True, rows=rows)}

    def _inverse(self, inverse: Floats) -> Floats:
        scaled = np.array(inverse)
        scaled[:, :3, :3] *= self.step * METRES  # column-major: the steps of the mesh become metres first
        return scaled

    def _add_eye(self, eye: Eye) -> int:
        node = super()._add_eye(eye)
        self.nodes[node]["scale"] = [self.step * METRES] * 3
        return node

    def _encoded(self, image: Any, kind: str) -> bytes:
        stream = io.BytesIO()
        image.thumbnail((_SIDE, _SIDE))
        image.save(stream, kind, quality=_QUALITY, optimize=True)
        return stream.getvalue()

    def _output(self, path: str, values: NDArray[Any]) -> int:
        if path == "weights":
            return self.buffer.add(np.rint(65_535 * np.clip(values, 0, 1)).astype(np.uint16), normalized=True)
        return self.buffer.add(_signed(values, np.int16), normalized=True)


def check_meshopt() -> None:
    """Say early whether meshopt-compressed files can be written.

    Raises
    ------
    MissingPartError
        If the library is not installed.
    """
    if find_spec("meshopt") is None:
        raise MissingPartError("meshopt compression needs a library: pip install 'mien[meshopt]'")


def _as_used(part: Part) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """Vertices in the order in which triangles use them, for neighbours compress well; and those triangles."""
    import meshopt

    triangles, place, used = meshopt.reorder_mesh(part.triangles.reshape(-1).astype(np.uint32), True, False)
    return np.argsort(place, kind="stable")[:used], np.asarray(triangles).reshape(-1, 3).astype(np.int64)


def _signed(values: NDArray[Any], kind: type[np.int8] | type[np.int16]) -> NDArray[Any]:
    whole: NDArray[Any] = np.rint(np.iinfo(kind).max * np.clip(values, -1.0, 1.0)).astype(kind)
    return whole
