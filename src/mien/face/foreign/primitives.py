"""Triangles of a foreign face as they stand at rest in the world: skin, node and rest weights applied."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.materials import Surface, SurfaceReader, srgb
from mien.face.foreign.recognition import ForeignFace
from mien.face.foreign.rig_names import name_tables, spelling
from mien.face.posing import head_rotation

__all__ = ["Piece", "in_one_tile", "pieces_of_node", "rest_matrices", "triangles_of"]

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Moved = NDArray[np.integer[Any]]
Moves = NDArray[np.floating[Any]]
_STRIP, _FAN, _TRIANGLES = 5, 6, 4


@dataclass(frozen=True)
class Piece:
    """One mesh to draw, in the file's axes.

    Attributes
    ----------
    name : str
    surface : Surface
    vertices : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (t, 3)
    uv, colours : ndarray, shapes (n, 2) and (n, 3)
    head_weight : ndarray, shape (n,)
        How much a vertex goes with the head's node, 0..1.
    eye : str
        "Left" or "Right" where the whole piece turns with that eye's node; else "".
    targets : mapping of str to (rows, offsets)
        What each driven target moves at weight 1; shapes (k,) and (k, 3).
    origin : tuple of int
        Numbers of its mesh in the file and of its primitive in that.
    """

    name: str
    surface: Surface
    vertices: Floats
    triangles: Rows
    uv: Floats
    colours: Floats
    head_weight: Floats
    eye: str = ""
    targets: Mapping[str, tuple[Moved, Moves]] = field(default_factory=dict)
    origin: tuple[int, int] = (0, 0)


def pieces_of_node(
    foreign: ForeignFace, node: int, world: Floats, reader: AccessorReader, surfaces: SurfaceReader
) -> list[Piece]:
    """The pieces that a node's mesh is drawn as.

    Parameters
    ----------
    foreign : ForeignFace
    node : int
    world : ndarray, shape (nodes, 4, 4)
    reader : AccessorReader
    surfaces : SurfaceReader

    Raises
    ------
    InputError
        If the mesh does not hold together.
    """
    document = foreign.document
    facts = document.list_of("nodes")[node]
    mesh = document.list_of("meshes")[facts["mesh"]]
    pieces: list[Piece] = []
    for number, primitive in enumerate(mesh["primitives"]):
        if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
            continue  # points and lines
        surface = surfaces.surface(primitive.get("material"))
        if surface.hidden or "POSITION" not in primitive.get("attributes", {}):
            continue
        name = str(mesh.get("name") or facts.get("name") or f"mesh {facts['mesh']}")
        told = spelling(f"{name} {facts.get('name', '')} {surface.material.name}")
        if any(word in told for word in name_tables()["not_drawn"]):
            continue
        some = _split_eyes(*_piece(foreign, node, primitive, world, reader, surface, name))
        pieces += [replace(piece, origin=(facts["mesh"], number)) for piece in some]
    return pieces


def _piece(
    foreign: ForeignFace,
    node: int,
    primitive: Mapping[str, Any],
    world: Floats,
    reader: AccessorReader,
    surface: Surface,
    name: str,
) -> tuple[Piece, NDArray[np.int8]]:
    """One primitive, and with which eye each vertex turns (0 none, 1 left, 2 right)."""
    attributes = primitive["attributes"]
    points = reader.read(attributes["POSITION"], 3)
    matrices, share = _skinning(foreign, node, attributes, len(points), world, reader)
    targets = _targets(foreign, node, primitive, points, reader)  # lays rest weights into the points
    linear = matrices[:, :3, :3]
    moved = {key: (rows, _turned(linear, rows, offsets)) for key, (rows, offsets) in targets.items()}
    vertices = _turned(linear, np.arange(len(points)), points) + (
        matrices[:, :3, 3] if len(matrices) > 1 else matrices[0, :3, 3]
    )
    if foreign.jaw_turns:
        pivot = world[foreign.turning.nodes["jaw"]][:3, 3]
        moved |= _by_jaw(vertices, share["jaw"], pivot, foreign.turning.facing)
    triangles = triangles_of(primitive, len(points), reader)
    if len(matrices) == 1 and np.linalg.det(linear[0]) < 0:
        triangles = triangles[:, ::-1]
    uv, triangles = _coordinates(attributes, surface, triangles, len(points), reader)
    piece = Piece(
        name, surface, vertices, triangles, uv, _colours(attributes, reader, len(points)), share["head"], "", moved
    )
    eyes = np.where(share["eyeLeft"] > 0.5, 1, np.where(share["eyeRight"] > 0.5, 2, 0)).astype(np.int8)
    return piece, eyes


def _by_jaw(vertices: Floats, share: Floats, pivot: Floats, facing: int) -> dict[str, tuple[Rows, Floats]]:
    """How a jaw bone moves the vertices: the chord of its turn, as a target for each of its channels."""
    degrees = name_tables()["jaw"]
    rows = np.flatnonzero(share > 1e-3)
    arm, found = vertices[rows] - pivot, {}
    flip = np.diag([float(facing), 1.0, float(facing)])
    turns = {"jawOpen": (0.0, -degrees["Open"]), "jawLeft": (degrees["Side"], 0.0), "jawRight": (-degrees["Side"], 0.0)}
    for channel, (yaw, pitch) in turns.items():
        turn = flip @ head_rotation(yaw, pitch, 0.0) @ flip
        found[f"jaw/{channel}"] = (rows, share[rows, None] * (arm @ turn.T - arm))
    return found if len(rows) else {}


def _turned(linear: Floats, rows: Moved, offsets: Moves) -> Floats:
    if len(linear) == 1:
        return np.asarray(offsets @ linear[0].T)
    return np.asarray(np.einsum("nij,nj->ni", linear[rows], offsets))


def _skinning(
    foreign: ForeignFace, node: int, attributes: Mapping[str, Any], count: int, world: Floats, reader: AccessorReader
) -> tuple[Floats, dict[str, Floats]]:
    """Matrices from the mesh to the world, shape (1 or count, 4, 4); how much each vertex goes with head and eyes."""
    document, turning = foreign.document, foreign.turning.nodes
    under = {
        part: set(document.below(turning[part])) if part in turning else set()
        for part in ("head", "eyeLeft", "eyeRight", "jaw")
    }
    return rest_matrices(reader, node, attributes, count, world, under)


def rest_matrices(
    reader: AccessorReader,
    node: int,
    attributes: Mapping[str, Any],
    count: int,
    world: Floats,
    under: Mapping[str, set[int]],
) -> tuple[Floats, dict[str, Floats]]:
    """How a primitive's vertices stand in the world at rest.

    Parameters
    ----------
    reader : AccessorReader
    node : int
        That shows the mesh.
    attributes : mapping
        Of the primitive.
    count : int
        Of its vertices.
    world : ndarray, shape (nodes, 4, 4)
    under : mapping of str to set of int
        Nodes by part of the body.

    Returns
    -------
    matrices : ndarray, shape (1 or count, 4, 4)
    shares : dict of str to ndarray of shape (count,)
        How much each vertex goes with the nodes of each part.
    """
    document = reader.document
    facts = document.list_of("nodes")[node]
    if "skin" not in facts or "JOINTS_0" not in attributes:
        return world[node][None], {part: np.full(count, float(node in nodes)) for part, nodes in under.items()}
    skin = document.list_of("skins")[facts["skin"]]
    joints = [int(joint) for joint in skin["joints"]]
    inverse = np.tile(np.eye(4), (len(joints), 1, 1))
    if "inverseBindMatrices" in skin:
        inverse = reader.read(skin["inverseBindMatrices"], 16)[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    if len(inverse) < len(joints) or (joints and not 0 <= min(joints) <= max(joints) < len(world)):
        raise InputError(f"{document.path}: skin {facts['skin']} does not hold together")
    to_world = world[joints] @ inverse
    matrices = np.zeros((count, 4, 4))
    share = {part: np.zeros(count) for part in under}
    total = np.zeros(count)
    belongs = {part: np.array([joint in nodes for joint in joints], dtype=float) for part, nodes in under.items()}
    for number in range(2):
        if f"JOINTS_{number}" not in attributes or f"WEIGHTS_{number}" not in attributes:
            continue
        which = np.minimum(reader.whole(attributes[f"JOINTS_{number}"], 4), len(joints) - 1)
        weights = reader.read(attributes[f"WEIGHTS_{number}"], 4)
        if len(which) != count or len(weights) != count:
            raise InputError(f"{document.path}: joints and vertices of a mesh differ in number")
        for column in range(4):
            matrices += weights[:, column, None, None] * to_world[which[:, column]]
            total += weights[:, column]
            for part in share:
                share[part] += weights[:, column] * belongs[part][which[:, column]]
    held = total > 1e-6
    matrices[held] /= total[held, None, None]
    matrices[~held] = to_world[0] if len(to_world) else np.eye(4)
    return matrices, {part: np.clip(values / np.maximum(total, 1e-6), 0.0, 1.0) for part, values in share.items()}


def _targets(
    foreign: ForeignFace, node: int, primitive: Mapping[str, Any], points: Floats, reader: AccessorReader
) -> dict[str, tuple[Moved, Moves]]:
    """Offsets of the driven targets; rest weights of the others are added to ``points``."""
    facts = foreign.document.list_of("nodes")[node]
    mesh = foreign.meshes[facts["mesh"]]
    rest = facts.get("weights") or foreign.document.list_of("meshes")[facts["mesh"]].get("weights") or []
    found: dict[str, tuple[Moved, Moves]] = {}
    for place, (target, given) in enumerate(zip(mesh.targets, primitive.get("targets", []), strict=True)):
        resting = float(rest[place]) if place < len(rest) else 0.0
        if "POSITION" not in given or not (target.drives or resting):
            continue
        rows, offsets = reader.offsets(given["POSITION"], len(points))
        if target.drives:
            found[f"{mesh.number}/{place}"] = (rows, offsets)
        else:
            points[rows] += resting * offsets
    return found


def triangles_of(primitive: Mapping[str, Any], count: int, reader: AccessorReader) -> Rows:
    """Triangles of a list, strip or fan, shape (t, 3)."""
    index = reader.indices(primitive["indices"], count) if "indices" in primitive else np.arange(count)
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]], axis=1)
    strip = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    strip[1::2] = strip[1::2, ::-1]
    return strip


def _coordinates(
    attributes: Mapping[str, Any], surface: Surface, triangles: Rows, count: int, reader: AccessorReader
) -> tuple[Floats, Rows]:
    """Texture coordinates in 0..1, and the triangles of which anything is seen."""
    name = f"TEXCOORD_{surface.coordinates}"
    if surface.material.texture is None or name not in attributes:
        return np.zeros((count, 2)), triangles
    uv = reader.read(attributes[name], 2)
    if len(uv) != count:
        raise InputError(f"{reader.document.path}: texture coordinates and vertices of a mesh differ in number")
    if surface.transform is not None:
        uv = uv @ surface.transform[:, :2].T + surface.transform[:, 2]
    uv = in_one_tile(uv, triangles)
    picture = surface.material.texture
    if picture is not None and picture.shape[2] == 4 and len(triangles):
        tall, wide = picture.shape[:2]
        corners = uv[triangles]
        middle = corners.mean(axis=1)
        seen = np.zeros(len(triangles), dtype=bool)
        for sample in (middle, *(step * middle + (1 - step) * corners[:, k] for k in range(3) for step in (0.5, 0.1))):
            x = np.clip((sample[:, 0] % 1.0) * wide, 0, wide - 1).astype(int)
            y = np.clip((sample[:, 1] % 1.0) * tall, 0, tall - 1).astype(int)
            seen |= picture[y, x, 3] > 0
        triangles = triangles[seen]
    return uv, triangles


def in_one_tile(uv: Floats, triangles: Rows) -> Floats:
    """Islands that lie in other tiles of a repeating picture, moved into the first."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(triangles) or (uv.min() >= -1e-3 and uv.max() <= 1.001):
        return np.clip(uv, 0.0, 1.0)
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    edges = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(uv), len(uv)))
    number, island = connected_components(edges, directed=False)
    size = np.maximum(np.bincount(island, minlength=number), 1)
    middle = np.column_stack([np.bincount(island, uv[:, k], number) / size for k in range(2)])
    return np.asarray(uv - np.floor(middle)[island])


