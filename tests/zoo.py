"""Faces of every kind that other programs write, made small and by rule: the zoo of the tests for foreign faces.

Every animal is a head of a few hundred vertices in metres, with a bump for each morph target, eyes, and whatever makes
its kind special. `ZOO` maps names to makers; each returns an `Animal` that says what has to move, written by hand.
"""

from __future__ import annotations

import base64
import io
import json
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from mien.core.channels import ARKIT
from tests.faces import ball

VISEMES = ("sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "I", "O", "U")
_TYPES = {"f4": 5126, "i2": 5122, "i1": 5120, "u2": 5123, "u1": 5121, "u4": 5125}


@dataclass
class Animal:
    """A file, and what must come of it.

    ``moves`` names (mesh, target place) -> {channel: weight}; every other target must stay at rest. ``turns`` are the
    names of the nodes that turn. ``drawn`` says whether it can be drawn.
    """

    path: Path
    moves: dict[tuple[int, int], dict[str, float]]
    turns: set[str] = field(default_factory=set)
    drawn: bool = True
    names: Path | None = None
    binary: set[tuple[int, int]] = field(default_factory=set)
    facing: int = 1


class Builder:
    """A glTF document in the making."""

    def __init__(self, **facts: Any) -> None:
        self.document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "the zoo"}, **facts}
        self.blob = bytearray()
        self.head, self.triangles, self.uv = ball((0, -0.03, -0.075), (0.075, 0.115, 0.09), 14, 20)

    def list_of(self, name: str) -> list[dict[str, Any]]:
        return self.document.setdefault(name, [])

    def put(self, name: str, entry: dict[str, Any]) -> int:
        self.list_of(name).append(entry)
        return len(self.list_of(name)) - 1

    def view(self, data: bytes, **facts: Any) -> int:
        self.blob += bytes(-len(self.blob) % 8)
        place = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)}
        self.blob += data
        return self.put("bufferViews", {**place, **facts})

    def accessor(self, values: np.ndarray, kind: str = "f4", bounds: bool = False, **facts: Any) -> int:
        data = np.ascontiguousarray(values, dtype="<" + kind)
        width = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[1 if data.ndim == 1 else data.shape[1]]
        size = data.itemsize * (1 if data.ndim == 1 else data.shape[1])
        if data.ndim > 1 and size % 4:  # vertex data is laid out in fours
            rows = np.zeros((len(data), size + 4 - size % 4), np.uint8)
            rows[:, :size] = data.view(np.uint8).reshape(len(data), size)
            view = self.view(rows.tobytes(), byteStride=rows.shape[1], target=34962)
        else:
            view = self.view(data.tobytes())
        entry = {"bufferView": view, "componentType": _TYPES[kind], "count": len(data), "type": width, **facts}
        if bounds:
            flat = data.reshape(len(data), -1)
            entry |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        return self.put("accessors", entry)

    def sparse(self, values: np.ndarray) -> int:
        rows = np.flatnonzero(values.any(axis=1))
        entry: dict[str, Any] = {"componentType": 5126, "count": len(values), "type": "VEC3"}
        entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        if len(rows):
            entry["sparse"] = {
                "count": len(rows),
                "indices": {"bufferView": self.view(rows.astype("<u2").tobytes()), "componentType": 5123},
                "values": {"bufferView": self.view(values[rows].astype("<f4").tobytes())},
            }
        return self.put("accessors", entry)

    def offsets(self, number: int) -> np.ndarray:
        """What target ``number`` does: a bump at a place of its own on the front of the face."""
        angle = 2.4 * number
        place = np.array([0.045 * np.sin(angle), -0.03 + 0.06 * np.cos(angle), 0.0])
        share = np.clip(1 - np.linalg.norm(self.head - place, axis=1) / 0.05, 0, 1)[:, None]
        return (share * np.array([0.002 * np.cos(angle), 0.003, 0.004])).astype(np.float32)

    def primitive(self, targets: int, how: str = "float", **facts: Any) -> dict[str, Any]:
        primitive: dict[str, Any] = {
            "attributes": {"POSITION": self.accessor(self.head, bounds=True), "TEXCOORD_0": self.accessor(self.uv)},
            "indices": self.accessor(self.triangles.reshape(-1), "u2"),
            **facts,
        }
        made: dict[str, Callable[[np.ndarray], int]] = {
            "float": lambda values: self.accessor(values, bounds=True),
            "sparse": self.sparse,
            "quantised": lambda values: self.accessor(np.round(values * 32767), "i2", bounds=True, normalized=True),
        }
        if targets:
            primitive["targets"] = [{"POSITION": made[how](self.offsets(number))} for number in range(targets)]
        return primitive

    def mesh(
        self, names: Sequence[str], how: str = "float", name: str = "Head", primitives: int = 1, **facts: Any
    ) -> int:
        rows = [self.primitive(len(names), how) for _ in range(primitives)]
        extras = {"extras": {"targetNames": list(names)}} if any(names) else {}
        return self.put("meshes", {"name": name, "primitives": rows, **extras, **facts})

    def picture(self) -> bytes:
        stream = io.BytesIO()
        Image.new("RGB", (8, 8), (205, 160, 140)).save(stream, "PNG")
        return stream.getvalue()

    def glb(self, path: Path, others: Sequence[tuple[int, bytes]] = ()) -> Path:
        buffers = self.list_of("buffers")
        if buffers:
            buffers[0]["byteLength"] = len(self.blob)
        else:
            buffers.append({"byteLength": len(self.blob)})
        self._scene()
        text = json.dumps(self.document, ensure_ascii=False).encode()
        chunks = [
            (0x4E4F534A, text + b" " * (-len(text) % 4)),
            (0x004E4942, bytes(self.blob) + bytes(-len(self.blob) % 4)),
        ]
        body = b"".join(struct.pack("<II", len(data), kind) + data for kind, data in (*chunks, *others))
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
        return path

    def gltf(self, path: Path, uri: str | None = None) -> Path:
        """Text, with the buffer in a file beside it, or in a data URI."""
        if uri is None:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        else:
            (path.parent / uri.replace("%20", " ")).write_bytes(self.blob)
        self.document["buffers"] = [{"byteLength": len(self.blob), "uri": uri}]
        self._scene()
        path.write_text(json.dumps(self.document), encoding="utf-8")
        return path

    def _scene(self) -> None:
        if "scenes" not in self.document:
            nodes = self.list_of("nodes")
            below = {child for node in nodes for child in node.get("children", [])}
            self.document |= {"scene": 0, "scenes": [{"nodes": [n for n in range(len(nodes)) if n not in below]}]}

    def eye_mesh(self) -> int:
        points, triangles, uv = ball((0, 0, 0), (0.014, 0.014, 0.014), 6, 8)
        primitive = {
            "attributes": {"POSITION": self.accessor(points, bounds=True), "TEXCOORD_0": self.accessor(uv)},
            "indices": self.accessor(triangles.reshape(-1), "u2"),
        }
        return self.put("meshes", {"name": "Eye", "primitives": [primitive]})

    def bust(self, mesh: int, names: tuple[str, str, str] = ("Head", "LeftEye", "RightEye"), flip: int = 1) -> None:
        """A head node with the mesh and two eyes below it."""
        eye = self.eye_mesh()
        face = self.put("nodes", {"name": "FaceMesh", "mesh": mesh})
        eyes = [
            self.put("nodes", {"name": name, "mesh": eye, "translation": [flip * x, 0.0, flip * 0.002]})
            for name, x in zip(names[1:], (0.0315, -0.0315), strict=True)
        ]
        self.put("nodes", {"name": names[0], "children": [face, *eyes]})

    def avatar(self, mesh: int, prefix: str = "") -> None:
        """A skinned head on bones that have axes of their own, as avatars have them."""
        tilt = [0.5, 0.5, 0.5, 0.5]
        count = len(self.head)
        joints = np.zeros((count, 4), np.uint8)
        joints[:, 0] = np.where(self.head[:, 1] > -0.1, 1, 0)
        weights = np.zeros((count, 4), np.float32)
        weights[:, 0] = 1.0
        for primitive in self.list_of("meshes")[mesh]["primitives"]:
            primitive["attributes"] |= {"JOINTS_0": self.accessor(joints, "u1"), "WEIGHTS_0": self.accessor(weights)}
        first = len(self.list_of("nodes"))
        self.put(
            "nodes",
            {"name": prefix + "Neck", "translation": [0.0, -0.14, -0.07], "rotation": tilt, "children": [first + 1]},
        )
        back = {"rotation": [-0.5, -0.5, -0.5, 0.5], "translation": [0.04, 0.0, 0.0]}
        self.put("nodes", {"name": prefix + "Head", **back, "children": [first + 2, first + 3]})
        self.put("nodes", {"name": prefix + "LeftEye", "translation": [0.0315, 0.1, 0.07]})
        self.put("nodes", {"name": prefix + "RightEye", "translation": [-0.0315, 0.1, 0.07]})
        inverse = []
        for matrix in self._worlds([first, first + 1]):
            inverse.append(np.linalg.inv(matrix).T.reshape(-1))
        bind = self.accessor(np.array(inverse))
        skin = self.put("skins", {"joints": [first, first + 1, first + 2, first + 3], "inverseBindMatrices": bind})
        eyes = np.array([*inverse, *inverse])  # unused by any vertex, but the skin names four joints
        self.list_of("skins")[skin]["inverseBindMatrices"] = self.accessor(eyes)
        self.put("nodes", {"name": "Body", "mesh": mesh, "skin": skin})

    def _worlds(self, numbers: Sequence[int]) -> list[np.ndarray]:
        from scipy.spatial.transform import Rotation

        result: list[np.ndarray] = []
        for number in numbers:
            node, local = self.list_of("nodes")[number], np.eye(4)
            local[:3, :3] = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
            local[:3, 3] = node.get("translation", [0, 0, 0])
            result.append(result[-1] @ local if result else local)
        return result


