"""A glTF file that is added to: the bytes that are there stay as they are, new ones go behind them.

Only the JSON is edited and the binary chunk extended; no mesh, picture or compressed buffer is decoded. A ``.gltf``
becomes a ``.glb`` that needs no other file: its first buffer is the binary chunk, further ones stay as ``data:`` URIs
under their numbers, pictures go into buffer views.
Source: glTF 2.0 specification, section 4.4 (binary container).
"""

from __future__ import annotations

import base64
import copy
import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.face.foreign.gltf_document import BIN, JSON, GltfDocument

__all__ = ["AppendedGlb"]

_PICTURES = {
    ".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp", ".ktx2": "image/ktx2",
    ".avif": "image/avif", ".dds": "image/vnd-ms.dds",
}  # fmt: skip


_USE_ACCESSORS = {"input", "output", "indices", "inverseBindMatrices", "attributes", "targets", "TRANSLATION"}


def _numbers_of(tree: Any, names: set[str], under: bool = False) -> set[int]:
    """Whole numbers that stand under one of the names anywhere in a document: what is referred to."""
    if isinstance(tree, dict):
        return {n for name, value in tree.items() for n in _numbers_of(value, names, under or name in names)}
    if isinstance(tree, list):
        return {n for value in tree for n in _numbers_of(value, names, under)}
    return {tree} if under and isinstance(tree, int) and not isinstance(tree, bool) else set()


class AppendedGlb:
    """Appends to a document without touching the bytes that are there, and gathers what lies in other files."""

    def __init__(self, source: GltfDocument) -> None:
        self.source, self.document = source, copy.deepcopy(source.json)
        self.notes: list[Note] = []
        buffers = self.document.setdefault("buffers", [])
        for number, buffer in enumerate(buffers):
            if "uri" in buffer and not str(buffer["uri"]).startswith("data:") and number > 0:
                data = source.buffer(number)
                buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode("ascii")
        if not buffers:
            buffers.append({"byteLength": 0})
            self.data, self.ours = bytearray(), 0
        elif source.binary is not None and "uri" not in buffers[0]:
            source.buffer(0)  # refuses one that is cut off
            self.data, self.ours = bytearray(source.binary), 0
        elif "uri" in buffers[0] and source.binary is None:
            self.data, self.ours = bytearray(source.buffer(0)), 0
            del buffers[0]["uri"]
        else:  # the first buffer is a compression's placeholder: keys go into one of their own
            buffers.append({"byteLength": 0})
            self.data, self.ours = bytearray(), len(buffers) - 1
        self._gather_pictures()

    def _gather_pictures(self) -> None:
        for number, image in enumerate(self.document.get("images", [])):
            uri = image.get("uri")
            if isinstance(uri, str) and not uri.startswith("data:"):
                try:
                    data = self.source.bytes_at(uri, f"picture {number}")
                except InputError as problem:
                    self.notes.append(Note("warning", f"{problem}; it is left as it is"))
                    continue
                del image["uri"]
                kind = _PICTURES.get(Path(uri.partition("?")[0]).suffix.lower(), "image/png")
                image["bufferView"] = self._view(data)
                image.setdefault("mimeType", kind)

    def forget_animations(self, which: Callable[[dict[str, Any]], bool]) -> None:
        """Take animations out, with their keys where those are the last things in the file."""
        animations = self.document.get("animations", [])
        if not any(map(which, animations)):
            return
        self.document["animations"] = [animation for animation in animations if not which(animation)]
        accessors, views = self.document.get("accessors", []), self.document.get("bufferViews", [])
        used = _numbers_of({k: v for k, v in self.document.items() if k != "accessors"}, _USE_ACCESSORS)
        while accessors and len(accessors) - 1 not in used and "sparse" not in accessors[-1]:
            accessors.pop()
        used = _numbers_of(self.document, {"bufferView"})
        while views and len(views) - 1 not in used and views[-1].get("buffer") == self.ours:
            if views[-1].get("byteOffset", 0) + views[-1]["byteLength"] + 3 < len(self.data):
                break
            del self.data[views[-1].get("byteOffset", 0) :]
            views.pop()

    def add(self, values: NDArray[np.float32], kind: str, bounds: bool = False) -> int:
        """Append an array of float32; returns the number of its accessor."""
        accessors = self.document.setdefault("accessors", [])
        accessor: dict[str, Any] = {
            "bufferView": self._view(values.astype("<f4").tobytes()),
            "componentType": 5126,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        accessors.append(accessor)
        return len(accessors) - 1

    def add_rows(self, values: NDArray[Any], like: Mapping[str, Any]) -> int:
        """Append rows (n, width) of an attribute in another accessor's place; returns the number of their own."""
        accessors = self.document.setdefault("accessors", [])
        size = values.dtype.itemsize * values.shape[1]
        padded = np.zeros((len(values), size + -size % 4), np.uint8)
        padded[:, :size] = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), size)
        view = self._view(padded.tobytes())
        self.document["bufferViews"][view]["byteStride"] = padded.shape[1]
        kept = {key: like[key] for key in ("componentType", "type", "normalized", "name") if key in like}
        accessor = kept | {"bufferView": view, "count": len(values)}
        if "min" in like:
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        accessors.append(accessor)
        return len(accessors) - 1

    def add_indices(self, corners: NDArray[Any]) -> int:
        """Append corners of triangles; returns the number of their accessor."""
        accessors = self.document.setdefault("accessors", [])
        view = self._view(corners.astype("<u4").tobytes())
        accessors.append({"bufferView": view, "componentType": 5125, "count": corners.size, "type": "SCALAR"})
        return len(accessors) - 1

    def add_sparse(self, count: int, rows: NDArray[np.int64], values: NDArray[np.float32]) -> int:
        """Append an accessor of ``count`` 3-vectors that is zero but for some rows, rising; returns its number."""
        accessors = self.document.setdefault("accessors", [])
        held = np.vstack([values, np.zeros((1, 3), np.float32)]) if len(rows) < count else values
        accessor: dict[str, Any] = {
            "componentType": 5126, "count": count, "type": "VEC3",
            "min": held.min(axis=0).tolist(), "max": held.max(axis=0).tolist(),
        }  # fmt: skip
        if len(rows):
            accessor["sparse"] = {
                "count": len(rows),
                "indices": {"bufferView": self._view(rows.astype("<u4").tobytes()), "componentType": 5125},
                "values": {"bufferView": self._view(values.astype("<f4").tobytes())},
            }
        accessors.append(accessor)
        return len(accessors) - 1

    def _view(self, data: bytes) -> int:
        self.data += bytes(-len(self.data) % 4)
        views = self.document.setdefault("bufferViews", [])
        views.append({"buffer": self.ours, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(views) - 1

    def packed(self) -> bytes:
        """The whole file."""
        buffer = self.document["buffers"][self.ours]
        buffer["byteLength"] = len(self.data)
        chunks: list[tuple[int, bytes]] = []
        if self.ours == 0:
            chunks.append((BIN, bytes(self.data) + bytes(-len(self.data) % 4)))
        else:
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode("ascii")
            if self.source.binary is not None:
                chunks.append((BIN, self.source.binary))
        text = json.dumps(self.document, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")
        everything = [(JSON, text + b" " * (-len(text) % 4)), *chunks, *self.source.other_chunks]
        body = b"".join(struct.pack("<II", len(data), kind) + data for kind, data in everything)
        if len(body) + 12 >= 2**32:
            raise InputError(f"{self.source.path}: with its keys the file would be larger than a GLB can be (4 GB)")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
