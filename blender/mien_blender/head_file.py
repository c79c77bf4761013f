"""The head as mien reads it, a small GLB with shapes and bones alone, and what mien gives back: weights and turns.

No Blender in here. mien finds out by names and by geometry what each shape does (docs/faces.md); nothing is guessed on
this side. Nodes lie flat in the world, so that a turn read back is about the world's axes.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

_TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass
class Shapes:
    """A mesh: points (n, 3), triangles (m, 3), and for each target its name, offsets (n, 3) and weight now."""

    points: np.ndarray
    triangles: np.ndarray
    targets: list[tuple[str, np.ndarray, float]] = field(default_factory=list)


@dataclass
class Node:
    """Something that has a place and may turn: metres, y up; the turn as x, y, z, w."""

    name: str
    place: Sequence[float] = (0.0, 0.0, 0.0)
    turn: Sequence[float] = (0.0, 0.0, 0.0, 1.0)
    shapes: Shapes | None = None
    joint: bool = False


class _Buffer:
    """The binary chunk as it grows, with its views and accessors."""

    def __init__(self) -> None:
        self.data, self.views, self.accessors = bytearray(), list[dict](), list[dict]()

    def view(self, array: np.ndarray) -> int:
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes})
        self.data.extend(np.ascontiguousarray(array).tobytes())
        self.data.extend(bytes(-len(self.data) % 4))
        return len(self.views) - 1

    def accessor(self, facts: dict) -> int:
        self.accessors.append(facts)
        return len(self.accessors) - 1

    def offsets(self, array: np.ndarray) -> int:
        """Displacements, of which only those that move are written."""
        array = array.astype(np.float32)
        rows = np.flatnonzero(array.any(axis=1)).astype(np.uint32)
        facts = {"componentType": 5126, "count": len(array), "type": "VEC3"} | _bounds(array)
        if len(rows):
            facts["sparse"] = {
                "count": len(rows),
                "indices": {"bufferView": self.view(rows), "componentType": 5125},
                "values": {"bufferView": self.view(array[rows])},
            }
        return self.accessor(facts)

    def mesh(self, name: str, shapes: Shapes) -> dict:
        points, triangles = shapes.points.astype(np.float32), shapes.triangles.astype(np.uint32)
        place = {"bufferView": self.view(points), "componentType": 5126, "count": len(points), "type": "VEC3"}
        corners = {"bufferView": self.view(triangles), "componentType": 5125, "count": triangles.size, "type": "SCALAR"}
        primitive = {
            "attributes": {"POSITION": self.accessor(place | _bounds(points))},
            "indices": self.accessor(corners),
        }
        mesh: dict = {"name": name, "primitives": [primitive]}
        if shapes.targets:
            primitive["targets"] = [{"POSITION": self.offsets(moved)} for _, moved, _ in shapes.targets]
            mesh["weights"] = [float(weight) for _, _, weight in shapes.targets]
            mesh["extras"] = {"targetNames": [name for name, _, _ in shapes.targets]}
        return mesh


def write_head(path: str | Path, nodes: Sequence[Node]) -> None:
    """Write nodes as a GLB."""
    buffer, meshes, out = _Buffer(), [], []
    for node in nodes:
        facts = {
            "name": node.name,
            "translation": list(map(float, node.place)),
            "rotation": list(map(float, node.turn)),
        }
        if node.shapes is not None:
            meshes.append(buffer.mesh(node.name, node.shapes))
            facts["mesh"] = len(meshes) - 1
        out.append(facts)
    data = buffer.data
    document = {
        "asset": {"version": "2.0", "generator": "mien for Blender"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(out)))}],
        "nodes": out,
        "meshes": meshes,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(data)}],
    }
    joints = [number for number, node in enumerate(nodes) if node.joint]
    if joints:
        document["skins"] = [{"joints": joints}]
    text = json.dumps(document).encode("utf-8")
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)


def _bounds(array: np.ndarray) -> dict:
    return {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()} if len(array) else {}


@dataclass(frozen=True)
class Motion:
    """What mien made of the head: seconds (frames,), weights by node (frames, targets), turns by node (frames, 4)."""

    seconds: np.ndarray
    weights: Mapping[int, np.ndarray]
    turns: Mapping[int, np.ndarray]


def read_motion(path: str | Path) -> Motion:
    """Read the animation named ``mien`` of a GLB that mien has driven; nodes by their numbers."""
    content = Path(path).read_bytes()
    length = struct.unpack_from("<I", content, 12)[0]
    document, start = json.loads(content[20 : 20 + length]), 20 + length + 8

    def values(number: int) -> np.ndarray:
        facts = document["accessors"][number]
        place = document["bufferViews"][facts["bufferView"]]
        width = _WIDTHS[facts["type"]]
        begin = start + place.get("byteOffset", 0) + facts.get("byteOffset", 0)
        flat = np.frombuffer(content, _TYPES[facts["componentType"]], facts["count"] * width, begin)
        return flat.reshape(-1, width) if width > 1 else flat

    animation = next(one for one in document["animations"] if one.get("name") == "mien")
    seconds, weights, turns = np.zeros(0), {}, {}
    for channel in animation["channels"]:
        sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
        seconds, output = values(sampler["input"]).astype(float), values(sampler["output"]).astype(float)
        if target["path"] == "weights":
            weights[target["node"]] = output.reshape(len(seconds), -1)
        elif target["path"] == "rotation":
            turns[target["node"]] = output
    return Motion(seconds, weights, turns)