def same(names: Sequence[str], mesh: int = 0) -> dict[tuple[int, int], dict[str, float]]:
    return {(mesh, place): {name: 1.0} for place, name in enumerate(names) if name in ARKIT}


TURNS = {"Head", "LeftEye", "RightEye"}


def arkit(folder: Path) -> Animal:
    made = Builder(extras={"mine": [1, 2.5, None]})
    made.bust(made.mesh(ARKIT, extensions={"ACME_fur": {"length": 3}}))
    made.document["extensionsUsed"] = ["ACME_fur"]
    return Animal(made.glb(folder / "arkit.glb", [(0x454D4341, b"four")]), same(ARKIT), TURNS)


def face_cap(folder: Path) -> Animal:
    """Like three.js's facecap.glb: meshopt with a fallback buffer, KTX2, L and R, a clip of its own, a matrix head."""
    names = [
        name.replace("Left", "_L").replace("Right", "_R")
        if name not in ("jawLeft", "jawRight", "mouthLeft", "mouthRight")
        else name
        for name in ARKIT
    ]
    made = Builder()
    mesh = made.mesh(names, "quantised", "mesh_2")
    made.document["extensionsUsed"] = ["KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_texture_basisu"]
    made.document["extensionsRequired"] = ["KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_texture_basisu"]
    made.put("images", {"bufferView": made.view(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(68)), "mimeType": "image/ktx2"})
    made.put("textures", {"extensions": {"KHR_texture_basisu": {"source": 0}}})
    made.put("materials", {"name": "head", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    made.list_of("meshes")[0]["primitives"][0]["material"] = 0
    face = made.put("nodes", {"name": "mesh_2", "mesh": mesh})
    eye = made.eye_mesh()
    eyes = [
        made.put("nodes", {"name": n, "mesh": eye, "translation": [x, 0, 0.002]})
        for n, x in (("eyeLeft", 0.0315), ("eyeRight", -0.0315))
    ]
    turned = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.0, 0.2, 0.0, 1]
    made.put("nodes", {"name": "grp_transform", "matrix": turned, "children": [face, *eyes]})
    own = made.accessor(np.zeros(2 * len(names), np.float32))
    clock = made.accessor(np.array([0, 1], np.float32), bounds=True)
    channel = {"sampler": 0, "target": {"node": face, "path": "weights"}}
    made.put("animations", {"name": "clip", "channels": [channel], "samplers": [{"input": clock, "output": own}]})
    _compress(made)
    return Animal(made.glb(folder / "face_cap.glb"), same(ARKIT), {"grp_transform", "eyeLeft", "eyeRight"})


def _compress(made: Builder) -> None:
    """Put what positions and targets use into meshopt's streams, and leave a fallback buffer without bytes."""
    accessors, views = made.list_of("accessors"), made.list_of("bufferViews")
    primitive = made.list_of("meshes")[0]["primitives"][0]
    chosen = {accessors[t["POSITION"]]["bufferView"] for t in primitive["targets"]} | {
        accessors[primitive["attributes"]["POSITION"]]["bufferView"]
    }
    plain, packed = bytes(made.blob), bytearray()
    made.blob = bytearray()
    fallback = 0
    for number, view in enumerate(views):
        data = plain[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        made.blob += bytes(-len(made.blob) % 8)
        if number not in chosen:
            view["byteOffset"] = len(made.blob)
            made.blob += data
            continue
        stride = view.get("byteStride", 12)
        packed = bytearray(encoded(data, stride))
        facts = {"buffer": 0, "byteOffset": len(made.blob), "byteLength": len(packed), "byteStride": stride}
        facts |= {"mode": "ATTRIBUTES", "count": len(data) // stride}
        made.blob += packed
        view |= {"buffer": 1, "byteOffset": fallback, "byteStride": stride, "target": 34962}
        view["extensions"] = {"EXT_meshopt_compression": facts}
        fallback += len(data) + (-len(data) % 8)
    made.document["buffers"] = [
        {"byteLength": 0},
        {"byteLength": fallback, "extensions": {"EXT_meshopt_compression": {"fallback": True}}},
    ]


def encoded(data: bytes, stride: int) -> bytes:
    """Rows of bytes as an attribute stream of EXT_meshopt_compression that packs nothing: every group is literal."""
    rows = np.frombuffer(data, np.uint8).reshape(-1, stride)
    most, out, last = min((8192 // stride) & ~15, 256), bytearray(b"\xa0"), rows[0].astype(int)
    first = last.copy()
    for start in range(0, len(rows), most):
        block = rows[start : start + most].astype(int)
        groups = -(-len(block) // 16)
        for k in range(stride):
            delta = np.diff(np.concatenate([[last[k]], block[:, k]]))
            delta = (delta + 128) % 256 - 128
            zigzag = np.where(delta < 0, -2 * delta - 1, 2 * delta).astype(np.uint8)
            out += b"\xff" * (-(-groups // 4)) + zigzag.tobytes() + bytes(groups * 16 - len(block))
        last = block[-1]
    tail = first.astype(np.uint8).tobytes()
    return bytes(out) + bytes(max(32 - stride, 0)) + tail


def ready_player_me(folder: Path) -> Animal:
    names = [*ARKIT, *(f"viseme_{name}" for name in VISEMES), "mouthOpen", "mouthSmile", "eyesClosed", "eyesLookUp"]
    made = Builder()
    made.avatar(made.mesh(names, "sparse", "Wolf3D_Head"))
    teeth = made.mesh(names, "sparse", "Wolf3D_Teeth")
    made.put("nodes", {"name": "Wolf3D_Teeth", "mesh": teeth})
    return Animal(made.glb(folder / "rpm.glb"), {**same(ARKIT), **same(ARKIT, 1)}, TURNS | {"Neck"})


def ready_player_me_small(folder: Path) -> Animal:
    """Without ARKit's shapes: fifteen visemes and two shapes."""
    names = [*(f"viseme_{name}" for name in VISEMES), "mouthOpen", "mouthSmile"]
    made = Builder()
    made.avatar(made.mesh(names, name="Wolf3D_Head"))
    place = {name: number for number, name in enumerate(VISEMES)}
    moves = {
        (0, place["PP"]): {"mouthPressLeft": 1.2, "mouthPressRight": 1.2, "mouthClose": 1.5},
        (0, place["FF"]): {"mouthRollLower": 1.1},
        (0, place["TH"]): {"tongueOut": 1.4},
        (0, place["DD"]): {"tongueTipUp": 0.8, "mouthFunnel": -0.8},
        (0, place["kk"]): {"tongueBackUp": 0.8},
        (0, place["CH"]): {"mouthFunnel": 0.6, "mouthPucker": 0.3, "tongueTipUp": 0.5, "jawOpen": -1.0},
        (0, place["SS"]): {"mouthLowerDownLeft": 0.6, "mouthLowerDownRight": 0.6, "jawOpen": -1.5, "mouthFunnel": -1.0},
        (0, place["nn"]): {"tongueTipUp": 0.3, "mouthFunnel": -0.3},
        (0, place["RR"]): {
            "mouthFunnel": 0.5,
            "tongueTipUp": 0.5,
            "mouthLowerDownLeft": -1.0,
            "mouthLowerDownRight": -1.0,
        },
        (0, place["aa"]): {"jawOpen": 1.4, "mouthFunnel": -0.7, "mouthPucker": -0.7},
        (0, place["E"]): {
            "mouthUpperUpLeft": 0.5,
            "mouthUpperUpRight": 0.5,
            "mouthLowerDownLeft": 0.5,
            "mouthLowerDownRight": 0.5,
        },
        (0, place["I"]): {
            "mouthStretchLeft": 0.8,
            "mouthStretchRight": 0.8,
            "mouthSmileLeft": 0.15,
            "mouthSmileRight": 0.15,
        },
        (0, place["O"]): {"mouthFunnel": 1.0},
        (0, place["U"]): {"mouthPucker": 1.0},
    }
    return Animal(
        made.glb(folder / "rpm_small.glb"),
        moves | {(0, 16): {"mouthSmileLeft": 0.5, "mouthSmileRight": 0.5}},
        TURNS | {"Neck"},
    )


_VOWELS = {
    "a": {"jawOpen": 1.4, "mouthFunnel": -0.7, "mouthPucker": -0.7},
    "u": {"mouthPucker": 1.0},
    "o": {"mouthFunnel": 1.0},
}


def vrm_0(folder: Path) -> Animal:
    """Unnamed targets, blend shape groups with shares of a hundred, one of them binary; it looks along -z."""
    made = Builder()
    made.head = made.head * np.float32([-1, 1, -1])
    mesh = made.mesh([""] * 6)
    made.bust(mesh, ("J_Bip_C_Head", "J_Adj_L_FaceEye", "J_Adj_R_FaceEye"), flip=-1)
    groups = [
        {
            "name": "A",
            "presetName": "a",
            "binds": [{"mesh": 0, "index": 0, "weight": 80}, {"mesh": 0, "index": 1, "weight": 50}],
        },
        {"name": "U", "presetName": "u", "binds": [{"mesh": 0, "index": 2, "weight": 100}], "isBinary": True},
        {"name": "O", "presetName": "o", "binds": [{"mesh": 0, "index": 3, "weight": 100}]},
        {"name": "Blink_L", "presetName": "blink_l", "binds": [{"mesh": 0, "index": 4, "weight": 100}]},
        {"name": "Blink", "presetName": "blink", "binds": [{"mesh": 0, "index": 4, "weight": 100}]},
        {"name": "Ghost", "presetName": "unknown", "binds": [{"mesh": -1, "index": 4, "weight": 100}]},
    ]
    bones = [{"bone": "head", "node": 3}, {"bone": "leftEye", "node": 1}, {"bone": "rightEye", "node": 2}]
    look = {"lookAtTypeName": "Bone", "lookAtVerticalUp": {"xRange": 90, "yRange": 10}}
    made.document["extensions"] = {
        "VRM": {
            "blendShapeMaster": {"blendShapeGroups": groups},
            "humanoid": {"humanBones": bones},
            "firstPerson": look,
        }
    }
    made.document["extensionsUsed"] = ["VRM"]
    moves = {
        (0, 0): {name: 0.8 * weight for name, weight in _VOWELS["a"].items()},
        (0, 1): {name: 0.5 * weight for name, weight in _VOWELS["a"].items()},
        (0, 2): _VOWELS["u"],
        (0, 3): _VOWELS["o"],
        (0, 4): {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 0.5},
    }
    moves[0, 4] = {"eyeBlinkLeft": 1.5, "eyeBlinkRight": 0.5}  # its own preset and the one for both eyes
    turns = {"J_Bip_C_Head", "J_Adj_L_FaceEye", "J_Adj_R_FaceEye"}
    return Animal(made.glb(folder / "zero.vrm"), moves, turns, binary={(0, 2)}, facing=-1)


def vrm_1(folder: Path) -> Animal:
    names = [
        "Fcl_MTH_A",
        "Fcl_MTH_U",
        "Fcl_MTH_O",
        "Fcl_EYE_Close_L",
        "Fcl_EYE_Close_R",
        "Fcl_BRW_Angry",
        "Fcl_HA_Fung1",
    ]
    made = Builder()
    mesh = made.mesh(names)
    made.bust(mesh, ("Kopf", "AugeL", "AugeR"))
    preset = {
        name: {"morphTargetBinds": [{"node": 0, "index": place, "weight": 1.0}]}
        for place, name in enumerate(("aa", "ou", "oh", "blinkLeft", "blinkRight"))
    }
    bones = {"head": {"node": 3}, "leftEye": {"node": 1}, "rightEye": {"node": 2}}
    made.document["extensions"] = {
        "VRMC_vrm": {"specVersion": "1.0", "expressions": {"preset": preset}, "humanoid": {"humanBones": bones}}
    }
    made.document["extensionsUsed"] = ["VRMC_vrm"]
    moves = {
        (0, 0): _VOWELS["a"], (0, 1): _VOWELS["u"], (0, 2): _VOWELS["o"],
        (0, 3): {"eyeBlinkLeft": 1.0}, (0, 4): {"eyeBlinkRight": 1.0},
        (0, 5): {"browDownLeft": 0.5, "browDownRight": 0.5},
    }  # fmt: skip
    return Animal(made.glb(folder / "one.vrm"), moves, {"Kopf", "AugeL", "AugeR"})


def _named(file: str, table: dict[str, dict[str, float]], still: Sequence[str] = ()) -> Callable[[Path], Animal]:
    def make(folder: Path) -> Animal:
        made = Builder()
        made.bust(made.mesh([*table, *still]))
        return Animal(made.glb(folder / file), {(0, p): recipe for p, recipe in enumerate(table.values())}, TURNS)

    return make


reallusion = _named(
    "cc4.glb",
    {
        "Brow_Raise_Inner_L": {"browInnerUp": 1, "browInnerUpLeft": 1},
        "Brow_Drop_R": {"browDownRight": 1},
        "Eye_Blink_L": {"eyeBlinkLeft": 1},
        "Eye_L_Look_R": {"eyeLookInLeft": 1},
        "Eye_R_Look_Up": {"eyeLookUpRight": 1},
        "Mouth_Pucker_Up_L": {"mouthPucker": 1},
        "Mouth_Pucker_Down_R": {"mouthPucker": 1},
        "Mouth_Funnel_Up_R": {"mouthFunnel": 1},
        "Mouth_Roll_In_Lower_L": {"mouthRollLower": 1},
        "Mouth_Up_Upper_L": {"mouthUpperUpLeft": 1},
        "Mouth_Down_Lower_R": {"mouthLowerDownRight": 1},
        "Mouth_Shrug_Lower": {"mouthShrugLower": 1},
        "Mouth_Close": {"mouthClose": 1},
        "Mouth_L": {"mouthLeft": 1},
        "Jaw_Open": {"jawOpen": 1},
        "Jaw_R": {"jawRight": 1},
        "Cheek_Raise_L": {"cheekSquintLeft": 1},
        "Mouth_Smile_L": {"mouthSmileLeft": 1},
        "Mouth_Press_R": {"mouthPressRight": 1},
        "Mouth_Stretch_L": {"mouthStretchLeft": 1},
    },
    ("V_Open", "V_Explosive", "V_Dental_Lip", "V_Tight_O", "Neck_Swallow_Up"),
)
ex_plus = _named(
    "explus.glb",
    {
        "A25_Jaw_Open": {"jawOpen": 1},
        "A14_Eye_Blink_Left": {"eyeBlinkLeft": 1},
        "A01_Brow_Inner_Up": {"browInnerUp": 1},
    },
)
metahuman = _named(
    "metahuman.glb",
    {
        "CTRL_expressions_mouthCornerPullL": {"mouthSmileLeft": 1},
        "CTRL_expressions_mouthFunnelUL": {"mouthFunnel": 1},
        "CTRL_expressions_browRaiseInR": {"browInnerUp": 1, "browInnerUpRight": 1},
        "CTRL_expressions_jawOpen": {"jawOpen": 1},
        "CTRL_expressions_eyeLookLeftL": {"eyeLookOutLeft": 1},
        "CTRL_expressions_mouthLipsPurseDR": {"mouthPucker": 1},
    },
)
units = _named(
    "units.glb",
    {
        "AU01_L": {"browInnerUp": 1, "browInnerUpLeft": 1},
        "au_12_left": {"mouthSmileLeft": 1},
        "AU12R": {"mouthSmileRight": 1},
        "AU4": {"browDownLeft": 0.5, "browDownRight": 0.5},
        "AU18": {"mouthPucker": 1},
        "AU27": {"jawOpen": 1},
        "AU45": {"eyeBlinkLeft": 0.5, "eyeBlinkRight": 0.5},
    },
    ("AU26", "AU99", "Base"),
)
muscles = _named(
    "muscles.glb",
    {
        "Inner_Brow_Raiser_L": {"browInnerUp": 1, "browInnerUpLeft": 1},
        "Lip_Corner_Puller_R": {"mouthSmileRight": 1},
        "Jaw_Drop": {"jawOpen": 1},
        "Lip_Funneler_LB": {"mouthFunnel": 1},
        "Lips_Toward": {"mouthClose": 1},
        "Nose_Wrinkler_L": {"noseSneerLeft": 1},
    },
)
trackers = _named(
    "unified.glb",
    {
        "EyeClosedLeft": {"eyeBlinkLeft": 1},
        "MouthCornerPullLeft": {"mouthSmileLeft": 1},
        "LipFunnelUpperLeft": {"mouthFunnel": 1},
        "LipSuckLowerRight": {"mouthRollLower": 1},
        "JawOpen": {"jawOpen": 1},
        "BrowLowererRight": {"browDownRight": 1},
    },
)
maya = _named("maya.glb", {f"blendShape1.{name}": {name: 1} for name in ("jawOpen", "mouthSmileLeft", "eyeBlinkRight")})
anna = _named(
    "anna.glb", {f"Anna_v2_{name}_geo": {name: 1} for name in ("jawOpen", "mouthPucker", "browDownLeft", "mouthLeft")}
)
mmd = _named(
    "mmd.glb",
    {
        "あ": _VOWELS["a"],
        "う": _VOWELS["u"],
        "まばたき": {"eyeBlinkLeft": 0.5, "eyeBlinkRight": 0.5},
        "困る": {"browInnerUp": 0.8},
    },
)
hand_made = _named(
    "hand.glb", {"open": {"jawOpen": 1}, "Smile": {"mouthSmileLeft": 0.5, "mouthSmileRight": 0.5}}, ("tail wag",)
)


def text_with_files(folder: Path) -> Animal:
    made = Builder()
    made.put("images", {"uri": "skin%20one.png"})
    (folder / "skin one.png").write_bytes(made.picture())
    made.put("textures", {"source": 0})
    made.put("materials", {"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    mesh = made.mesh(ARKIT)
    made.list_of("meshes")[0]["primitives"][0]["material"] = 0
    made.bust(mesh)
    return Animal(made.gltf(folder / "files.gltf", "the%20mesh.bin"), same(ARKIT), TURNS)


def text_alone(folder: Path) -> Animal:
    made = Builder()
    made.bust(made.mesh(ARKIT))
    return Animal(made.gltf(folder / "alone.gltf"), same(ARKIT), TURNS)


def shared(folder: Path) -> Animal:
    """Two primitives in a mesh, one mesh on two nodes, a second mesh with targets of its own and rest weights."""
    made = Builder()
    mesh = made.mesh(["jawOpen", "eyeBlinkLeft"], primitives=2)
    made.bust(mesh)
    made.put("nodes", {"name": "twin", "mesh": mesh, "translation": [0.3, 0, 0]})
    other = made.mesh(["jawOpen", "nonsense"], name="Beard", weights=[0.0, 0.25])
    made.put("nodes", {"name": "beard", "mesh": other})
    return Animal(
        made.glb(folder / "shared.glb"),
        {(0, 0): {"jawOpen": 1}, (0, 1): {"eyeBlinkLeft": 1}, (2, 0): {"jawOpen": 1}},
        TURNS,
    )


def by_accessor_names(folder: Path) -> Animal:
    made = Builder()
    mesh = made.mesh(["", ""])
    for name, target in zip(
        ("jawOpen", "mouthFunnel"), made.list_of("meshes")[0]["primitives"][0]["targets"], strict=True
    ):
        made.list_of("accessors")[target["POSITION"]]["name"] = name
    made.bust(mesh)
    return Animal(made.glb(folder / "accessors.glb"), same(["jawOpen", "mouthFunnel"]), TURNS)


def draco(folder: Path) -> Animal:
    made = Builder(extensionsUsed=["KHR_draco_mesh_compression"])
    mesh = made.mesh(ARKIT[:20])
    packed = {"bufferView": made.view(b"DRACO" + bytes(27)), "attributes": {"POSITION": 0}}
    made.list_of("meshes")[0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": packed}
    made.bust(mesh)
    return Animal(made.glb(folder / "draco.glb"), same(ARKIT[:20]), TURNS)


def own_table(folder: Path) -> Animal:
    made = Builder()
    mesh = made.mesh(["Maul auf", "Ecke", "jawOpen", "Braue"])
    made.bust(mesh, ("Bone.007", "b1", "b2"))
    names = folder / "names.toml"
    text = """[targets]
"Maul auf" = "jawOpen"
"Ecke" = { mouthSmileLeft = 0.5, mouthSmileRight = 0.5 }
"jawOpen" = ""
"Braue" = "AU1"
"""
    names.write_text(text + '[nodes]\nhead = "Bone.007"\n', encoding="utf-8")
    moves = {
        (0, 0): {"jawOpen": 1},
        (0, 1): {"mouthSmileLeft": 0.5, "mouthSmileRight": 0.5},
        (0, 3): {"browInnerUp": 1},
    }
    return Animal(made.glb(folder / "own.glb"), moves, {"Bone.007"}, names=names)


def twice(folder: Path) -> Animal:
    """Names that repeat, more names than targets, and an empty list of animations."""
    made = Builder(animations=[])
    del made.document["animations"]
    mesh = made.mesh(["jawOpen", "jawOpen"])
    made.list_of("meshes")[mesh]["extras"]["targetNames"] += ["left over"]
    made.bust(mesh)
    return Animal(made.glb(folder / "twice.glb"), {(0, 0): {"jawOpen": 1}, (0, 1): {"jawOpen": 1}}, TURNS)


def shaped_eyes(folder: Path) -> Animal:
    """Eyeballs that look about by shapes of their own: their bones must not turn them as well."""
    made = Builder()
    made.bust(made.mesh(ARKIT))
    looks = ["eyeLookUpLeft", "eyeLookInLeft"]
    eyeball = made.mesh(looks, name="EyeLeft")
    made.put("nodes", {"name": "EyeLeft_mesh", "mesh": eyeball})
    return Animal(made.glb(folder / "eyes.glb"), {**same(ARKIT), **same(looks, eyeball)}, {"Head"})


def loose_head(folder: Path) -> Animal:
    """A mesh named head beside its teeth: it must not turn away from them."""
    made = Builder()
    made.put("nodes", {"name": "head", "mesh": made.mesh(["jawOpen"]), "translation": [0.0, 0.1, 0.0]})
    teeth = made.mesh(["jawOpen"], name="teeth")
    made.put("nodes", {"name": "teeth", "mesh": teeth, "translation": [0.0, 0.1, 0.0]})
    return Animal(made.glb(folder / "loose.glb"), {(0, 0): {"jawOpen": 1}, (1, 0): {"jawOpen": 1}}, set())


def quantised(folder: Path) -> Animal:
    made = Builder(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    made.bust(made.mesh(ARKIT, "quantised"))
    return Animal(made.glb(folder / "quantised.glb"), same(ARKIT), TURNS)


ZOO: dict[str, Callable[[Path], Animal]] = {
    "arkit": arkit, "face_cap": face_cap, "ready_player_me": ready_player_me, "rpm_small": ready_player_me_small,
    "vrm_0": vrm_0, "vrm_1": vrm_1, "reallusion": reallusion, "ex_plus": ex_plus, "metahuman": metahuman,
    "units": units, "muscles": muscles, "trackers": trackers, "maya": maya, "anna": anna, "mmd": mmd,
    "hand_made": hand_made, "text_with_files": text_with_files, "text_alone": text_alone, "shared": shared,
    "by_accessor_names": by_accessor_names, "draco": draco, "own_table": own_table, "twice": twice,
    "quantised": quantised, "shaped_eyes": shaped_eyes, "loose_head": loose_head,
}  # fmt: skip
