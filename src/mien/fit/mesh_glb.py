"""The meshes of a glTF file as one: where skins and nodes put them at rest, with their paint in one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.errors import InputError
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.gltf_document import GltfDocument, read_gltf
from mien.face.foreign.materials import Surface, SurfaceReader, srgb
from mien.face.foreign.primitives import in_one_tile, rest_matrices, triangles_of
from mien.face.foreign.rig_nodes import world_matrices
from mien.fit.head_parts import GivenMesh, Origin

__all__ = ["read_glb_mesh"]

Floats = NDArray[np.float64]

_READ = {
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "VRM",
    "VRMC_vrm",
}
_OF_PAINT = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "VRMC_materials_")  # of no effect on a mesh
_TILE, _MARGIN = 1024, 4  # pixels
_SURFACES = (4, 5, 6)  # triangles, strips, fans


def read_glb_mesh(path: Path) -> GivenMesh:
    """Read a file; meshes that several nodes show are taken once.

    Raises
    ------
    InputError
        If it cannot be read or has no triangles.
    """
    file = read_gltf(path)
    needed = {str(name) for name in file.json.get("extensionsRequired", []) if not str(name).startswith(_OF_PAINT)}
    if needed - _READ:
        raise InputError(f"{path}: it needs {', '.join(sorted(needed - _READ))}, not read here: export it without")
    reader, world = AccessorReader(file), world_matrices(file)
    surfaces = SurfaceReader(file)
    points: list[Floats] = []
    triangles: list[NDArray[np.int64]] = []
    colours: list[Floats] = []
    places: list[Floats] = []
    kinds: list[Surface] = []
    origins: list[Origin] = []
    first = 0
    for node in _shown(file):
        number = file.list_of("nodes")[node]["mesh"]
        for place, primitive in enumerate(file.list_of("meshes")[number]["primitives"]):
            if primitive.get("mode", 4) not in _SURFACES:
                continue
            own = reader.read(primitive["attributes"]["POSITION"], 3)
            matrices, _ = rest_matrices(reader, node, primitive["attributes"], len(own), world, {})
            linear = matrices[:, :3, :3]
            corners = triangles_of(primitive, len(own), reader)
            flipped = len(linear) == 1 and np.linalg.det(linear[0]) < 0
            surface = surfaces.surface(primitive.get("material"))
            points.append(np.einsum("nij,nj->ni", np.broadcast_to(linear, (len(own), 3, 3)), own) + matrices[:, :3, 3])
            triangles.append((corners[:, ::-1] if flipped else corners) + first)
            colours.append(_colours(reader, primitive["attributes"], len(own)))
            places.append(_coordinates(reader, primitive["attributes"], surface, corners, len(own)))
            kinds.append(surface)
            origins.append(Origin(number, place, first, len(own), linear, corners))
            first += len(own)
    if not points:
        raise InputError(f"{path}: it has no triangles")
    uv, texture, tint = _one_picture(kinds, places)
    colour = np.concatenate([own * one for own, one in zip(colours, tint, strict=True)])
    faces = np.concatenate(triangles).astype(np.int32)
    return GivenMesh(np.concatenate(points), faces, np.concatenate(uv), colour, texture, tuple(origins))


def _shown(file: GltfDocument) -> list[int]:
    """Nodes of the scene with a mesh, one for each mesh."""
    nodes, scenes = file.list_of("nodes"), file.list_of("scenes")
    number = file.json.get("scene", 0)
    roots = list(range(len(nodes)))
    if scenes:
        roots = scenes[number if isinstance(number, int) and 0 <= number < len(scenes) else 0].get("nodes", [])
    found: dict[int, int] = {}
    for root in roots:
        for node in file.below(root):
            if "mesh" in nodes[node]:
                found.setdefault(nodes[node]["mesh"], node)
    return list(found.values())


def _colours(reader: AccessorReader, attributes: dict[str, Any], count: int) -> Floats:
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    width = 4 if reader.document._entry("accessors", attributes["COLOR_0"]).get("type") == "VEC4" else 3
    return srgb(_for_each(reader.read(attributes["COLOR_0"], width), count)[:, :3])


def _coordinates(
    reader: AccessorReader, attributes: dict[str, Any], surface: Surface, corners: NDArray[np.int64], count: int
) -> Floats:
    name = f"TEXCOORD_{surface.coordinates}"
    if name not in attributes:
        return np.zeros((count, 2))
    uv = _for_each(reader.read(attributes[name], 2), count)
    if surface.transform is not None:
        uv = uv @ surface.transform[:, :2].T + surface.transform[:, 2]
    return in_one_tile(uv, corners)


def _for_each(rows: Floats, count: int) -> Floats:
    if len(rows) != count:
        raise ValueError(f"{len(rows)} rows for {count} points")
    return rows


def _one_picture(
    kinds: list[Surface], places: list[Floats]
) -> tuple[list[Floats], NDArray[np.uint8] | None, list[Floats]]:
    """Texture coordinates in one picture of all materials' pictures, that picture, and a colour for each primitive."""
    pictures: dict[int, NDArray[np.uint8]] = {}
    for kind in kinds:
        if kind.material.texture is not None:
            pictures.setdefault(id(kind), kind.material.texture)
    tint = [np.asarray(kind.material.colour) for kind in kinds]
    if not pictures:
        return places, None, tint
    if len(pictures) == 1 and all(id(kind) in pictures for kind in kinds):
        return places, next(iter(pictures.values())), tint
    side = int(np.ceil(np.sqrt(len(pictures) + 1)))
    sheet = np.full((side * _TILE, side * _TILE, 3), 255, np.uint8)  # the last tile stays white, for plain colours
    tiles = {key: divmod(i, side) for i, key in enumerate(pictures)}
    inner = _TILE - 2 * _MARGIN
    for key, picture in pictures.items():
        row, column = (_TILE * n for n in tiles[key])
        small = np.asarray(Image.fromarray(picture).resize((inner, inner), Image.Resampling.LANCZOS))
        sheet[row : row + _TILE, column : column + _TILE] = np.pad(
            small, ((_MARGIN,) * 2, (_MARGIN,) * 2, (0, 0)), "edge"
        )
    moved = []
    for kind, uv in zip(kinds, places, strict=True):
        row, column = tiles.get(id(kind), (side - 1, side - 1))
        inside = np.clip(uv, 0, 1) if id(kind) in tiles else np.full_like(uv, 0.5)
        moved.append((inside * inner + _MARGIN + np.array([column, row]) * _TILE) / (side * _TILE))
    return moved, sheet, tint
