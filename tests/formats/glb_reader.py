"""An independent reader of GLB files: evaluates morph targets, skin and node rotations at one key of the animation.

The file is parsed with pygltflib, the arithmetic is written from the glTF 2.0 specification.
"""

from __future__ import annotations

import numpy as np
import pygltflib
from scipy.spatial.transform import Rotation

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    def __init__(self, path) -> None:
        self.gltf = pygltflib.GLTF2().load_binary(str(path))
        self.blob = self.gltf.binary_blob()

    def array(self, number: int) -> np.ndarray:
        accessor = self.gltf.accessors[number]
        kind, width = COMPONENTS[accessor.componentType], WIDTHS[accessor.type]
        values = np.zeros((accessor.count, width), kind)
        if accessor.bufferView is not None:
            values[:] = self._raw(accessor.bufferView, kind, width)[: accessor.count]
        if accessor.sparse is not None:
            rows = self._raw(accessor.sparse.indices.bufferView, COMPONENTS[accessor.sparse.indices.componentType], 1)
            values[rows[:, 0]] = self._raw(accessor.sparse.values.bufferView, kind, width)
        return values / np.iinfo(kind).max if accessor.normalized else values

    def _raw(self, view: int, kind, width: int) -> np.ndarray:
        """Rows of a view: packed ones by meshoptimizer's own decoder; padding between rows left out."""
        place = self.gltf.bufferViews[view]
        start, packed = place.byteOffset or 0, (place.extensions or {}).get("EXT_meshopt_compression")
        stride = place.byteStride or width * np.dtype(kind).itemsize
        if packed:
            import meshopt

            content = self.blob[packed["byteOffset"] : packed["byteOffset"] + packed["byteLength"]]
            rows = meshopt.decode_gltf_buffer(content, packed["count"], packed["byteStride"], packed["mode"])
            content = np.ascontiguousarray(rows).tobytes()
        else:
            content = self.blob[start : start + place.byteLength]
        rows = np.frombuffer(content[: len(content) // stride * stride], np.uint8).reshape(-1, stride)
        return np.ascontiguousarray(rows[:, : width * np.dtype(kind).itemsize]).view(kind)

    def node(self, name: str) -> int:
        return next(i for i, node in enumerate(self.gltf.nodes) if node.name == name)

    def track(self, node: int, path: str) -> tuple[np.ndarray, np.ndarray]:
        motion = self.gltf.animations[0]
        channel = next(c for c in motion.channels if c.target.node == node and c.target.path == path)
        sampler = motion.samplers[channel.sampler]
        times = self.array(sampler.input)[:, 0]
        return times, self.array(sampler.output).reshape(len(times), -1)

    def world(self, node: int, frame: int) -> np.ndarray:
        """Matrix of a node at one key, (4, 4), acting on columns."""
        facts, local = self.gltf.nodes[node], np.eye(4)
        turn = facts.rotation
        if any(c.target.node == node and c.target.path == "rotation" for c in self.gltf.animations[0].channels):
            turn = self.track(node, "rotation")[1][frame]
        if turn is not None:
            local[:3, :3] = Rotation.from_quat(turn).as_matrix()
        if facts.translation is not None:
            local[:3, 3] = facts.translation
        if facts.scale is not None:
            local[:3, :3] *= facts.scale
        parent = next((i for i, other in enumerate(self.gltf.nodes) if node in (other.children or [])), None)
        return local if parent is None else self.world(parent, frame) @ local

    def vertices(self, node_name: str, frame: int) -> list[np.ndarray]:
        """World positions of every primitive of a node's mesh at one key, metres."""
        node = self.node(node_name)
        facts = self.gltf.nodes[node]
        placed = []
        for primitive in self.gltf.meshes[facts.mesh].primitives:
            points = self.array(primitive.attributes.POSITION).astype(np.float64)
            if primitive.targets:
                weights = self.track(node, "weights")[1][frame]
                for weight, target in zip(weights, primitive.targets, strict=True):
                    points += weight * self.array(target["POSITION"] if isinstance(target, dict) else target.POSITION)
            points = np.hstack([points, np.ones((len(points), 1))])
            if facts.skin is None:
                placed.append((points @ self.world(node, frame).T)[:, :3])
                continue
            skin = self.gltf.skins[facts.skin]
            inverse = self.array(skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
            joints = np.array([self.world(j, frame) @ inv for j, inv in zip(skin.joints, inverse, strict=True)])
            weights = self.array(primitive.attributes.WEIGHTS_0).astype(np.float64)
            matrices = np.einsum("nk,nkij->nij", weights, joints[self.array(primitive.attributes.JOINTS_0)])
            placed.append(np.einsum("nij,nj->ni", matrices, points)[:, :3])
        return placed
