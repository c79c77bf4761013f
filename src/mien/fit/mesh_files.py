"""Bare meshes out of OBJ, PLY and GLB files.

OBJ: `mien.face.obj.read_obj`, with the picture that its material names; where a picture is used, vertices are split
at the seams of their texture places (copies stand behind all others, so numbers stay those of the file). PLY: ASCII
and binary, any number of corners, colours of vertices. GLB: all meshes of the default scene where their nodes put
them, at rest (no skinning, no morph targets); the base colour texture if all share one material.
"""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from mien.core.errors import InputError
from mien.face.obj import read_obj
from mien.fit.head_parts import GivenMesh

__all__ = ["read_mesh", "read_picture"]

Floats = NDArray[np.float64]

_PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_GL_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_GL_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def read_picture(path: str | Path) -> NDArray[np.uint8]:
    """A picture as sRGB bytes (height, width, 3), turned upright by its EXIF orientation.

    Raises
    ------
    InputError
        If it is missing or no picture.
    """
    from PIL import ImageOps

    try:
        with Image.open(path) as picture:
            return np.asarray(ImageOps.exif_transpose(picture).convert("RGB"))
    except (OSError, UnidentifiedImageError, ValueError, Image.DecompressionBombError) as problem:
        raise InputError(f"{path}: cannot be read as a picture ({problem})") from problem


def read_mesh(path: str | Path, texture: str | Path | None = None) -> GivenMesh:
    """Read a mesh by its suffix, with a picture for its surface if one is given.

    Raises
    ------
    InputError
        If the file is missing, damaged, of another kind, or has no faces.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        mesh, texture = _read_obj(path, texture)
    elif suffix == ".ply":
        mesh = _read_ply(path)
    elif suffix in (".glb", ".vrm"):
        mesh = _read_glb(path)
    else:
        raise InputError(f"{path}: a head is read from .obj, .ply or .glb, not from {suffix or 'no suffix'!r}")
    if not len(mesh.triangles):
        raise InputError(f"{path} has no faces: a head's surface is needed, not points or lines")
    if texture is None:
        return mesh
    if not mesh.uv.any():
        raise InputError(f"{path} has no texture places for the picture {texture}")
    return GivenMesh(mesh.vertices, mesh.triangles, mesh.uv, mesh.colours, read_picture(texture))


def _read_obj(path: Path, texture: str | Path | None) -> tuple[GivenMesh, str | Path | None]:
    """An OBJ file; the picture that its material names, unless one is given or there are several."""
    read = read_obj(path)
    mesh = GivenMesh(read.vertices, read.triangles, read.uv, read.colours)
    texture = texture if texture is not None else _picture_of_material(path)
    return (mesh, None) if texture is None else (_split_at_seams(path, mesh), texture)


def _lines(path: Path, *kinds: str) -> list[list[str]]:
    """The fields of an OBJ or MTL file's lines of some kinds; a file that cannot be read has none."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    except OSError:
        return []
    rows = (line.split("#", 1)[0].split() for line in text.splitlines())
    return [row for row in rows if row and row[0] in kinds]


def _picture_of_material(path: Path) -> Path | None:
    """The one picture (``map_Kd``) that the materials of an OBJ file name, if it lies beside it."""
    found = set()
    for row in _lines(path, "mtllib"):
        for material in _lines(path.parent / " ".join(row[1:]), "map_Kd"):
            picture = path.parent / material[-1].replace("\\", "/")
            if picture.is_file():
                found.add(picture)
    return found.pop() if len(found) == 1 else None


def _split_at_seams(path: Path, mesh: GivenMesh) -> GivenMesh:
    """Give vertices with several texture places a copy for each further one, behind all others."""
    rows = _lines(path, "v", "vt", "f")
    places = [[float(row[1]), 1.0 - float(row[2]) if len(row) > 2 else 1.0] for row in rows if row[0] == "vt"]
    if not places:
        return mesh
    corners: list[tuple[int, int]] = []
    points = seen = 0
    for row in rows:
        points, seen = points + (row[0] == "v"), seen + (row[0] == "vt")
        if row[0] == "f":
            own = [_numbers_of(field, points, seen) for field in row[1:]]
            corners += [own[k] for i in range(1, len(own) - 1) for k in (0, i, i + 1)]
    pairs = np.array(corners)
    kinds, first, which = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    number = np.full(len(kinds), -1)
    taken: set[int] = set()
    copies: list[int] = []
    for kind in np.argsort(first, kind="stable"):  # in the order of the file: a vertex keeps its first place
        vertex = int(kinds[kind, 0])
        if vertex in taken:
            number[kind] = len(mesh.vertices) + len(copies)
            copies.append(int(kind))
        else:
            taken.add(vertex)
            number[kind] = vertex
    source = kinds[copies, 0] if copies else np.zeros(0, dtype=np.int64)
    at = np.where(kinds[copies, 1] >= 0, kinds[copies, 1], 0) if copies else source
    return GivenMesh(
        np.concatenate([mesh.vertices, mesh.vertices[source]]),
        number[which.ravel()].reshape(-1, 3).astype(np.int32),
        np.concatenate([mesh.uv, np.array(places)[at]]),
        np.concatenate([mesh.colours, mesh.colours[source]]),
    )


