"""PLY files as their rows: vertices with all their properties, and faces (ascii, or binary of either byte order)."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import check_begun, check_size, read_bytes

__all__ = ["read_ply_rows"]

_PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip


def read_ply_rows(path: Path) -> dict[str, Any]:
    """The rows of a PLY file.

    Returns
    -------
    dict
        ``"vertex"``: for each property its column and its type; ``"face"``: corners of each face.

    Raises
    ------
    InputError
        If it is not a PLY file, or damaged.
    """
    check_begun(path)
    data = read_bytes(path, "mesh")
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{path} is not a PLY file: it does not start with 'ply' and a header")
    header = data[:end].decode("ascii", errors="replace").split("\n")
    body = data[data.index(b"\n", end) + 1 :]
    try:
        kind, elements = _header(header)
        return _ascii(body, elements) if kind == "ascii" else _binary(body, elements, kind)
    except (ValueError, KeyError, IndexError, struct.error) as problem:
        raise InputError(f"{path}: damaged PLY file ({problem})") from problem


def _header(lines: list[str]) -> tuple[str, list[dict[str, Any]]]:
    kind = ""
    elements: list[dict[str, Any]] = []
    for line in lines[1:]:
        word, *fields = line.split() or [""]
        if word == "format":
            kind = fields[0]
        elif word == "element":
            elements.append({"name": fields[0], "count": _count(fields[1]), "fields": []})
        elif word == "property":
            elements[-1]["fields"].append(fields)
    if kind not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"format {kind!r}")
    return kind, elements


def _count(text: str) -> int:
    """How many rows an element has."""
    count = int(text)
    if count < 0:
        raise ValueError(f"{count} rows")
    check_size("rows", count, "an element")
    return count


def _ascii(body: bytes, elements: list[dict[str, Any]]) -> dict[str, Any]:
    lines = body.decode("ascii", errors="replace").splitlines()
    rows: dict[str, Any] = {}
    first = 0
    for element in elements:
        some = [line.split() for line in lines[first : first + element["count"]]]
        first += element["count"]
        if len(some) < element["count"]:
            raise ValueError(f"{element['name']}: {len(some)} rows of {element['count']}")
        if element["name"] == "face":
            rows["face"] = [[int(c) for c in row[1 : 1 + int(row[0])]] for row in some]
        elif element["name"] == "vertex":
            table = np.array(some, dtype=np.float64)
            rows["vertex"] = {f[-1]: (table[:, i], f[0]) for i, f in enumerate(element["fields"])}
    return rows


def _binary(body: bytes, elements: list[dict[str, Any]], kind: str) -> dict[str, Any]:
    order = "<" if "little" in kind else ">"
    rows: dict[str, Any] = {}
    at = 0
    for element in elements:
        fields, count = element["fields"], element["count"]
        if not fields:
            raise ValueError(f"{element['name']} has no properties")
        if not any(field[0] == "list" for field in fields):
            dtype = np.dtype([(field[-1], order + _PLY_TYPES[field[0]]) for field in fields])
            table = np.frombuffer(body, dtype, count, at)
            at += dtype.itemsize * count
            if element["name"] == "vertex":
                rows["vertex"] = {f[-1]: (table[f[-1]].astype(np.float64), f[0]) for f in fields}
            continue
        whole = _triangles(body, fields, count, at, order)
        if whole is not None:
            rows["face"], at = whole, at + count * (1 + 12)
            continue
        faces = []
        for _ in range(count):
            for field in fields:
                if field[0] != "list":
                    at += np.dtype(_PLY_TYPES[field[0]]).itemsize
                    continue
                number = int(np.frombuffer(body, order + _PLY_TYPES[field[1]], 1, at)[0])
                at += np.dtype(_PLY_TYPES[field[1]]).itemsize
                values = np.frombuffer(body, order + _PLY_TYPES[field[2]], number, at)
                at += values.nbytes
                if field[3] in ("vertex_indices", "vertex_index"):
                    faces.append(values.tolist())
        if element["name"] == "face":
            rows["face"] = faces
    return rows


def _triangles(body: bytes, fields: list[list[str]], count: int, at: int, order: str) -> NDArray[Any] | None:
    """Faces that are triangles all, read at once; None where they are not, or have further fields."""
    if len(fields) != 1 or _PLY_TYPES[fields[0][1]] != "u1" or _PLY_TYPES[fields[0][2]] not in ("i4", "u4"):
        return None
    dtype = np.dtype([("count", "u1"), ("corners", order + "i4", 3)])
    if at + count * dtype.itemsize > len(body):
        return None
    table = np.frombuffer(body, dtype, count, at)
    return np.asarray(table["corners"]) if bool((table["count"] == 3).all()) else None
