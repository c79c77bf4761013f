"""A triangle mesh that can be asked for its closest points, told apart by which way the surface faces.

Closest points are sought among samples in six dimensions (place, and normal times `NORMAL_MM`): the two lips of a shut
mouth lie on each other, but face each other, and are never mixed up. The best few samples' triangles are then measured
exactly (closest point of a triangle: Ericson, Real-Time Collision Detection, 2005, 5.1.5).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.core.compiled import njit

__all__ = ["Closest", "Surface", "coded_sides", "edges_of", "open_edges", "vertex_normals"]

NORMAL_MM = 8.0
_NEAREST = 6
_MOST_SAMPLES = 1_500_000

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]


def vertex_normals(vertices: Floats, triangles: Indices) -> Floats:
    """Unit normals of vertices, weighted by area, shape (n, 3); zero where there is no area."""
    corner = vertices[triangles]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, k], face[:, axis], len(vertices))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def edges_of(triangles: Indices) -> Indices:
    """Each edge once, shape (e, 2), lower number first, in order."""
    code, count = coded_sides(triangles)
    return _ends(np.unique(code), count)


def open_edges(triangles: Indices) -> Indices:
    """Edges with a triangle on one side only, shape (e, 2)."""
    code, count = coded_sides(triangles)
    one, times = np.unique(code, return_counts=True)
    return _ends(one[times == 1], count)


def coded_sides(triangles: Indices) -> tuple[NDArray[np.int64], int]:
    """Each side of each triangle as one number, which sorts several times faster than a pair."""
    count = int(triangles.max(initial=0)) + 1
    one = np.concatenate([triangles[:, k] for k in (0, 1, 2)]).astype(np.int64)
    other = np.concatenate([triangles[:, k] for k in (1, 2, 0)]).astype(np.int64)
    return np.minimum(one, other) * count + np.maximum(one, other), count


def _ends(code: NDArray[np.int64], count: int) -> Indices:
    return np.stack([code // count, code % count], axis=1).astype(np.int32)


@dataclass(frozen=True, eq=False)
class Closest:
    """Closest points of a surface.

    Attributes
    ----------
    triangle : ndarray of int, shape (q,)
    weights : ndarray, shape (q, 3)
        Of the triangle's corners.
    points, normals : ndarray, shape (q, 3)
    distance : ndarray, shape (q,)
        mm.
    cost : ndarray, shape (q,)
        Squared distance in six dimensions, mm^2.
    """

    triangle: Indices
    weights: Floats
    points: Floats
    normals: Floats
    distance: Floats
    cost: Floats

    def matrix(self, triangles: Indices, vertices: int) -> sparse.csr_matrix:
        """From values at the surface's vertices to values at the points."""
        rows = np.repeat(np.arange(len(self.triangle)), 3)
        columns = triangles[self.triangle].ravel()
        return sparse.csr_matrix((self.weights.ravel(), (rows, columns)), (len(self.triangle), vertices))


class Surface:
    """Vertices (n, 3) and triangles (t, 3), counter-clockwise from outside; ``chosen`` limits it to some triangles."""

    def __init__(self, vertices: Floats, triangles: Indices, chosen: NDArray[np.bool_] | None = None) -> None:
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.triangles = np.asarray(triangles, dtype=np.int32)
        self.normals = vertex_normals(self.vertices, self.triangles)
        self.numbers = np.arange(len(triangles)) if chosen is None else np.flatnonzero(chosen)

    @cached_property
    def _samples(self) -> tuple[cKDTree, Indices]:
        used = self.triangles[self.numbers]
        corner = self.vertices[used]
        side = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
        cuts = np.clip(np.ceil(side / 2.5), 1, 12).astype(int)
        if (cuts**2).sum() > _MOST_SAMPLES:
            cuts = np.ones_like(cuts)
        places, owners = [], []
        for count in np.unique(cuts):
            some = np.flatnonzero(cuts == count)
            grid = _grid(int(count))
            both = np.concatenate([corner[some], NORMAL_MM * self.normals[used[some]]], axis=2)
            places.append(np.einsum("gk,tkd->tgd", grid, both).reshape(-1, 6))
            owners.append(np.repeat(self.numbers[some], len(grid)))
        return cKDTree(np.concatenate(places)), np.concatenate(owners).astype(np.int32)

    def closest(self, points: Floats, normals: Floats) -> Closest:
        """The closest place of the surface to each point (q, 3), of those that face like its normal (q, 3)."""
        tree, owners = self._samples
        points, normals = (np.ascontiguousarray(a, dtype=np.float64) for a in (points, normals))
        _, found = tree.query(np.hstack([points, NORMAL_MM * normals]), k=min(_NEAREST, len(owners)))
        found = owners[np.atleast_2d(found.T).T]
        best = np.empty(len(points), dtype=np.int32)
        weights, cost = np.empty((len(points), 3)), np.empty(len(points))
        _measure(points, normals, found, self.vertices, self.normals, self.triangles, NORMAL_MM, best, weights, cost)
        corners = self.triangles[best]
        places = np.einsum("qk,qkd->qd", weights, self.vertices[corners])
        facing = np.einsum("qk,qkd->qd", weights, self.normals[corners])
        facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)
        return Closest(best, weights, places, facing, np.linalg.norm(points - places, axis=1), cost)


