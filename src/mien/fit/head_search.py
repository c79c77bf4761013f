"""A head found in a mesh without landmarks: the space of heads laid over it from many starts.

Starts are all 24 turns by right angles and some sizes (a head alone, a bust, a body with its head on top). From each
the mean head is brought nearer by point-to-plane ICP (Chen, Medioni 1992) on few points; the best go on with the
components of the space (`mien.fit.surface_fit.fit_in_space`). The start whose face lies closest in the end is kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from mien.core.errors import InputError
from mien.face.head_space import HeadSpace
from mien.face.surface import Surface, vertex_normals
from mien.face.warps import Similarity, spread_points
from mien.fit.head_regions import head_regions
from mien.fit.landmarks import known_landmarks
from mien.fit.surface_fit import fit_in_space

__all__ = ["FoundHead", "find_head"]

Floats = NDArray[np.float64]

_MESH_POINTS, _FACE_POINTS = 9000, 220
_HEIGHTS = (1.0, 1.25, 1.6, 2.2, 3.6, 5.5, 7.5)  # of the mesh, in heads from crown to chin
_ROUNDS, _KEPT = 14, 3
_FAR_MM = 8.0
_POOR = 0.5
_UNLIKE, _DOUBTFUL, _LOOSE = 0.6, 0.35, 0.15
"""Costs of the mean head at the best start: heads (whole, scanned, cut to 2,000 triangles, with half missing) have .08
to .25, eggs, rings and lumps .40 to .50, a ball .77. Past the first there is no head; past the second there is none
unless the space of heads comes nearer than the third."""


@dataclass(frozen=True, eq=False)
class FoundHead:
    """Where the head lies.

    Attributes
    ----------
    places : dict of str to ndarray of shape (3,)
        Landmarks in the file's coordinates.
    cost : float
        0 (the face lies on the mesh) to 1 (nothing of it does).
    """

    places: dict[str, Floats]
    cost: float


@dataclass(frozen=True, eq=False)
class _Cloud:
    """Points of the mesh with their normals."""

    points: Floats
    normals: Floats


@dataclass(frozen=True, eq=False)
class _Face:
    """Points of the mean head: of the face and around it, with weights."""

    numbers: NDArray[np.int64]
    points: Floats
    normals: Floats
    weight: Floats
    crown: Floats
    height: float


def find_head(vertices: Floats, triangles: NDArray[np.int32], space: HeadSpace, where: str) -> FoundHead:
    """Find the head in a mesh in any unit, turn and place.

    Parameters
    ----------
    vertices, triangles : ndarray
        In the file's coordinates, faces wound outward.
    space : HeadSpace
    where : str
        Names the mesh in errors.

    Raises
    ------
    InputError
        If nothing in it looks like a head.
    """
    cloud = _cloud(vertices, triangles)
    face = _mean_face(space)
    trials = sorted((_nearer(cloud, face, start) for start in _starts(cloud, face)), key=lambda each: each[0])
    none = InputError(f"{where}: no head was found in it: give --landmarks (mien face fit --list-landmarks)")
    if trials[0][0] > _UNLIKE:
        raise none
    best: tuple[float, Floats] | None = None
    for start in _different([start for _, start in trials])[:_KEPT]:
        cost, shape = _in_space(vertices, triangles, space, face, start)
        if best is None or cost < best[0]:
            best = cost, shape
    assert best is not None
    cost, shape = best
    if cost > _POOR or (trials[0][0] > _DOUBTFUL and cost > _LOOSE):
        raise none
    return FoundHead({name: shape[mark.vertex] for name, mark in known_landmarks().items()}, cost)


def _different(starts: list[Similarity]) -> list[Similarity]:
    """Those that are not nearly a better one."""
    kept: list[Similarity] = []
    for start in starts:
        if all(
            np.trace(start.turn.T @ one.turn) < 2.9
            or abs(np.log(start.scale / one.scale)) > 0.1
            or np.linalg.norm(start.shift - one.shift) > 20 * one.scale
            for one in kept
        ):
            kept.append(start)
    return kept


def _cloud(vertices: Floats, triangles: NDArray[np.int32]) -> _Cloud:
    """Points spread over the surface by area."""
    chance = np.random.default_rng(0)
    corner = vertices[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(facing, axis=1)
    chosen = chance.choice(len(triangles), _MESH_POINTS, p=area / area.sum())
    share = chance.dirichlet((1.0, 1.0, 1.0), _MESH_POINTS)
    points = np.einsum("qk,qkd->qd", share, corner[chosen])
    return _Cloud(points, facing[chosen] / area[chosen][:, None])


def _mean_face(space: HeadSpace) -> _Face:
    shape = space.shape([0.0])
    regions = head_regions()
    front = np.flatnonzero(sum(regions[key] for key in ("mouth", "eyes", "nose", "forehead", "cheeks and jaw")))
    around = np.flatnonzero(regions["skull"])
    numbers = np.concatenate(
        [front[spread_points(shape[front], _FACE_POINTS)], around[spread_points(shape[around], _FACE_POINTS // 3)]]
    )
    weight = np.where(np.arange(len(numbers)) < _FACE_POINTS, 1.0, 0.4)
    crown = shape[known_landmarks()["crown"].vertex]
    height = float(crown[1] - shape[known_landmarks()["chin"].vertex][1])
    return _Face(numbers, shape[numbers], vertex_normals(shape, space.triangles)[numbers], weight, crown, height)


def _turns() -> list[Floats]:
    """The 24 rotations that bring axes onto axes; upright as most files are first."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[np.array(order), np.arange(3)] = signs
            if np.linalg.det(turn) > 0:
                found.append(turn)
    return found


