"""A GLB with fewer bytes for a page: whole numbers of 8 and 16 bits where a screen shows no difference.

Places and offsets of morph targets go in steps of 1/32767 (0.03 mm of a face in metres), normals in steps of 1/127, as
the glTF extension KHR_mesh_quantization has it; what of it compresses, the transport compresses.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["light_glb"]

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_CODES = {np.dtype(name): code for code, name in _TYPES.items()}
_SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def light_glb(content: bytes) -> bytes:
    """The same face with smaller numbers; a GLB of mien's own.

    Parameters
    ----------
    content : bytes
        A GLB with one buffer, whose animations are left out: a page poses the face itself.
    """
    length = int.from_bytes(content[12:16], "little")
    document = json.loads(content[20 : 20 + length])
    return _Light(document, content[28 + length :]).made()


class _Light:
    def __init__(self, document: dict[str, Any], data: bytes) -> None:
        self.old, self.data = document, data
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.known: dict[tuple[int, str], int] = {}
        self.pieces: list[bytes] = []
        self.size = 0

    def made(self) -> bytes:
        document = {name: value for name, value in self.old.items() if name != "animations"}
        for image in document.get("images", ()):
            image["bufferView"] = self._view(self._bytes(image["bufferView"]))
        for mesh in document["meshes"]:
            for primitive in mesh["primitives"]:
                primitive["indices"] = self._accessor(primitive["indices"], "index")
                primitive["attributes"] = {
                    name: self._accessor(number, name) for name, number in primitive["attributes"].items()
                }
                primitive["targets"] = [self._target(target) for target in primitive.get("targets", ())]
        for skin in document.get("skins", ()):
            skin["inverseBindMatrices"] = self._accessor(skin["inverseBindMatrices"], "matrix")
        document |= {
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}],
            "extensionsUsed": ["KHR_mesh_quantization"],
            "extensionsRequired": ["KHR_mesh_quantization"],
        }
        return _glb(document, b"".join(self.pieces))

    def _bytes(self, view: int) -> bytes:
        told = self.old["bufferViews"][view]
        first = told.get("byteOffset", 0)
        return self.data[first : first + told["byteLength"]]

    def _array(self, part: dict[str, Any], count: int, width: int) -> NDArray[Any]:
        kind = np.dtype(_TYPES[part["componentType"]])
        first = part.get("byteOffset", 0)
        told = self.old["bufferViews"][part["bufferView"]]
        row = told.get("byteStride") or width * kind.itemsize
        content = np.frombuffer(self._bytes(part["bufferView"])[first:], np.uint8)[
            : (count - 1) * row + width * kind.itemsize
        ]
        rows = np.lib.stride_tricks.as_strided(content, (count, width * kind.itemsize), (row, 1))
        return np.ascontiguousarray(rows).view(kind).reshape(count, width)

    def _view(self, content: bytes, **facts: int) -> int:
        padded = content + bytes(-len(content) % 4)
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(content), **facts})
        self.pieces.append(padded)
        self.size += len(padded)
        return len(self.views) - 1

    def _accessor(self, number: int, use: str) -> int:
        if (number, use) not in self.known:
            old = self.old["accessors"][number]
            self.known[number, use] = self._dense(old, use)
        return self.known[number, use]

    def _dense(self, old: dict[str, Any], use: str) -> int:
        count, width = old["count"], _SIZES[old["type"]]
        values = self._array(old, count, width)
        new = {name: value for name, value in old.items() if name not in ("bufferView", "byteOffset")}
        if use == "index" and count and int(values.max()) < 2**16:
            values = values.astype("<u2")
        elif use == "POSITION" and np.abs(values).max(initial=0) <= 1:
            values, new["normalized"] = _steps(values, np.int16), True
            new |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        elif use == "NORMAL":
            values, new["normalized"] = _steps(values, np.int8), True
        elif use in ("WEIGHTS_0", "COLOR_0") and values.dtype.kind == "f":
            values, new["normalized"] = _shares(values, use), True
        elif use == "TEXCOORD_0" and values.dtype.kind == "f" and values.min() >= 0 and values.max() <= 1:
            values, new["normalized"] = np.round(values * 65535).astype("<u2"), True
        new["componentType"] = _CODES[values.dtype]
        row = values.dtype.itemsize * width
        if use in ("index", "matrix") or row % 4 == 0:
            content, facts = values.tobytes(), {}
        else:  # vertices stand at multiples of four bytes
            padded = np.zeros((count, row + (-row % 4)), np.uint8)
            padded[:, :row] = np.ascontiguousarray(values).view(np.uint8).reshape(count, row)
            content, facts = padded.tobytes(), {"byteStride": padded.shape[1]}
        new["bufferView"] = self._view(content, **facts)
        self.accessors.append(new)
        return len(self.accessors) - 1

    def _target(self, target: dict[str, int]) -> dict[str, int]:
        """A morph target: its vertices are named once for places and normals, which move nearly the same ones."""
        steps = {name: self._moves(self.old["accessors"][number], name) for name, number in target.items()}
        moved = np.flatnonzero(np.any([values.any(axis=1) for values in steps.values()], axis=0))
        kind = "<u2" if all(len(values) < 2**16 for values in steps.values()) else "<u4"
        indices = {} if not len(moved) else {
            "bufferView": self._view(moved.astype(kind).tobytes()), "componentType": _CODES[np.dtype(kind)],
        }  # fmt: skip
        made = {}
        for name, values in steps.items():
            new: dict[str, Any] = {
                "componentType": _CODES[values.dtype], "normalized": True, "count": len(values), "type": "VEC3",
                "min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist(),
            }  # fmt: skip
            if indices:
                told = {"bufferView": self._view(values[moved].tobytes())}
                new["sparse"] = {"count": len(moved), "indices": indices, "values": told}
            self.accessors.append(new)
            made[name] = len(self.accessors) - 1
        return made

    def _moves(self, old: dict[str, Any], name: str) -> NDArray[Any]:
        values = np.zeros((old["count"], 3), np.float64)
        if "bufferView" in old:
            values[:] = self._array(old, old["count"], 3)
        if "sparse" in old:
            sparse = old["sparse"]
            places = self._array(sparse["indices"], sparse["count"], 1).ravel()
            values[places] = self._array({"componentType": 5126, **sparse["values"]}, sparse["count"], 3)
        return _steps(values, np.int16 if name == "POSITION" else np.int8)


def _steps(values: NDArray[Any], kind: type[np.signedinteger[Any]]) -> NDArray[Any]:
    most = np.iinfo(kind).max
    steps: NDArray[Any] = np.round(np.clip(values, -1, 1) * most).astype(np.dtype(kind).newbyteorder("<"))
    return steps


def _shares(values: NDArray[Any], use: str) -> NDArray[np.uint8]:
    whole = np.round(np.clip(values, 0, 1) * 255).astype(np.int64)
    if use == "WEIGHTS_0":  # they must add up to one
        whole[np.arange(len(whole)), whole.argmax(axis=1)] += 255 - whole.sum(axis=1)
    shares: NDArray[np.uint8] = whole.astype(np.uint8)
    return shares


def _glb(document: dict[str, Any], data: bytes) -> bytes:
    told = json.dumps(document, separators=(",", ":")).encode()
    told += b" " * (-len(told) % 4)
    total = 12 + 8 + len(told) + 8 + len(data)
    head = struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(told), b"JSON")
    return head + told + struct.pack("<I4s", len(data), b"BIN\0") + data