def _colours(attributes: Mapping[str, Any], reader: AccessorReader, count: int) -> Floats:
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    facts = reader.document._entry("accessors", attributes["COLOR_0"])
    values = reader.read(attributes["COLOR_0"], 4 if facts.get("type") == "VEC4" else 3)
    return srgb(values[:, :3]) if len(values) == count else np.ones((count, 3))


def _split_eyes(piece: Piece, eyes: NDArray[np.int8]) -> list[Piece]:
    """The piece, with triangles that turn with an eye in pieces of their own."""
    if not eyes.any():
        return [_only(piece, piece.triangles, "")] if len(piece.triangles) else []
    which = eyes[piece.triangles]
    whole = np.where((which == which[:, :1]).all(axis=1), which[:, 0], 0)
    chosen = [(piece.triangles[whole == kind], side) for kind, side in ((0, ""), (1, "Left"), (2, "Right"))]
    return [_only(piece, triangles, side) for triangles, side in chosen if len(triangles)]


def _only(piece: Piece, triangles: Rows, eye: str) -> Piece:
    """Some triangles of a piece, and the vertices that they need."""
    used = np.unique(triangles)
    place = np.full(len(piece.vertices), -1)
    place[used] = np.arange(len(used))
    targets = {}
    for name, (rows, offsets) in piece.targets.items():
        kept = place[rows] >= 0
        targets[name] = (place[rows[kept]], offsets[kept])
    head = np.ones(len(used)) if eye else piece.head_weight[used]
    return Piece(
        piece.name + (f" {eye.lower()}" if eye else ""), piece.surface, piece.vertices[used], place[triangles],
        piece.uv[used], piece.colours[used], head, eye, targets,
    )  # fmt: skip
