"""The default head's skin bent onto another head: first inside the space of heads, then freely but smoothly.

Three steps. (1) Similarity and weights of the space's components, by point-to-plane ICP under their prior. (2) A
thin-plate warp takes what the landmarks leave. (3) Displacements ``d`` of single vertices minimise ``a |L d|^2 +
sum_i w_i |x_i + d_i - q_i|^2`` with ``L`` the umbrella Laplacian and ``q_i`` the closest point that faces the same
way, for falling stiffness ``a`` (nonrigid ICP in the manner of Amberg, Romdhani, Vetter 2007, with a thin-plate
smoothness of displacements in place of their affine one).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from mien.face.head_space import HeadSpace
from mien.face.surface import Closest, Surface, edges_of, open_edges, vertex_normals
from mien.face.warps import Similarity, SmoothWarp
from mien.fit.alignment import Alignment
from mien.fit.landmarks import known_landmarks

__all__ = ["FitSettings", "SurfaceFit", "fit_in_space", "fit_surface", "umbrella"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FitSettings:
    """How hard the head is pulled.

    Attributes
    ----------
    landmark_sigma : float
        How far landmarks may be off, mm.
    surface_sigma : float
        The same of one of the samples in the first step; large, for thousands of samples outvote the prior.
    stiffness : tuple of float
        The third step's, from first to last.
    reach : float
        Closest points farther than this do not pull in the last round, mm (five times that in the first).
    warped : bool
        Whether a thin-plate warp takes what the landmarks leave: for landmarks that someone set.
    eye_sigma : float
        How far the middle of the lids may lie from where the eyeball's centre puts it, mm.
    """

    landmark_sigma: float = 1.0
    surface_sigma: float = 6.0
    stiffness: tuple[float, ...] = (300.0, 100.0, 30.0, 10.0, 4.0, 1.5, 0.6, 0.3)
    reach: float = 4.0
    warped: bool = True
    eye_sigma: float = 1.0


@dataclass(frozen=True, eq=False)
class SurfaceFit:
    """The bent skin.

    Attributes
    ----------
    vertices : ndarray, shape (n, 3)
        On the aligned head, mm.
    weights : ndarray, shape (k,)
        Of the space's components.
    distance : ndarray, shape (n,)
        To the closest point that faces the same way, mm; NaN where there is none or the skin cannot be seen.
    """

    vertices: Floats
    weights: Floats
    distance: Floats


def fit_surface(
    space: HeadSpace,
    head: Surface,
    places: Mapping[str, Floats],
    alignment: Alignment,
    settings: FitSettings | None = None,
    eyes: Mapping[str, Floats] | None = None,
) -> SurfaceFit:
    """Bend the default skin onto a head.

    Parameters
    ----------
    space : HeadSpace
    head : Surface
        The aligned head, mm.
    places : mapping of str to ndarray of shape (3,)
        Landmarks on it, mm.
    alignment : Alignment
    settings : FitSettings, optional
    eyes : mapping of "Left", "Right" to ndarray of shape (3,), optional
        Centres of the head's own eyeballs, mm.
    """
    settings = settings or FitSettings()
    marks = np.array([known_landmarks()[name].vertex for name in places])
    wanted = np.array(list(places.values()))
    rim = _rim(head)
    shape, weights = _fit_in_space(space, head, rim, marks, wanted, alignment.template, settings, eyes or {})
    if settings.warped and len(marks):
        shape = SmoothWarp(shape[marks], wanted, smoothness=settings.landmark_sigma)(shape)
    shape, distance = _fit_freely(space, head, rim, marks, wanted, shape, settings)
    return SurfaceFit(shape, weights, distance)


def fit_in_space(space: HeadSpace, head: Surface, start: Similarity) -> tuple[Floats, Floats]:
    """The head of the space that lies closest to another head, without landmarks: its skin and its weights."""
    none = np.zeros(0, dtype=np.int64)
    return _fit_in_space(space, head, _rim(head), none, np.zeros((0, 3)), start, FitSettings(), {})


def _rim(head: Surface) -> NDArray[np.bool_]:
    """Vertices of the head on open edges: what is closest there may lie beyond it."""
    rim = np.zeros(len(head.vertices), dtype=np.bool_)
    rim[open_edges(head.triangles[head.numbers]).ravel()] = True
    return rim


def _trusted(found: Closest, normals: Floats, head: Surface, rim: NDArray[np.bool_], reach: float) -> Floats:
    """1 where a closest point may pull, 0 where it lies too far, faces elsewhere or is on an open edge."""
    alike = np.einsum("qd,qd->q", found.normals, normals) > 0.5
    corner = head.triangles[found.triangle]
    on_rim = ((found.weights > 0.02) & ~rim[corner]).sum(axis=1) == 0
    return np.asarray(alike & (found.distance < reach) & ~on_rim, dtype=np.float64)


def _fit_in_space(
    space: HeadSpace,
    head: Surface,
    rim: NDArray[np.bool_],
    marks: NDArray[np.int64],
    wanted: Floats,
    start: Similarity,
    settings: FitSettings,
    eyes: Mapping[str, Floats],
) -> tuple[Floats, Floats]:
    turn, scale, shift = start.turn, start.scale, start.shift
    count = len(space.components)
    weights = np.zeros(count)
    samples = np.flatnonzero(space.outer())[::4]
    shape = scale * space.shape(weights) @ turn.T + shift
    for reach in (0.0, 0.0, 25.0, 20.0, 16.0, 12.0, 10.0, 8.0, 8.0, 8.0):
        rows, right = _landmark_rows(space, shape, shift, turn, scale, marks, wanted, settings.landmark_sigma)
        more, gaps = _eye_rows(space, shape, shift, turn, scale, eyes, settings.eye_sigma)
        rows, right = np.vstack([rows, more]), np.concatenate([right, gaps])
        if reach:
            normals = vertex_normals(shape, space.triangles)[samples]
            found = head.closest(shape[samples], normals)
            trust = _trusted(found, normals, head, rim, reach * scale)
            more, gaps = _plane_rows(space, shape, shift, turn, scale, samples, found, trust, settings.surface_sigma)
            rows, right = np.vstack([rows, more]), np.concatenate([right, gaps])
        prior = np.hstack([np.zeros((count, 7)), np.eye(count)])
        rows, right = np.vstack([rows, prior]), np.concatenate([right, -weights])
        step = np.linalg.solve(rows.T @ rows + 1e-9 * np.eye(7 + count), rows.T @ right)
        turn, scale, shift = _turned(step[:3]) @ turn, scale * float(np.exp(step[6])), shift + step[3:6]
        weights = np.clip(weights + step[7:], -4, 4)
        shape = scale * space.shape(weights) @ turn.T + shift
    return shape, weights


def _turned(vector: NDArray[Any]) -> Floats:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def _moves(
    space: HeadSpace, shape: Floats, shift: Floats, turn: Floats, scale: float, chosen: NDArray[np.int64]
) -> Floats:
    """How chosen vertices move with the 7 numbers of the similarity and the components, shape (q, 3, 7 + k)."""
    arm = shape[chosen] - shift
    moves = np.zeros((len(chosen), 3, 7 + len(space.components)))
    for axis, (x, y) in enumerate(((1, 2), (2, 0), (0, 1))):
        moves[:, y, axis], moves[:, x, axis] = arm[:, x], -arm[:, y]
    moves[:, :, 3:6] = np.eye(3)
    moves[:, :, 6] = arm
    moves[:, :, 7:] = scale * np.einsum("ij,kqj->qik", turn, space.components[:, chosen].astype(np.float64))
    return moves


def _landmark_rows(
    space: HeadSpace, shape: Floats, shift: Floats, turn: Floats, scale: float,
    marks: NDArray[np.int64], wanted: Floats, sigma: float,
) -> tuple[Floats, Floats]:  # fmt: skip
    moves = _moves(space, shape, shift, turn, scale, marks)
    return moves.reshape(-1, moves.shape[2]) / sigma, (wanted - shape[marks]).ravel() / sigma


def _eye_rows(
    space: HeadSpace, shape: Floats, shift: Floats, turn: Floats, scale: float, eyes: Mapping[str, Floats], sigma: float
) -> tuple[Floats, Floats]:
    """The middle of each eye's lids keeps its place before the eyeball's centre, sideways and in height."""
    rows, right = [np.zeros((0, 7 + len(space.components)))], [np.zeros(0)]
    for eye in space.face.eyes:
        if eye.side in eyes:
            loop = (space.lid_loop_left if eye.side == "Left" else space.lid_loop_right).astype(np.int64)
            arm = scale * turn @ (np.array(eye.centre) - space.rest[loop].mean(0))
            gap = eyes[eye.side] - (shape[loop].mean(0) + arm)
            moves = _moves(space, shape, shift, turn, scale, loop).mean(axis=0)
            across = turn[:, :2].T / sigma
            rows.append(across @ moves)
            right.append(across @ gap)
    return np.vstack(rows), np.concatenate(right)


def _plane_rows(
    space: HeadSpace, shape: Floats, shift: Floats, turn: Floats, scale: float,
    samples: NDArray[np.int64], found: Closest, trust: Floats, sigma: float,
) -> tuple[Floats, Floats]:  # fmt: skip
    kept = np.flatnonzero(trust)
    moves = _moves(space, shape, shift, turn, scale, samples[kept])
    gap = np.einsum("qd,qd->q", found.normals[kept], found.points[kept] - shape[samples[kept]])
    robust = 1 / np.maximum(1.0, np.abs(gap) / 4.0) ** 0.5 / sigma
    return np.einsum("qd,qdp->qp", found.normals[kept], moves) * robust[:, None], gap * robust


def umbrella(triangles: NDArray[np.int32], count: int) -> sparse.csr_matrix:
    """The umbrella Laplacian: each vertex less the mean of its neighbours."""
    edges = edges_of(triangles)
    ends = np.concatenate([edges, edges[:, ::-1]])
    beside = sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (count, count))
    degree = np.maximum(np.asarray(beside.sum(1)).ravel(), 1)
    return sparse.identity(count, format="csr") - sparse.diags(1 / degree) @ beside


def _fit_freely(
    space: HeadSpace,
    head: Surface,
    rim: NDArray[np.bool_],
    marks: NDArray[np.int64],
    wanted: Floats,
    start: Floats,
    settings: FitSettings,
) -> tuple[Floats, Floats]:
    count = len(start)
    laplacian = umbrella(space.triangles, count)
    bending = (laplacian.T @ laplacian).tocsc()
    visible = space.outer().astype(np.float64)
    at_marks = np.zeros(count)
    np.add.at(at_marks, marks, 4.0 / settings.landmark_sigma**2)
    mark_goal = np.zeros((count, 3))
    mark_goal[marks] = wanted - start[marks]
    shape, move = start, np.zeros_like(start)
    reaches = np.geomspace(5 * settings.reach, settings.reach, len(settings.stiffness))
    for stiffness, reach in zip(settings.stiffness, reaches, strict=True):
        normals = vertex_normals(shape, space.triangles)
        found = head.closest(shape, normals)
        trust = visible * _trusted(found, normals, head, rim, float(reach))
        gap = found.points - shape
        along = np.einsum("qd,qd->q", gap, found.normals)[:, None] * found.normals
        goal = move + along + 0.15 * (gap - along)
        hint = at_marks * min(1.0, stiffness) * (stiffness > settings.stiffness[-3])  # the surface has the last word
        pull = trust + hint
        system = stiffness * bending + sparse.diags(pull + 1e-6)
        right = trust[:, None] * goal + hint[:, None] * mark_goal
        move = splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
        shape = start + move
    normals = vertex_normals(shape, space.triangles)
    found = head.closest(shape, normals)
    trust = visible * _trusted(found, normals, head, rim, settings.reach)
    return shape, np.where(trust > 0, found.distance, np.nan)
