"""A bare head mesh made ready: pieces told apart, vertices that lie and face together joined, winding outward.

Nothing of the given mesh is changed but where this is said in a note: its vertices keep their numbers (up to those that
are cut away with what lies too far from the head).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mien.core.errors import InputError, Note
from mien.face.surface import vertex_normals
from mien.face.warps import Similarity

__all__ = ["HeadMesh", "Piece", "prepared_mesh", "sphere_through"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

FARTHEST_MM = 320.0  # from the origin: what a face file can hold
_OPPOSED = -0.5
_EYE_NEAR_MM, _EYE_SIZES_MM, _EYE_ROUND = 14.0, (8.0, 26.0), 0.12
_MOUTH_PIECE_MM = 45.0


@dataclass(frozen=True, eq=False)
class Piece:
    """A connected piece: ``kind`` is "skin", "eye_left", "eye_right", "upper" or "lower" (in the mouth), or "other"."""

    kind: str
    triangles: NDArray[np.int64]  # numbers
    centre: Floats  # of an eye: its sphere's; mm
    radius: float


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
        Landmarks, mm.
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
    _check_landmarks_on_mesh(points, triangles, places, where)
    welded = _welded(points, triangles)
    label = _components(welded[triangles], len(points))
    triangles = _wound_outward(points, triangles, welded, label, template, template_triangles, notes)
    pieces = _pieces(points, triangles, label, eyes, places)
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


def _components(triangles: Indices, count: int) -> NDArray[np.int64]:
    """Number of the connected piece of each triangle."""
    rows = np.concatenate([triangles[:, 0], triangles[:, 1]])
    columns = np.concatenate([triangles[:, 1], triangles[:, 2]])
    graph = sparse.coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), (count, count))
    return np.asarray(connected_components(graph, directed=False)[1][triangles[:, 0]], dtype=np.int64)


def _wound_outward(
    points: Floats,
    triangles: Indices,
    welded: Indices,
    label: NDArray[np.int64],
    template: Floats,
    template_triangles: Indices,
    notes: list[Note],
) -> Indices:
    """Turn round pieces whose normals look inward, told by the default skin laid on the head."""
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
    turned = inward[label]
    if turned.any():
        notes.append(Note("note", f"faces that looked inward, turned round: {int(turned.sum())}"))
    return np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.int32)


def _open_share(triangles: Indices, label: NDArray[np.int64]) -> Floats:
    """Of each piece, the share of edges with a triangle on one side only."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    _, first, times = np.unique(sides, axis=0, return_index=True, return_counts=True)
    owner = label[first % len(triangles)]
    count = int(label.max()) + 1
    return np.asarray(np.bincount(owner, times == 1, count) / np.maximum(np.bincount(owner, None, count), 1))


def _centres(middle: Floats, label: NDArray[np.int64]) -> Floats:
    count = np.maximum(np.bincount(label), 1)
    return np.stack([np.bincount(label, middle[:, axis]) / count for axis in range(3)], axis=1)


def sphere_through(points: Floats) -> tuple[Floats, float, float]:
    """Centre, radius and RMS distance of a sphere by least squares."""
    middle = points.mean(0)
    arm = points - middle
    system = np.c_[2 * arm, np.ones(len(arm))]
    solution = np.linalg.lstsq(system, (arm**2).sum(1), rcond=None)[0]
    radius = float(np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 0.0)))
    left = np.linalg.norm(arm - solution[:3], axis=1) - radius
    return middle + solution[:3], radius, float(np.sqrt((left**2).mean()))


def _pieces(
    points: Floats,
    triangles: Indices,
    label: NDArray[np.int64],
    eyes: Mapping[str, Floats],
    places: Mapping[str, Floats],
) -> tuple[Piece, ...]:
    # (not the eyes' corners: lashes of their own lie there)
    wanted = np.array([places[name] for name in places if name.startswith(("nose", "chin", "lip_corner"))])
    owner = _owner_of(points, triangles, label, wanted)
    mouth = (places["lip_corner_left"] + places["lip_corner_right"]) / 2
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    pieces = []
    for numbers in groups:
        number = int(label[numbers[0]])
        used = points[np.unique(triangles[numbers])]
        kind, centre, radius = "other", used.mean(0), 0.0
        if number in owner:
            kind = "skin"
        else:
            kind, centre, radius = _kind_of(used, eyes, mouth)
        pieces.append(Piece(kind, numbers, centre, radius))
    return tuple(pieces)


def _owner_of(points: Floats, triangles: Indices, label: NDArray[np.int64], wanted: Floats) -> set[int]:
    """The pieces on which landmarks lie, but for those that carry a few stray ones only."""
    used, first = np.unique(triangles.ravel(), return_index=True)
    nearest = first[cKDTree(points[used]).query(wanted)[1]] // 3
    numbers, times = np.unique(label[nearest], return_counts=True)
    return {int(number) for number, count in zip(numbers, times, strict=True) if count >= 0.15 * len(wanted)}


def _kind_of(used: Floats, eyes: Mapping[str, Floats], mouth: Floats) -> tuple[str, Floats, float]:
    middle = (used.max(0) + used.min(0)) / 2
    size = float(np.linalg.norm(used.max(0) - used.min(0)))
    for side, place in eyes.items():
        if len(used) >= 12 and np.linalg.norm(middle - place) < _EYE_NEAR_MM:
            centre, radius, left = sphere_through(used)
            round_enough = _EYE_SIZES_MM[0] < radius < _EYE_SIZES_MM[1] and left < _EYE_ROUND * radius
            if round_enough and np.linalg.norm(centre - place) < 1.5 * _EYE_NEAR_MM:
                return f"eye_{side.lower()}", centre, radius
    inside = np.abs(middle[0] - mouth[0]) < 15 and np.abs(middle[1] - mouth[1]) < 30
    if inside and middle[2] < mouth[2] and size < 3 * _MOUTH_PIECE_MM and middle[2] > mouth[2] - 2 * _MOUTH_PIECE_MM:
        return ("upper" if middle[1] > mouth[1] else "lower"), used.mean(0), 0.0
    return "other", used.mean(0), 0.0