def _numbers_of(field: str, points: int, places: int) -> tuple[int, int]:
    """Numbers from 0 of a corner's vertex and its texture place (-1: none)."""
    parts = field.split("/")
    vertex = int(parts[0])
    place = int(parts[1]) if len(parts) > 1 and parts[1] else 0
    return (vertex - 1 if vertex > 0 else points + vertex), (
        place - 1 if place > 0 else places + place if place else -1
    )


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem


# ------------------------------------------------------------------ PLY


def _read_ply(path: Path) -> GivenMesh:
    data = _bytes(path)
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{path} is no PLY file: it does not start with 'ply' and a header")
    header = data[:end].decode("ascii", errors="replace").split("\n")
    body = data[data.index(b"\n", end) + 1 :]
    try:
        kind, elements = _ply_header(header)
        rows = _ply_ascii(body, elements) if kind == "ascii" else _ply_binary(body, elements, kind)
        return _ply_mesh(rows)
    except (ValueError, KeyError, IndexError, struct.error) as problem:
        raise InputError(f"{path}: damaged PLY file ({problem})") from problem


def _ply_header(lines: list[str]) -> tuple[str, list[dict[str, Any]]]:
    kind = ""
    elements: list[dict[str, Any]] = []
    for line in lines[1:]:
        word, *fields = line.split() or [""]
        if word == "format":
            kind = fields[0]
        elif word == "element":
            elements.append({"name": fields[0], "count": int(fields[1]), "fields": []})
        elif word == "property":
            elements[-1]["fields"].append(fields)
    if kind not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"format {kind!r}")
    return kind, elements


def _ply_ascii(body: bytes, elements: list[dict[str, Any]]) -> dict[str, Any]:
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


def _ply_binary(body: bytes, elements: list[dict[str, Any]], kind: str) -> dict[str, Any]:
    order = "<" if "little" in kind else ">"
    rows: dict[str, Any] = {}
    at = 0
    for element in elements:
        fields, count = element["fields"], element["count"]
        if not any(field[0] == "list" for field in fields):
            dtype = np.dtype([(field[-1], order + _PLY_TYPES[field[0]]) for field in fields])
            table = np.frombuffer(body, dtype, count, at)
            at += dtype.itemsize * count
            if element["name"] == "vertex":
                rows["vertex"] = {f[-1]: (table[f[-1]].astype(np.float64), f[0]) for f in fields}
            continue
        whole = _ply_triangles(body, fields, count, at, order)
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


def _ply_triangles(body: bytes, fields: list[list[str]], count: int, at: int, order: str) -> NDArray[Any] | None:
    """Faces that are triangles all, read at once; None where they are not, or have further fields."""
    if len(fields) != 1 or _PLY_TYPES[fields[0][1]] != "u1" or _PLY_TYPES[fields[0][2]] not in ("i4", "u4"):
        return None
    dtype = np.dtype([("count", "u1"), ("corners", order + "i4", 3)])
    if at + count * dtype.itemsize > len(body):
        return None
    table = np.frombuffer(body, dtype, count, at)
    return np.asarray(table["corners"]) if bool((table["count"] == 3).all()) else None


def _ply_mesh(rows: dict[str, Any]) -> GivenMesh:
    table = rows["vertex"]
    vertices = np.stack([table[axis][0] for axis in "xyz"], axis=1)
    given = rows.get("face", [])
    if isinstance(given, list):
        given = [(f[0], f[i], f[i + 1]) for f in given for i in range(1, len(f) - 1)]
    faces = np.array(given, dtype=np.int64).reshape(-1, 3)
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise ValueError(f"a face names a vertex beyond the {len(vertices)} there are")
    if not np.isfinite(vertices).all():
        raise ValueError("a coordinate is not finite")
    colours = np.ones_like(vertices)
    if {"red", "green", "blue"} <= set(table):
        whole = 1.0 if table["red"][1].startswith(("f", "d")) else 255.0
        colours = np.clip(np.stack([table[c][0] for c in ("red", "green", "blue")], axis=1) / whole, 0, 1)
    return GivenMesh(vertices, faces.astype(np.int32), np.zeros((len(vertices), 2)), colours)


# ------------------------------------------------------------------ GLB


def _read_glb(path: Path) -> GivenMesh:
    data = _bytes(path)
    try:
        return _glb_mesh(data)
    except (ValueError, KeyError, IndexError, TypeError, struct.error, OSError) as problem:
        raise InputError(f"{path}: no GLB that can be read, or damaged ({problem})") from problem


