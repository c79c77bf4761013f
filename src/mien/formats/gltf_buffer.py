"""The binary side of a GLB: arrays in, accessors out, and the two-chunk container.

Source: glTF 2.0 specification, sections 3.6 (binary data) and 4 (GLB).

Tried and left: pygltflib 1.16. Its dataclasses wrap the same JSON one to one, sparse accessors and alignment stay
the caller's work, and it brings two more packages; the tests read our files with it, as an independent reader.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["GltfBuffer", "MeshoptBuffer", "pack_glb"]

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
_COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class GltfBuffer:
    """Collects arrays; `views` and `accessors` are the lists of the glTF document."""

    def __init__(self) -> None:
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self._bytes = bytearray()
        self._zeros: dict[tuple[int, str], int] = {}
        self._rows: dict[bytes, int] = {}

    @property
    def data(self) -> bytes:
        """The binary chunk so far."""
        return bytes(self._bytes)

    @property
    def buffers(self) -> list[dict[str, Any]]:
        """The ``buffers`` of the document."""
        return [{"byteLength": len(self._bytes)}]

    def add_bytes(self, raw: bytes, target: int | None = None, stride: int | None = None) -> int:
        """Append raw bytes on a boundary of four; returns the number of their buffer view."""
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(raw)}
        if target is not None:
            view["target"] = target
        if stride is not None:
            view["byteStride"] = stride
        self._bytes += raw + bytes(-len(raw) % 4)
        self.views.append(view)
        return len(self.views) - 1

    def add_vertices(self, rows: NDArray[Any], target: int, stride: int | None = None) -> int:
        """Append what a graphics card takes: attributes of vertices, or their indices."""
        return self.add_bytes(rows.tobytes(), target, stride)

    def add(
        self, array: NDArray[Any], target: int | None = None, *, bounds: bool = False, normalized: bool = False
    ) -> int:
        """Append an array of shape (n,) or (n, 2..4), or (n, 16) for matrices; returns the number of its accessor.

        Parameters
        ----------
        array : ndarray of int8, uint8, int16, uint16, uint32 or float32
        target : int, optional
            What a graphics card uses it for; None for animation data.
        bounds : bool
            Whether to state the least and greatest value, as positions and key times must.
        normalized : bool
            Whether whole numbers stand for 0..1.
        """
        accessor = self._accessor(array)
        if target == ARRAY_BUFFER and array.ndim > 1 and (width := array.shape[1] * array.itemsize) % 4:
            stride = width + -width % 4  # rows of vertices begin at multiples of four bytes
            padded = np.zeros((len(array), stride // array.itemsize), array.dtype)
            padded[:, : array.shape[1]] = array
            accessor["bufferView"] = self.add_vertices(padded, target, stride)
        elif target is not None:
            accessor["bufferView"] = self.add_vertices(np.ascontiguousarray(array), target)
        else:
            accessor["bufferView"] = self.add_bytes(np.ascontiguousarray(array).tobytes())
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor |= _bounds(array)
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def add_constant(self, row: NDArray[Any], count: int, longest: int, *, normalized: bool = False) -> int:
        """Attributes that are the same for ``count`` vertices; all of the same row read one view of ``longest``."""
        raw = np.tile(row, (longest, 1))
        key = raw.tobytes()
        if key not in self._rows:
            self._rows[key] = self.add_vertices(raw, ARRAY_BUFFER)
        accessor = self._accessor(raw[:count]) | {"bufferView": self._rows[key]}
        self.accessors.append(accessor | ({"normalized": True} if normalized else {}))
        return len(self.accessors) - 1

    def add_sparse(self, array: NDArray[Any], *, normalized: bool = False, rows: NDArray[np.intp] | None = None) -> int:
        """Append an array of shape (n, 3) that is mostly zero; returns the number of its accessor.

        One that is all zero takes no bytes, and one accessor serves all of that length. ``rows`` are the rows to keep,
        all that are not zero unless given; the same rows twice are written once.
        """
        rows = np.flatnonzero(array.any(axis=1)) if rows is None else rows
        kind = (len(array), array.dtype.name)
        if len(rows) == 0 and kind in self._zeros:
            return self._zeros[kind]
        accessor = self._accessor(array) | _bounds(array)
        if normalized:
            accessor["normalized"] = True
        if len(rows):
            index = rows.astype(np.uint16 if len(array) <= 65_535 else np.uint32)
            raw = index.tobytes()
            if raw not in self._rows:
                self._rows[raw] = self.add_bytes(raw)
            accessor["sparse"] = {
                "count": len(rows),
                "indices": {"bufferView": self._rows[raw], "componentType": _COMPONENTS[index.dtype.name]},
                "values": {"bufferView": self.add_bytes(np.ascontiguousarray(array[rows]).tobytes())},
            }
        self.accessors.append(accessor)
        if len(rows) == 0:
            self._zeros[kind] = len(self.accessors) - 1
        return len(self.accessors) - 1

    def _accessor(self, array: NDArray[Any]) -> dict[str, Any]:
        width = 1 if array.ndim == 1 else array.shape[1]
        return {"componentType": _COMPONENTS[array.dtype.name], "count": len(array), "type": _SHAPES[width]}


def _bounds(array: NDArray[Any]) -> dict[str, Any]:
    columns = array.reshape(len(array), -1)
    return {"min": columns.min(axis=0).tolist(), "max": columns.max(axis=0).tolist()}


class MeshoptBuffer(GltfBuffer):
    """A `GltfBuffer` whose vertices and indices are compressed (``EXT_meshopt_compression``)."""

    def __init__(self) -> None:
        super().__init__()
        self._whole = 0

    @property
    def buffers(self) -> list[dict[str, Any]]:
        """The buffer that is there, and the one that it unpacks to."""
        unpacked = {"byteLength": self._whole, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
        return [*super().buffers, unpacked]

    def add_vertices(self, rows: NDArray[Any], target: int, stride: int | None = None) -> int:
        """As that of `GltfBuffer`, packed."""
        import meshopt

        mode = "TRIANGLES" if target == ELEMENT_ARRAY_BUFFER else "ATTRIBUTES"
        flat = rows.reshape(-1) if mode == "TRIANGLES" else rows.reshape(len(rows), -1)
        packed = meshopt.encode_gltf_buffer(flat, mode)
        width = flat.nbytes // len(flat)
        number = self.add_bytes(packed, target, width if stride or mode == "ATTRIBUTES" else None)
        view = self.views[number]
        view["extensions"] = {
            "EXT_meshopt_compression": {
                "buffer": 0, "byteOffset": view["byteOffset"], "byteLength": len(packed),
                "byteStride": width, "count": len(flat), "mode": mode,
            }
        }  # fmt: skip
        view |= {"buffer": 1, "byteOffset": self._whole, "byteLength": flat.nbytes}
        self._whole += flat.nbytes + -flat.nbytes % 4
        return number


def pack_glb(document: dict[str, Any], data: bytes) -> bytes:
    """Join a glTF document and its binary chunk into one GLB file.

    Examples
    --------
    >>> pack_glb({"asset": {"version": "2.0"}}, b"")[:4]
    b'glTF'
    """
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks
