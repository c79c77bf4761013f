"""The motion of a fitted default skin carried over to the head it was fitted to, vertex by vertex.

Each vertex takes the displacement of the closest place of the fitted skin that faces the same way. Near lips and lids
the two edges are told apart first: each vertex prefers the edge that is closer in place and facing, and neighbours on
the head's own mesh vote with it (a harmonic smoothing of the preference), so that the head's connectivity, not bare
distance, says what is upper and what is lower. Where nothing of the fitted skin is close (a deeper mouth, the lids'
backs), the displacement is filled in smoothly over the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from mien.face.contact import distance_along, split_loop
from mien.face.head_space import HeadSpace
from mien.face.surface import Closest, Surface, edges_of

__all__ = ["Carried", "carry_over", "filled", "strays"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_LIP_REACH, _LID_REACH = 14.0, 7.0  # mm along the default skin from its openings within which sides are told apart
_CLOSE_MM = 2.5
_EDGE_MM = 0.7  # as long as the default's at its lids; twice that at its lips
_MOST_FILLED = 300_000
_STRAY_MM, _STRAY_TIMES, _STRAY_SHARE = 4.0, 3.5, 0.6


@dataclass(frozen=True, eq=False)
class Carried:
    """Where each vertex of a head takes its motion from.

    Attributes
    ----------
    matrix : csr_matrix, shape (head vertices, skin vertices)
        Weights of the fitted skin's vertices.
    trust : ndarray, shape (n,)
        1 where the skin is close, 0 where the motion has to be filled in.
    distance : ndarray, shape (n,)
        To the fitted skin, mm.
    upper : dict of str to ndarray of int8, shape (n,)
        For "mouth", "eye_left", "eye_right": 1 on the upper side, -1 on the lower one, 0 away from the opening.
    """

    matrix: sparse.csr_matrix
    trust: Floats
    distance: Floats
    upper: dict[str, NDArray[np.int8]]


def openings(space: HeadSpace) -> dict[str, tuple[Floats, Floats]]:
    """For each opening how far every vertex of the default skin is from its upper and its lower half, mm."""
    found = {}
    for name, loop, reach in (
        ("mouth", space.lip_loop, _LIP_REACH),
        ("eye_left", space.lid_loop_left, _LID_REACH),
        ("eye_right", space.lid_loop_right, _LID_REACH),
    ):
        upper, lower, _ = split_loop(space.rest, loop.astype(np.int64))
        ways = (distance_along(space.rest, space.triangles, half, limit=2 * reach) for half in (upper, lower))
        found[name] = tuple(ways)
    return found  # type: ignore[return-value]


def carry_over(space: HeadSpace, skin: Floats, head: Surface, mouth: NDArray[np.int8] | None = None) -> Carried:
    """Find for each vertex of a head what moves it.

    Parameters
    ----------
    space : HeadSpace
    skin : ndarray, shape (m, 3)
        The default skin fitted to the head, mm.
    head : Surface
        The head (vertices that lie together welded).
    mouth : ndarray of int8, shape (n,), optional
        Sides of the mouth that are known (1 upper, -1 lower, 0 not known), as after a cut.
    """
    whole = Surface(skin, space.triangles)
    used = np.unique(head.triangles[head.numbers])
    points, normals = head.vertices[used], head.normals[used]
    best = whole.closest(points, normals)
    edges = edges_of(np.searchsorted(used, head.triangles[head.numbers]).astype(np.int32))
    sides = {}
    for name, (to_upper, to_lower) in openings(space).items():
        known = mouth[used] if mouth is not None and name == "mouth" else None
        best, side = _told_apart(space, skin, best, points, normals, edges, to_upper, to_lower, _reach(name), known)
        whole_side = np.zeros(len(head.vertices), dtype=np.int8)
        whole_side[used] = side
        sides[name] = whole_side
    alike = np.einsum("qd,qd->q", best.normals, normals)
    trust = np.clip((alike - 0.2) / 0.4, 0, 1) * np.clip(2 - best.distance / _CLOSE_MM, 0, 1)
    part = best.matrix(space.triangles, len(skin))
    place = sparse.csr_matrix((np.ones(len(used)), (used, np.arange(len(used)))), (len(head.vertices), len(used)))
    whole_trust, distance = np.ones(len(head.vertices)), np.full(len(head.vertices), np.nan)
    whole_trust[used], distance[used] = trust, best.distance
    return Carried((place @ part).tocsr(), whole_trust, distance, sides)


def _reach(name: str) -> float:
    return _LIP_REACH if name == "mouth" else _LID_REACH


def _told_apart(
    space: HeadSpace,
    skin: Floats,
    best: Closest,
    points: Floats,
    normals: Floats,
    edges: NDArray[np.int32],
    to_upper: Floats,
    to_lower: Floats,
    reach: float,
    known: NDArray[np.int8] | None,
) -> tuple[Closest, NDArray[np.int8]]:
    """Closest points with the sides of one opening kept apart, and the side of each point."""
    near = np.minimum(to_upper, to_lower) < reach
    corner = space.triangles
    is_near = np.asarray(near[corner].all(axis=1))
    lead = np.where(near, np.minimum(to_upper, 99.0) - np.minimum(to_lower, 99.0), 0.0)
    above = is_near & (lead[corner].mean(axis=1) <= 0)
    below = is_near & ~above
    side = np.zeros(len(points), dtype=np.int8)
    asked = np.flatnonzero(is_near[best.triangle] | (False if known is None else known != 0))
    if not len(asked) or not above.any() or not below.any():
        return best, side
    halves = [Surface(skin, corner, chosen) for chosen in (above, below)]
    found = [half.closest(points[asked], normals[asked]) for half in halves]
    prefer = (found[1].cost - found[0].cost) / (found[0].cost + found[1].cost + 2.0)
    score = _voted(prefer, asked, edges, points)
    up = score >= 0 if known is None else np.where(known[asked] != 0, known[asked] > 0, score >= 0)
    side[asked] = np.where(up, 1, -1)
    return _replaced(best, asked, found, up), side


def _replaced(best: Closest, asked: Indices, found: list[Closest], up: NDArray[np.bool_]) -> Closest:
    """The closest points with those asked again put in from the half that each belongs to."""
    new = {}
    for name in ("triangle", "weights", "points", "normals", "distance", "cost"):
        values = getattr(best, name).copy()
        one, other = getattr(found[0], name), getattr(found[1], name)
        values[asked] = np.where(up.reshape(-1, *[1] * (one.ndim - 1)), one, other)
        new[name] = values
    return Closest(**new)


def _voted(prefer: Floats, asked: Indices, edges: NDArray[np.int32], points: Floats) -> Floats:
    """Preferences smoothed over the mesh: strong ones stay, weak ones take their neighbours'.

    On a mesh finer than the default's a vertex stands for less skin, and its own preference counts for less: the
    smoothing reaches as many millimetres, whatever the mesh.
    """
    number = np.full(len(points), -1)
    number[asked] = np.arange(len(asked))
    inner = number[edges]
    inner = inner[(inner >= 0).all(axis=1)]
    rows = np.concatenate([inner[:, 0], inner[:, 1]])
    columns = np.concatenate([inner[:, 1], inner[:, 0]])
    beside = sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), (len(asked), len(asked)))
    degree = np.asarray(beside.sum(1)).ravel()
    place = points[asked]
    length = np.bincount(rows, np.linalg.norm(place[rows] - place[columns], axis=1), len(asked)) / np.maximum(degree, 1)
    skin = np.clip(length / _EDGE_MM, 0.05, 1.0) ** 2
    weight = skin * (np.abs(prefer) + 1e-3)
    system = sparse.diags(weight + 0.5 * degree + 1e-9) - 0.5 * beside
    return np.asarray(splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(weight * np.sign(prefer)))


def strays(vertices: Floats, triangles: NDArray[np.int32], moves: Floats) -> NDArray[np.bool_]:
    """Which vertices a motion (n, 3) tears from nearly all that surround them.

    In the folds behind the lips, walls lie a millimetre apart, and a vertex may lie closest to the other one: of a fine
    mesh one in some ten thousand does.
    """
    one, other = edges_of(triangles).T
    before = np.linalg.norm(vertices[one] - vertices[other], axis=1)
    after = np.linalg.norm((vertices + moves)[one] - (vertices + moves)[other], axis=1)
    torn = (after - before > _STRAY_MM) & (after > _STRAY_TIMES * before)
    count = len(vertices)
    degree = np.bincount(one, None, count) + np.bincount(other, None, count)
    apart = np.bincount(one, torn, count) + np.bincount(other, torn, count)
    return np.asarray(apart > _STRAY_SHARE * np.maximum(degree, 1))


def filled(given: Floats, values: Floats, triangles: NDArray[np.int32]) -> Floats:
    """Values (n, c) with those of little trust replaced by a smooth continuation over the mesh.

    ``given`` (n,) is their trust, 0..1. Minimises ``sum trust |u - v|^2 + sum_edges |u_i - u_j|^2`` over the vertices
    of little trust, the others held.
    """
    loose = given < 0.999
    edges = edges_of(triangles)
    touched = edges[loose[edges].any(axis=1)]
    free = np.flatnonzero(loose & (np.bincount(edges.ravel(), minlength=len(loose)) > 0))
    if not len(free) or len(free) > _MOST_FILLED:
        return values
    number = np.full(len(loose), -1)
    number[free] = np.arange(len(free))
    trust = np.clip(given[free], 0, 0.999)
    pull = trust / (1 - trust) + 1e-4
    ends = np.concatenate([touched, touched[:, ::-1]])
    ends = ends[number[ends[:, 0]] >= 0]
    inner = ends[number[ends[:, 1]] >= 0]
    held = ends[number[ends[:, 1]] < 0]
    degree = np.bincount(number[ends[:, 0]], minlength=len(free))
    beside = sparse.csr_matrix(
        (np.ones(len(inner)), (number[inner[:, 0]], number[inner[:, 1]])), (len(free), len(free))
    )
    system = sparse.diags(pull + degree) - beside
    border = sparse.csr_matrix((np.ones(len(held)), (number[held[:, 0]], held[:, 1])), (len(free), len(values)))
    right = pull[:, None] * values[free] + border @ values
    out = values.copy()
    out[free] = splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(right)
    return out