def _glb_mesh(data: bytes) -> GivenMesh:
    magic, version, _ = struct.unpack_from("<4sII", data)
    if magic != b"glTF" or version != 2:
        raise ValueError("it does not start as glTF 2 does")
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    start = 20 + size + 8
    buffer = data[start:]
    needed = set(document.get("extensionsRequired", [])) - {"KHR_texture_transform", "KHR_mesh_quantization"}
    if needed:
        raise ValueError(f"it needs {', '.join(sorted(needed))}, which is not read here: export it without")
    pieces: list[tuple[Floats, Floats, Floats, NDArray[np.int64]]] = []
    materials: list[int | None] = []
    nodes = document.get("nodes", [])
    roots = document["scenes"][document.get("scene", 0)]["nodes"] if document.get("scenes") else range(len(nodes))
    stack = [(int(root), np.eye(4)) for root in roots]
    seen = 0
    while stack:
        number, parent = stack.pop()
        seen += 1
        if seen > len(nodes):
            raise ValueError("its nodes make a loop")
        node = nodes[number]
        place = parent @ _local(node)
        stack += [(int(child), place) for child in node.get("children", [])]
        if "mesh" in node:
            skinned = np.eye(4) if "skin" in node else place
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                if primitive.get("mode", 4) == 4:
                    pieces.append(_primitive(document, buffer, primitive, skinned))
                    materials.append(primitive.get("material"))
    if not pieces:
        raise ValueError("it has no triangles")
    return _joined(document, buffer, pieces, materials)


def _joined(
    document: dict[str, Any],
    buffer: bytes,
    pieces: list[tuple[Floats, Floats, Floats, NDArray[np.int64]]],
    materials: list[int | None],
) -> GivenMesh:
    starts = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
    textures = {m: _texture(document, buffer, m) for m in dict.fromkeys(materials)}
    largest = max(range(len(pieces)), key=lambda i: len(pieces[i][3]))
    triangles = np.concatenate([piece[3] + start for piece, start in zip(pieces, starts, strict=False)])
    return GivenMesh(
        np.concatenate([piece[0] for piece in pieces]),
        triangles.astype(np.int32),
        np.concatenate([piece[1] for piece in pieces]),
        np.concatenate([piece[2] for piece in pieces]),
        textures[materials[largest]] if len(set(materials)) == 1 else None,
    )


def _local(node: dict[str, Any]) -> Floats:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    from scipy.spatial.transform import Rotation

    place = np.eye(4)
    turn = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
    place[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    place[:3, 3] = node.get("translation", [0, 0, 0])
    return place


def _accessor(document: dict[str, Any], buffer: bytes, number: int) -> NDArray[Any]:
    accessor = document["accessors"][number]
    dtype, width, count = _GL_TYPES[accessor["componentType"]], _GL_WIDTHS[accessor["type"]], accessor["count"]
    values = np.zeros((count, width), dtype=dtype)
    if "bufferView" in accessor:
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        row = np.dtype(dtype).itemsize * width
        step = view.get("byteStride", row)
        raw = np.frombuffer(buffer, np.uint8, (count - 1) * step + row, start) if count else np.zeros(0, np.uint8)
        rows = np.lib.stride_tricks.as_strided(raw, (count, row), (step, 1))
        values = np.ascontiguousarray(rows).view(dtype).reshape(count, width)
    if accessor.get("normalized"):
        values = values / float(np.iinfo(values.dtype).max)
    return values


def _primitive(
    document: dict[str, Any], buffer: bytes, primitive: dict[str, Any], place: Floats
) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
    attributes = primitive["attributes"]
    points = _accessor(document, buffer, attributes["POSITION"]).astype(np.float64)
    if not np.isfinite(points).all():
        raise ValueError("a coordinate is not finite")
    points = points @ place[:3, :3].T + place[:3, 3]
    uv, colours = np.zeros((len(points), 2)), np.ones((len(points), 3))
    if "TEXCOORD_0" in attributes:
        uv = _accessor(document, buffer, attributes["TEXCOORD_0"]).astype(np.float64)
    if "COLOR_0" in attributes:
        linear = np.clip(_accessor(document, buffer, attributes["COLOR_0"])[:, :3].astype(np.float64), 0, 1)
        colours = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    if "indices" in primitive:
        index = _accessor(document, buffer, primitive["indices"]).astype(np.int64).reshape(-1, 3)
    else:
        index = np.arange(len(points) // 3 * 3).reshape(-1, 3)
    if index.size and not 0 <= index.min() <= index.max() < len(points):
        raise ValueError(f"a face names a vertex beyond the {len(points)} there are")
    if np.linalg.det(place[:3, :3]) < 0:
        index = index[:, ::-1]
    return points, uv, colours, index


def _texture(document: dict[str, Any], buffer: bytes, material: int | None) -> NDArray[np.uint8] | None:
    if material is None:
        return None
    surface = document["materials"][material].get("pbrMetallicRoughness", {})
    if "baseColorTexture" not in surface:
        return None
    image = document["images"][document["textures"][surface["baseColorTexture"]["index"]]["source"]]
    if "bufferView" not in image:
        return None
    view = document["bufferViews"][image["bufferView"]]
    start = view.get("byteOffset", 0)
    return np.asarray(Image.open(io.BytesIO(buffer[start : start + view["byteLength"]])).convert("RGB"))
