"""Numbers out of a glTF file: plain, sparse, quantised, meshopt- and Draco-compressed accessors.

Source: glTF 2.0 specification, 3.6.2 (accessors, sparse ones in 3.6.2.3) and 3.11 (normalised integers);
KHR_mesh_quantization; EXT_meshopt_compression (decoded by `mien.face.foreign.meshopt`).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import check_size
from mien.face.foreign.draco import decoded_draco, uses_draco
from mien.face.foreign.gltf_document import GltfDocument

__all__ = ["AccessorReader"]

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")


class AccessorReader:
    """Decodes accessors of one document; compressed buffer views are decoded once."""

    def __init__(self, document: GltfDocument) -> None:
        self.document = document
        self._views: dict[int, bytes] = {}
        self._decoded = 0

    @cached_property
    def _longest(self) -> int:
        """Elements of the longest accessor that has bytes of its own in the file: no other is longer in earnest."""
        counts = [facts.get("count") for facts in self.document.list_of("accessors") if "bufferView" in facts]
        counts += [len(values) for values in self._draco.values()]
        return max([count for count in counts if isinstance(count, int)], default=0)

    @cached_property
    def _draco(self) -> dict[int, NDArray[Any]]:
        """Values that Draco holds, by accessor."""
        return decoded_draco(self.document) if uses_draco(self.document) else {}

    def read(self, number: object, width: int) -> NDArray[np.float64]:
        """An accessor as float64, shape (count, width); normalised integers come in 0..1 or -1..1.

        Raises
        ------
        InputError
            If it does not hold together, lies outside its buffer, or has another width.
        """
        facts = self.document._entry("accessors", number)
        values = self._raw(facts, number)
        if values.shape[1] != width:
            raise InputError(f"{self.document.path}: accessor {number} has {values.shape[1]} columns, not {width}")
        result = values.astype(np.float64)
        if facts.get("normalized") and values.dtype.kind in "iu":
            result = np.maximum(result / np.iinfo(values.dtype).max, -1.0)
        if not np.isfinite(result).all():
            raise InputError(f"{self.document.path}: accessor {number} has numbers that are not finite")
        return result

    def offsets(self, number: object, count: int) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """What an accessor of ``count`` moves says, as the rows that are not zero and their values, shape (k, 3).

        What is sparse in the file is never laid out: a head of a million vertices may have dozens of shapes.

        Raises
        ------
        InputError
            As `read`, or if it has another number of rows.
        """
        facts = self.document._entry("accessors", number)
        if facts.get("count") != count:
            raise InputError(f"{self.document.path}: accessor {number} moves another number of vertices than {count}")
        if "sparse" in facts and "bufferView" not in facts and not facts.get("normalized"):
            kind, width, _ = self._kind(facts, number)
            found = self._sparse(facts["sparse"], kind, width, count, number)
            if width == 3 and (np.diff(found[0]) > 0).all():
                self._count(found[1].size)
                values = found[1].astype(np.float32)
                if not np.isfinite(values).all():
                    raise InputError(f"{self.document.path}: accessor {number} has numbers that are not finite")
                kept = values.any(axis=1)
                return found[0][kept].astype(np.int32), values[kept]
        dense = self.read(number, 3)
        rows = np.flatnonzero(dense.any(axis=1))
        return rows.astype(np.int32), dense[rows].astype(np.float32)

    def indices(self, number: object, below: int) -> NDArray[np.int64]:
        """An accessor of indices, shape (count,), all of them below a count.

        Raises
        ------
        InputError
            As `read`, or if an index is too large.
        """
        values = self._raw(self.document._entry("accessors", number), number)
        if values.dtype.kind not in "iu" or values.shape[1] != 1:
            raise InputError(f"{self.document.path}: accessor {number} holds no indices")
        flat = values[:, 0].astype(np.int64)
        if len(flat) and (flat.max() >= below or flat.min() < 0):
            raise InputError(f"{self.document.path}: accessor {number} has index {flat.max()}, of {below} vertices")
        return flat

    def whole(self, number: object, width: int) -> NDArray[np.int64]:
        """An accessor of whole numbers as they are, shape (count, width)."""
        values = self._raw(self.document._entry("accessors", number), number)
        if values.shape[1] != width:
            raise InputError(f"{self.document.path}: accessor {number} has {values.shape[1]} columns, not {width}")
        return values.astype(np.int64)

    def stored(self, number: object) -> NDArray[Any]:
        """An accessor in the kind of numbers that the file has, shape (count, width)."""
        return self._raw(self.document._entry("accessors", number), number)

    def _raw(self, facts: dict[str, Any], number: object) -> NDArray[Any]:
        path = self.document.path
        kind, width, count = self._kind(facts, number)
        check_size("numbers", count * width, f"{path}, accessor {number}")
        self._count(count * width)
        if "bufferView" not in facts and "sparse" not in facts and isinstance(number, int) and number in self._draco:
            return self._draco[number]
        if "bufferView" not in facts and count > self._longest:
            raise InputError(
                f"{path}: accessor {number} has {count} elements and no bytes, others {self._longest} at most"
            )
        values = np.zeros((count if "bufferView" not in facts else 0, width), dtype=kind)
        if "bufferView" in facts and count:
            values = self._strided(facts["bufferView"], facts.get("byteOffset", 0), kind, width, count, number)
        if "sparse" in facts:
            values = values.copy()
            self._lay_over(values, facts["sparse"], kind, width, number)
        return values

    def _kind(self, facts: dict[str, Any], number: object) -> tuple[str, int, int]:
        """The kind of its numbers, how many stand in a row, and how many rows there are."""
        kind, width = _COMPONENTS.get(facts.get("componentType", 0)), _WIDTHS.get(facts.get("type", ""))
        count = facts.get("count")
        if kind is None or width is None or not isinstance(count, int) or isinstance(count, bool) or count < 0:
            raise InputError(f"{self.document.path}: accessor {number} has no known type and count")
        return kind, width, count

    def _count(self, numbers: int) -> None:
        """Refuse a file that says the same bytes over and over: together more numbers than it has bytes, and many."""
        self._decoded += numbers
        if self._decoded > len(self.document.binary or b"") + sum(map(len, self.document._read.values())):
            check_size("numbers", self._decoded, f"{self.document.path}, accessors together")

    def _strided(self, view: object, offset: object, kind: str, width: int, count: int, number: object) -> NDArray[Any]:
        data, size = self._view(view), np.dtype(kind).itemsize * width
        stride = self._stride(view, size)
        if not isinstance(offset, int) or offset < 0 or offset + (count - 1) * stride + size > len(data):
            raise InputError(f"{self.document.path}: accessor {number} lies outside its buffer view")
        rows = np.ndarray((count, size), dtype=np.uint8, buffer=data, offset=offset, strides=(stride, 1))
        return np.ascontiguousarray(rows).view(kind)

    def _stride(self, view: object, size: int) -> int:
        facts = self.document._entry("bufferViews", view)
        for name in _MESHOPT:
            facts = (facts.get("extensions") or {}).get(name, facts)
        stride = facts.get("byteStride", size)
        if not isinstance(stride, int) or not size <= stride <= 252 + size:
            raise InputError(f"{self.document.path}: buffer view {view} has a stride of {stride} for {size} bytes")
        return stride

    def _lay_over(self, values: NDArray[Any], sparse: Any, kind: str, width: int, number: object) -> None:
        rows, given = self._sparse(sparse, kind, width, len(values), number)
        values[rows] = given

    def _sparse(
        self, sparse: Any, kind: str, width: int, whole: int, number: object
    ) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """Rows of ``whole`` that a sparse accessor names, and their values."""
        path = self.document.path
        try:
            count, places, given = sparse["count"], sparse["indices"], sparse["values"]
            place_kind = _COMPONENTS[places["componentType"]]
        except (KeyError, TypeError) as problem:
            raise InputError(f"{path}: accessor {number} is sparse without indices and values") from problem
        if not isinstance(count, int) or not 0 <= count <= whole:
            raise InputError(f"{path}: accessor {number} says that {count} of {whole} elements are sparse")
        if not count:
            return np.zeros(0, np.int64), np.zeros((0, width), dtype=kind)
        rows = self._strided(places["bufferView"], places.get("byteOffset", 0), place_kind, 1, count, number)[:, 0]
        rows = rows.astype(np.int64)
        if rows.max() >= whole or rows.min() < 0:
            raise InputError(f"{path}: accessor {number} has a sparse index past its {whole} elements")
        return rows, self._strided(given["bufferView"], given.get("byteOffset", 0), kind, width, count, number)

    def _view(self, number: object) -> bytes:
        facts = self.document._entry("bufferViews", number)
        assert isinstance(number, int)
        packed = next((p for p in ((facts.get("extensions") or {}).get(name) for name in _MESHOPT) if p), None)
        if packed is None:
            return self.document.view(number)
        if number not in self._views:
            from mien.face.foreign.meshopt import decoded

            try:
                check_size("unpacked", packed["count"] * packed["byteStride"], f"{self.document.path}, view {number}")
                data = self.document.span(packed, f"compressed buffer view {number}")
                self._views[number] = decoded(
                    data, packed["mode"], packed["count"], packed["byteStride"], packed.get("filter", "NONE")
                )
            except (KeyError, TypeError, ValueError) as problem:
                told = f"{self.document.path}: buffer view {number} cannot be decoded as meshopt"
                raise InputError(f"{told}: {problem}") from problem
        return self._views[number]
