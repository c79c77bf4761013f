"""``.glb``: the face and its performance as binary glTF 2.0.

::

    mien                    the scene's root, metres, y up, the face looks along +z
    ├── trunk               joint: what stays when the head turns
    │   └── head            joint at the head's pivot; its rotation is animated
    │       ├── eye_left    the eyeball about its own centre; its rotation is animated
    │       └── eye_right
    ├── face                skinned mesh of trunk and head: skin, teeth, lashes, brows; 52 ARKit morph targets, then
    │                       those of `mien.core.channels.MUSCLES` that the face has
    └── tongue              skinned mesh: the 52 targets, then those of `mien.core.channels.TONGUE`

Morph targets carry the names of `mien.core.channels` in ``mesh.extras.targetNames``. Targets are sparse accessors;
every channel has one, an empty one costs no bytes. One ``weights`` track per mesh drives them, one key per frame,
linear between. Normals of the targets come from `mien.face.posing`, so creases shade as in mien's own pictures.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.channels import ARKIT, HEAD, MUSCLES, TONGUE
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.tracks import ChannelTrack
from mien.face.model import Eye, Face, Material, Part
from mien.face.posing import eye_rotation, head_rotation
from mien.formats.face_motion import TargetNormals, linear_light, lost_tree, playing_facts, quaternions
from mien.formats.gltf_buffer import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfBuffer, pack_glb

__all__ = ["METRES", "GlbBuilder", "write_glb"]

METRES = 1e-3
_JPEG_QUALITY = 92
_LOOKS = ("Up", "Down", "In", "Out")

Floats = NDArray[np.float32]


def write_glb(
    animation: Animation,
    face: Face,
    path: str | Path,
    *,
    compact: bool = False,
    meshopt: bool = False,
    clip: str = "performance",
) -> tuple[Note, ...]:
    """Write a face that performs an animation as a GLB file.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
    compact : bool
        ARKit's 52 targets alone, whole numbers instead of decimals, smaller pictures (`mien.formats.compact_glb`).
    meshopt : bool
        Compact, and compressed besides, for players that know ``EXT_meshopt_compression``.
    clip : str
        Name of the animation.

    Raises
    ------
    InputError
        If the animation has no frames.
    OutputError
        If the file cannot be written.
    """
    if len(animation.channels) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    from mien.formats.compact_glb import CompactBuilder
    from mien.formats.livelink import arkit_weights, beyond_arkit

    notes: tuple[Note, ...] = ()
    builder = GlbBuilder(face, clip)
    if compact or meshopt:
        builder, track = CompactBuilder(face, clip, meshopt), animation.channels
        notes = beyond_arkit(track, Path(path).name)
        values = np.hstack([arkit_weights(track), track.select(HEAD).values])
        animation = replace(animation, channels=ChannelTrack(ARKIT + HEAD, values, track.rate))
    content = builder.build(animation)
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)
    return (*notes, *lost_tree(animation, face, "a GLB"))


class GlbBuilder:
    """Assembles the document; every ``_add_...`` appends to it and returns the number of what it appended."""

    extensions: tuple[str, ...] = ()
    """Which a reader has to know."""

    def __init__(self, face: Face, clip: str = "performance") -> None:
        self.face, self.clip = face, clip
        self.buffer = GltfBuffer()
        self.materials: list[dict[str, Any]] = []
        self.textures: list[dict[str, Any]] = []
        self.images: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.nodes: list[dict[str, Any]] = []
        self._material_numbers: dict[int, int] = {}
        self._texture_numbers: dict[bytes, int] = {}
        self._normals = TargetNormals(face)

    def build(self, animation: Animation) -> bytes:
        """The whole file."""
        eyes = [(eye, self._add_eye(eye)) for eye in self.face.eyes]
        head = self._add_node(name="head", translation=_metres(self.face.head_pivot))
        if eyes:
            self.nodes[head]["children"] = [node for _, node in eyes]
        trunk = self._add_node(name="trunk", children=[head])
        root = self._add_node(name="mien", children=[trunk])
        meshes = self._add_skinned_meshes()
        self.nodes[root]["children"] += [node for node, _ in meshes]
        skin = self._skin(trunk, head)
        motion = self._animation(animation, head, eyes, meshes)
        extras = {"mien": playing_facts(animation)}
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"mien {animation.provenance.version}", "extras": extras},
            "scene": 0,
            "scenes": [{"name": self.face.name, "nodes": [root]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "skins": [skin],
            "animations": [motion | {"extras": extras}],
            "materials": self.materials,
            "accessors": self.buffer.accessors,
            "bufferViews": self.buffer.views,
            "buffers": self.buffer.buffers,
        }
        if self.extensions:
            document |= {"extensionsUsed": list(self.extensions), "extensionsRequired": list(self.extensions)}
        if self.images:
            document |= {"images": self.images, "textures": self.textures, "samplers": [{}]}
        if self.face.licence:
            document["asset"]["copyright"] = self.face.licence
        return pack_glb(document, self.buffer.data)

    # ------------------------------------------------------------ nodes and meshes

    def _add_node(self, **facts: Any) -> int:
        self.nodes.append(facts)
        return len(self.nodes) - 1

    def _add_eye(self, eye: Eye) -> int:
        part = self.face.part(eye.part)
        centre = np.array(eye.centre, dtype=np.float32)
        primitive = self._primitive(part, part.vertices - centre)
        self.meshes.append({"name": part.name, "primitives": [primitive]})
        from_pivot = np.subtract(eye.centre, self.face.head_pivot)
        name = f"eye_{eye.side.lower()}"
        if any(node["name"] == name for node in self.nodes):  # a second part on the same side, such as a cornea
            name = f"{name}_{part.name}"
        return self._add_node(name=name, mesh=len(self.meshes) - 1, translation=_metres(from_pivot))

    def _add_skinned_meshes(self) -> list[tuple[int, tuple[str, ...]]]:
        """The meshes that both joints carry, as (node, names of their targets)."""
        eyeballs = {eye.part for eye in self.face.eyes}
        parts = [part for part in self.face.parts if part.name not in eyeballs]
        tongue = [part for part in parts if set(part.targets) & set(TONGUE)]
        rest = [part for part in parts if part not in tongue]
        muscles = tuple(name for name in MUSCLES if any(name in part.targets for part in rest))
        meshes = []
        for name, group, extra in (("face", rest, muscles), ("tongue", tongue, TONGUE)):
            targets = self._targets(group, extra)
            if group:
                primitives = [self._skinned_primitive(part, targets) for part in group]
                mesh = {"name": name, "primitives": primitives, "weights": [0.0] * len(targets)}
                self.meshes.append(mesh | {"extras": {"targetNames": list(targets)}})
                meshes.append((self._add_node(name=name, mesh=len(self.meshes) - 1, skin=0), targets))
        return meshes

    def _targets(self, parts: Sequence[Part], extra: tuple[str, ...]) -> tuple[str, ...]:
        """Names of the targets of a mesh of these parts."""
        return ARKIT + extra

    def _skin(self, trunk: int, head: int) -> dict[str, Any]:
        inverse = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
        inverse[1, 3, :3] = -np.array(_metres(self.face.head_pivot), dtype=np.float32)  # column-major
        accessor = self.buffer.add(self._inverse(inverse).reshape(2, 16))
        return {"name": "neck", "joints": [trunk, head], "skeleton": trunk, "inverseBindMatrices": accessor}

    def _inverse(self, inverse: Floats) -> Floats:
        """Inverse bind matrices, (joints, 4, 4) column-major, for the units that places are written in."""
        return inverse

    def _primitive(self, part: Part, vertices: Floats) -> dict[str, Any]:
        index = part.triangles.reshape(-1).astype(np.uint16 if len(vertices) <= 65_535 else np.uint32)
        attributes = {
            "POSITION": self.buffer.add((vertices * METRES).astype(np.float32), ARRAY_BUFFER, bounds=True),
            "NORMAL": self.buffer.add(self._normals.at_rest(part), ARRAY_BUFFER),
        }
        if part.material.texture is not None:
            attributes["TEXCOORD_0"] = self.buffer.add(part.uv.astype(np.float32), ARRAY_BUFFER)
        if not np.all(part.colours == 1.0):
            linear = np.hstack([linear_light(part.colours), np.ones((len(part.colours), 1))])
            colours = np.round(linear * 65_535).astype(np.uint16)
            attributes["COLOR_0"] = self.buffer.add(colours, ARRAY_BUFFER, normalized=True)
        return {
            "attributes": attributes,
            "indices": self.buffer.add(index, ELEMENT_ARRAY_BUFFER),
            "material": self._material(part.material),
        }

    def _skinned_primitive(self, part: Part, targets: Sequence[str]) -> dict[str, Any]:
        primitive = self._primitive(part, part.vertices)
        weight = np.clip(part.head_weight, 0.0, 1.0).astype(np.float32)
        joints, weights = np.zeros((len(weight), 4), np.uint8), np.zeros((len(weight), 4), np.float32)
        whole = weight == 1.0  # a joint that carries nothing is not named
        joints[:, 0], weights[:, 0] = whole, np.where(whole, 1.0, 1.0 - weight)
        joints[:, 1], weights[:, 1] = (weight > 0) & ~whole, np.where(whole, 0.0, weight)
        attributes = primitive["attributes"]
        attributes["JOINTS_0"], attributes["WEIGHTS_0"] = self._joints(joints, weights)
        primitive["targets"] = [self._target(part, name) for name in targets]
        return primitive

    def _joints(self, joints: NDArray[np.uint8], weights: Floats) -> tuple[int, int]:
        return self.buffer.add(joints, ARRAY_BUFFER), self.buffer.add(weights, ARRAY_BUFFER)

    def _target(self, part: Part, name: str) -> dict[str, int]:
        offsets = np.zeros_like(part.vertices, dtype=np.float32)
        normals = np.zeros_like(offsets)
        if name in part.targets:
            target = part.targets[name]
            np.add.at(offsets, target.vertices, (target.offsets * METRES).astype(np.float32))
            normals = self._normals.change(part, name)
        return {"POSITION": self.buffer.add_sparse(offsets), "NORMAL": self.buffer.add_sparse(normals)}

    # ------------------------------------------------------------ materials

    def _material(self, material: Material) -> int:
        if id(material) not in self._material_numbers:
            surface: dict[str, Any] = {
                "baseColorFactor": [*linear_light(np.array(material.colour)).tolist(), float(material.opacity)],
                "metallicFactor": 0.0,
                "roughnessFactor": float(material.roughness),
            }
            if material.texture is not None:
                surface["baseColorTexture"] = {"index": self._add_texture(material.name, material.texture)}
            facts: dict[str, Any] = {"name": material.name, "pbrMetallicRoughness": surface, "doubleSided": True}
            if material.texture is not None and material.texture.shape[2] == 4:
                facts |= {"alphaMode": "MASK", "alphaCutoff": 0.5}
            if material.opacity < 1:
                facts["alphaMode"] = "BLEND"
            self.materials.append(facts)
            self._material_numbers[id(material)] = len(self.materials) - 1
        return self._material_numbers[id(material)]

    def _add_texture(self, name: str, texture: NDArray[np.uint8]) -> int:
        from PIL import Image

        image, kind = Image.fromarray(np.ascontiguousarray(texture)), "PNG" if texture.shape[2] == 4 else "JPEG"
        picture = self._encoded(image, kind)
        if picture in self._texture_numbers:  # both eyes show one picture
            return self._texture_numbers[picture]
        view = self.buffer.add_bytes(picture)
        self.images.append({"name": name, "mimeType": f"image/{kind.lower()}", "bufferView": view})
        self.textures.append({"sampler": 0, "source": len(self.images) - 1})
        self._texture_numbers[picture] = len(self.textures) - 1
        return len(self.textures) - 1

    def _encoded(self, image: Any, kind: str) -> bytes:
        stream = io.BytesIO()
        image.save(stream, kind, quality=_JPEG_QUALITY, subsampling=0)
        return stream.getvalue()

    # ------------------------------------------------------------ motion

    def _animation(
        self,
        animation: Animation,
        head: int,
        eyes: Sequence[tuple[Eye, int]],
        meshes: Sequence[tuple[int, tuple[str, ...]]],
    ) -> dict[str, Any]:
        track = animation.channels
        times = self.buffer.add(track.rate.times(len(track)).astype(np.float32), bounds=True)
        tracks: list[tuple[int, str, NDArray[Any]]] = [
            (node, "weights", track.select(targets).values.reshape(-1)) for node, targets in meshes
        ]
        turns = [head_rotation(*angles) for angles in track.select(HEAD).values]
        tracks.append((head, "rotation", quaternions(turns)))
        for eye, node in eyes:
            looks = track.select([f"eyeLook{way}{eye.side}" for way in _LOOKS]).values
            tracks.append((node, "rotation", quaternions([eye_rotation(eye, *row) for row in looks])))
        samplers: list[dict[str, Any]] = []
        channels: list[dict[str, Any]] = []
        for node, path, values in tracks:
            output = self._output(path, values)
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
            samplers.append({"input": times, "interpolation": "LINEAR", "output": output})
        return {"name": self.clip, "channels": channels, "samplers": samplers}

    def _output(self, path: str, values: NDArray[Any]) -> int:
        """Keys of weights or rotations."""
        return self.buffer.add(values.astype(np.float32))


def _metres(point: Sequence[float] | NDArray[Any]) -> list[float]:
    return [float(number) * METRES for number in point]