def _grid(count: int) -> Floats:
    """Barycentric coordinates of the middles of a triangle's ``count**2`` cells."""
    cells = []
    for i in range(count):
        for j in range(count - i):
            cells.append((i + 1 / 3, j + 1 / 3))
            if j < count - i - 1:
                cells.append((i + 2 / 3, j + 2 / 3))
    u, v = np.array(cells).T / count
    return np.stack([1 - u - v, u, v], axis=1)


@njit(cache=True)
def _measure(points, normals, found, vertices, facing, triangles, normal_mm, best, weights, cost):  # type: ignore[no-untyped-def]
    w = np.empty(3)
    for q in range(points.shape[0]):
        cost[q] = np.inf
        last = -1
        for k in range(found.shape[1]):
            t = found[q, k]
            if t == last:
                continue
            last = t
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            _barycentric(points[q], vertices[a], vertices[b], vertices[c], w)
            total = 0.0
            for axis in range(3):
                place = w[0] * vertices[a, axis] + w[1] * vertices[b, axis] + w[2] * vertices[c, axis]
                turn = w[0] * facing[a, axis] + w[1] * facing[b, axis] + w[2] * facing[c, axis]
                total += (points[q, axis] - place) ** 2 + (normal_mm * (normals[q, axis] - turn)) ** 2
            if total < cost[q]:
                cost[q] = total
                best[q] = t
                weights[q] = w


@njit(cache=True)
def _barycentric(p, a, b, c, out):  # type: ignore[no-untyped-def]
    """Weights of the corners at the closest point of a triangle."""
    ab, ac, ap = b - a, c - a, p - a
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    if d1 <= 0 and d2 <= 0:
        out[0], out[1], out[2] = 1.0, 0.0, 0.0
        return
    bp = p - b
    d3, d4 = _dot(ab, bp), _dot(ac, bp)
    if d3 >= 0 and d4 <= d3:
        out[0], out[1], out[2] = 0.0, 1.0, 0.0
        return
    vc = d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        s = d1 / (d1 - d3) if d1 - d3 > 0 else 0.0
        out[0], out[1], out[2] = 1 - s, s, 0.0
        return
    cp = p - c
    d5, d6 = _dot(ab, cp), _dot(ac, cp)
    if d6 >= 0 and d5 <= d6:
        out[0], out[1], out[2] = 0.0, 0.0, 1.0
        return
    vb = d5 * d2 - d1 * d6
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        s = d2 / (d2 - d6) if d2 - d6 > 0 else 0.0
        out[0], out[1], out[2] = 1 - s, 0.0, s
        return
    va = d3 * d6 - d5 * d4
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        total = (d4 - d3) + (d5 - d6)
        s = (d4 - d3) / total if total > 0 else 0.0
        out[0], out[1], out[2] = 0.0, 1 - s, s
        return
    total = va + vb + vc
    v, w = vb / total, vc / total
    out[0], out[1], out[2] = 1 - v - w, v, w


@njit(cache=True)
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