def _starts(cloud: _Cloud, face: _Face) -> list[Similarity]:
    """From the mean head's coordinates to the file's: its crown on top of the mesh, whatever is up."""
    starts = []
    for turn in _turns():
        local = cloud.points @ turn  # upright, if this turn is right
        top, low = np.percentile(local[:, 1], (99.9, 0.1))
        for heads in _HEIGHTS:
            size = max((top - low) / heads, 1e-12)
            scale = size / face.height
            near = local[local[:, 1] > top - size]
            middle = (near.max(0) + near.min(0)) / 2
            own = (face.points.max(0) + face.points.min(0)) / 2
            shift = np.array([middle[0] - scale * own[0], top - scale * face.crown[1], middle[2] - scale * own[2]])
            starts.append(Similarity(scale, turn, turn @ shift))
    return starts


def _nearer(cloud: _Cloud, face: _Face, start: Similarity) -> tuple[float, Similarity]:
    """Point-to-plane ICP of the mean head; cost and place."""
    tree = cKDTree(cloud.points)
    scale, turn, shift = start.scale, start.turn, start.shift
    for reach in np.geomspace(40.0, 8.0, _ROUNDS):
        points = scale * face.points @ turn.T + shift
        away, near = tree.query(points)
        facing = np.einsum("qd,qd->q", face.normals @ turn.T, cloud.normals[near])
        weight = face.weight * (facing > 0.3) * np.exp(-((away / (reach * scale)) ** 2))
        if (weight > 0.1).sum() < 30:
            break
        normals = cloud.normals[near]
        gap = np.einsum("qd,qd->q", normals, cloud.points[near] - points)
        arm = points - shift
        rows = np.hstack([np.cross(arm, normals), normals * scale, np.einsum("qd,qd->q", normals, arm)[:, None]])
        system = rows.T @ (weight[:, None] * rows)
        system += 1e-3 * np.trace(system) / 7 * np.eye(7) * np.array([0.1, 0.1, 0.1, 0.01, 0.01, 0.01, 1.0])
        step = np.linalg.solve(system, rows.T @ (weight * gap))
        turn = Rotation.from_rotvec(step[:3]).as_matrix() @ turn
        scale = float(np.clip(scale * np.exp(step[6]), start.scale / 1.5, start.scale * 1.5))
        shift = shift + scale * step[3:6]
    now = Similarity(scale, turn, shift)
    return _cost(cloud, face, now(face.points), face.normals @ turn.T, scale, tree), now


def _cost(cloud: _Cloud, face: _Face, points: Floats, normals: Floats, scale: float, tree: cKDTree) -> float:
    """How badly the face lies on the mesh, and how much of the mesh about it lies off the face; 0..1."""
    away, near = tree.query(points)
    off = np.abs(np.einsum("qd,qd->q", cloud.normals[near], points - cloud.points[near])) / scale
    facing = np.einsum("qd,qd->q", normals, cloud.normals[near])
    bad = np.minimum(((off / _FAR_MM) ** 2 + (away / scale / 25.0) ** 2 + np.maximum(1 - facing, 0)), 1.0)
    return float(np.average(bad, weights=face.weight))


def _in_space(
    vertices: Floats, triangles: NDArray[np.int32], space: HeadSpace, face: _Face, start: Similarity
) -> tuple[float, Floats]:
    """The same with the space's components, on the whole surface; cost and the skin in the file's coordinates."""
    local = (vertices - start.shift) @ start.turn / start.scale
    reach = 2.0 * face.height
    near = np.asarray((np.abs(local) < reach).all(axis=1))[triangles].all(axis=1)
    if not near.any():
        return 1.0, start(space.rest)
    surface = Surface(local, triangles, np.asarray(near))
    shape, _ = fit_in_space(space, surface, Similarity(1.0, np.eye(3), np.zeros(3)))
    normals = vertex_normals(shape, space.triangles)[face.numbers]
    found = surface.closest(shape[face.numbers], normals)
    bad = np.minimum((found.distance / _FAR_MM) ** 2 + 1 - np.einsum("qd,qd->q", found.normals, normals), 1.0)
    return float(np.average(bad, weights=face.weight)), start(shape)
