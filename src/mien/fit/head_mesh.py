"""A bare head mesh made ready: pieces told apart, vertices that lie and face together joined, winding outward.

Nothing of the given mesh is changed but where this is said in a note: its vertices keep their numbers (up to those that
are cut away with what lies too far from the head).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mien.core.errors import InputError, Note
from mien.face.surface import coded_sides, vertex_normals
from mien.face.warps import Similarity
from mien.fit.piece_kinds import Piece, kinds_of_pieces

__all__ = ["HeadMesh", "outward", "prepared_mesh"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

FARTHEST_MM = 320.0  # from the origin: what a face file can hold
_OPPOSED = -0.5
_IN_MOUTH = ("upper", "lower", "tongue")
_ROUND_MM, _ROUND_SAMPLES = 6.0, 2000  # about how thick teeth and tongue are


@dataclass(frozen=True, eq=False)
class HeadMesh:
    """A head in millimetres, in the face's axes.

    Attributes
    ----------
    vertices : ndarray, shape (n, 3)
    triangles : ndarray of int32, shape (t, 3)
    welded : ndarray of int32, shape (n,)
        The vertex that stands for all that lie and face together.
    pieces : tuple of Piece
    kept : ndarray of int64
        Number in the file of each vertex.
    notes : tuple of Note
    """

    vertices: Floats
    triangles: Indices
    welded: Indices
    pieces: tuple[Piece, ...]
    kept: NDArray[np.int64]
    notes: tuple[Note, ...]

    def of(self, *kinds: str) -> NDArray[np.bool_]:
        """Which triangles belong to pieces of these kinds."""
        chosen = np.zeros(len(self.triangles), dtype=np.bool_)
        for piece in self.pieces:
            if piece.kind in kinds:
                chosen[piece.triangles] = True
        return chosen


def prepared_mesh(
    vertices: Floats,
    triangles: Indices,
    to_face: Similarity,
    template: Floats,
    template_triangles: Indices,
    eyes: Mapping[str, Floats],
    places: Mapping[str, Floats],
    given: Mapping[str, Floats],
    where: str,
) -> HeadMesh:
    """Prepare a mesh as read.

    Parameters
    ----------
    vertices, triangles : ndarray
        In the file's coordinates.
    to_face : Similarity
    template : ndarray, shape (m, 3)
        The default skin laid on the head, mm; with its triangles: tells inside from outside.
    eyes : mapping of "Left", "Right" to ndarray of shape (3,)
        About where the eyeballs' centres are, mm.
    places : mapping of str to ndarray of shape (3,)
        Landmarks, mm; ``given``: those that someone set, and that must lie on the mesh.
    where : str
        Names the file in errors.

    Raises
    ------
    InputError
        If the mesh has no triangles, or the landmarks do not lie on it.
    """
    notes: list[Note] = []
    points = to_face(vertices)
    triangles = _sound(points, triangles, notes, where)
    points, triangles, kept = _near(points, triangles, notes)
    if given:
        _check_landmarks_on_mesh(points, triangles, given, where)
    welded = _welded(points, triangles)
    label = _components(triangles, welded)
    pieces = kinds_of_pieces(points, triangles, label, eyes, places)
    round_ones = np.isin(label, [label[piece.triangles[0]] for piece in pieces if piece.kind in _IN_MOUTH])
    triangles = _wound_outward(points, triangles, welded, label, round_ones, template, template_triangles, notes)
    if not any(piece.kind == "skin" for piece in pieces):
        raise InputError(f"{where}: no piece of the mesh carries the landmarks of the face")
    return HeadMesh(points, triangles, welded, pieces, kept, tuple(notes))


def _sound(points: Floats, triangles: Indices, notes: list[Note], where: str) -> Indices:
    """Triangles with an area."""
    corner = points[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    good = area > 1e-9
    if not good.any():
        raise InputError(f"{where} has no faces with an area: a head's surface is needed, not points or lines")
    if not good.all():
        notes.append(Note("note", f"faces without area left out: {int((~good).sum())}"))
    unused = len(points) - len(np.unique(triangles[good]))
    if unused:
        notes.append(Note("note", f"vertices that no face uses, kept but not moved: {unused}"))
    return np.asarray(triangles[good], dtype=np.int32)


def _near(points: Floats, triangles: Indices, notes: list[Note]) -> tuple[Floats, Indices, NDArray[np.int64]]:
    """Cut away what lies farther from the eyes than a face may reach."""
    inside = np.asarray((np.abs(points) < FARTHEST_MM).all(axis=1))
    kept = np.arange(len(points))
    if inside.all():
        return points, triangles, kept
    triangles = triangles[inside[triangles].all(axis=1)]
    kept = np.flatnonzero(inside)
    number = np.full(len(points), -1, dtype=np.int32)
    number[kept] = np.arange(len(kept))
    notes.append(
        Note("note", f"vertices farther than {FARTHEST_MM:g} mm from the eyes cut away: {int((~inside).sum())}")
    )
    return points[kept], number[triangles], kept


def _check_landmarks_on_mesh(points: Floats, triangles: Indices, places: Mapping[str, Floats], where: str) -> None:
    used = np.unique(triangles)
    spacing = 2 * np.sqrt(FARTHEST_MM**2 / max(len(used), 1))
    away = cKDTree(points[used]).query(np.array(list(places.values())))[0]
    for name, distance in zip(places, away, strict=True):
        if distance > max(15.0, spacing):
            raise InputError(f"{where}: landmark {name} lies {distance:.0f} mm off the mesh (of a head of human size)")


def _welded(points: Floats, triangles: Indices) -> Indices:
    """The first vertex of those at one place whose surroundings do not face opposite ways (lips that touch)."""
    normals = vertex_normals(points, triangles)
    key = np.round(points / 1e-3).astype(np.int64)
    order = np.lexsort(key.T)
    first = np.concatenate([[True], (key[order[1:]] != key[order[:-1]]).any(axis=1)])
    group = np.cumsum(first) - 1
    head = order[first][group]
    opposed = np.einsum("nd,nd->n", normals[order], normals[head]) < _OPPOSED
    welded = np.empty(len(points), dtype=np.int32)
    welded[order] = head
    other: dict[int, int] = {}
    for vertex, number in zip(order[opposed], group[opposed], strict=True):
        welded[vertex] = other.setdefault(int(number), int(vertex))
    return welded


def _components(triangles: Indices, welded: Indices) -> NDArray[np.int64]:
    """Number of the connected piece of each triangle.

    Triangles hang together by the vertices they share, and across seams (of texture places) where two of them meet in
    vertices that lie together; what is only attached to an edge that has its two triangles (lashes) is a piece apart.
    """
    label = _connected(triangles[:, [0, 1, 1]], triangles[:, [1, 2, 0]], len(welded))[triangles[:, 0]]
    joined = welded[triangles]
    sides = np.sort(np.concatenate([joined[:, [0, 1]], joined[:, [1, 2]], joined[:, [2, 0]]]), axis=1)
    order = np.lexsort(sides.T)
    same = (sides[order[1:]] == sides[order[:-1]]).all(axis=1)
    alone = np.concatenate([[True], ~same]) & np.concatenate([same, [False]])  # the first of two or more
    pair = np.flatnonzero(alone & ~np.concatenate([same[1:], [False, False]]))  # of exactly two
    owner = label[order % len(triangles)]
    count = int(label.max()) + 1
    return _connected(owner[pair], owner[pair + 1], count)[label]


def _connected(one: NDArray[np.integer[Any]], other: NDArray[np.integer[Any]], count: int) -> NDArray[np.int64]:
    graph = sparse.coo_matrix((np.ones(one.size, dtype=np.int8), (one.ravel(), other.ravel())), (count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def outward(vertices: Floats, triangles: Indices) -> Indices:
    """Triangles with those of pieces turned round whose volume, about their own middle, is negative."""
    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    _, first, which = np.unique(np.round(vertices / extent * 1e6), axis=0, return_index=True, return_inverse=True)
    label = _components(triangles, first[which.ravel()].astype(np.int32))
    corner = vertices[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    middle = corner.mean(axis=1)
    _, label = np.unique(label, return_inverse=True)
    volume = np.bincount(label, np.einsum("td,td->t", facing, middle - _centres(middle, label)[label]))
    return np.where((volume < 0)[label][:, None], triangles[:, ::-1], triangles)


def _wound_outward(
    points: Floats,
    triangles: Indices,
    welded: Indices,
    label: NDArray[np.int64],
    round_ones: NDArray[np.bool_],
    template: Floats,
    template_triangles: Indices,
    notes: list[Note],
) -> Indices:
    """Turn round pieces whose normals look inward, told by the default skin laid on the head.

    ``round_ones`` (t,) are triangles of teeth and tongues: these lie by the lips, which would outvote them.
    """
    corner = points[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    middle = corner.mean(axis=1)
    away, nearest = cKDTree(template).query(middle)
    outward = vertex_normals(template, template_triangles)[nearest]
    vote = np.where(away < 15.0, np.einsum("td,td->t", facing, outward), 0.0)
    total = np.bincount(label, vote)
    volume = np.bincount(label, np.einsum("td,td->t", facing, middle - _centres(middle, label)[label]))
    inward = np.where(total != 0, total, volume) < 0
    # Of pieces that lie off the skin, and of closed ones (eyeballs, teeth), their own volume tells.
    off = np.bincount(label, away < 15.0) < 0.5 * np.bincount(label)
    inward = np.where(off | (_open_share(welded[triangles], label) < 0.02), volume < 0, inward)
    if round_ones.any():
        bulge = np.bincount(label[round_ones], _bulging(middle[round_ones], facing[round_ones]), len(inward))
        inward = np.where(bulge != 0, bulge < 0, inward)
    turned = inward[label]
    if turned.any():
        notes.append(Note("note", f"faces that pointed inward, turned over: {int(turned.sum())}"))
    return np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.int32)


def _bulging(middle: Floats, facing: Floats) -> Floats:
    """How far each triangle looks away from the middle of what lies about it: positive on a rod, open or bent."""
    some = slice(None, None, max(1, len(middle) // _ROUND_SAMPLES))
    tree = cKDTree(middle[some])
    near = cKDTree(middle).sparse_distance_matrix(tree, _ROUND_MM, output_type="coo_matrix")
    weight = np.linalg.norm(facing[some], axis=1)
    about = sparse.csr_matrix((weight[near.col], (near.row, near.col)), (len(middle), len(weight)))
    total = about.sum(axis=1)
    centres = np.where(total > 0, (about @ middle[some]) / np.maximum(total, 1e-12), middle)
    return np.asarray(np.einsum("td,td->t", facing, middle - centres))


def _open_share(triangles: Indices, label: NDArray[np.int64]) -> Floats:
    """Of each piece, the share of edges with a triangle on one side only."""
    _, first, times = np.unique(coded_sides(triangles)[0], return_index=True, return_counts=True)
    owner = label[first % len(triangles)]
    count = int(label.max()) + 1
    return np.asarray(np.bincount(owner, times == 1, count) / np.maximum(np.bincount(owner, None, count), 1))


def _centres(middle: Floats, label: NDArray[np.int64]) -> Floats:
    count = np.maximum(np.bincount(label), 1)
    return np.stack([np.bincount(label, middle[:, axis]) / count for axis in range(3)], axis=1)
