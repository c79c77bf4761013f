"""Normals of a surface: the area-weighted mean of the triangles around each vertex, from the ring of its neighbours.

The doubled area vectors of the triangles (v, p, q) around a vertex v add up to that of the polygon p0, p1, ... of its
neighbours: in a closed ring v itself cancels, in an open one it is a corner of the polygon. A polygon of 2n + 2 points
is n quadrilaterals with one corner in common, and that of a quadrilateral is the cross product of its diagonals: two
products for the usual six triangles, nothing to add up in memory. Vertices are sorted by n, so that the loops run
alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["Rings", "normals_of", "ring_normals", "rings_of"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int32]

_MOST_CHAINED = 128  # edges around one vertex; more, in a mesh of a hub and spokes, are taken one by one


@dataclass(frozen=True, eq=False)
class Rings:
    """The polygons around vertices, sorted by their number of quadrilaterals.

    Attributes
    ----------
    vertex : ndarray of int32, shape (m,)
        Whose normals these are.
    start : ndarray of int32, shape (m + 1,)
        Where the points of each begin in ``points``; 2n + 2 of them, none for a vertex without triangles.
    points : ndarray of int32, shape (p,)
    twins : ndarray of int32, shape (t, 2)
        Vertices that take the normal of another one.
    """

    vertex: Indices
    start: Indices
    points: Indices
    twins: Indices

    def of(self, chosen: NDArray[np.bool_]) -> Rings:
        """Those of chosen vertices only (vertices,); twins are chosen together."""
        kept, sizes = chosen[self.vertex], np.diff(self.start)
        start = np.concatenate([[0], np.cumsum(sizes[kept])]).astype(np.int32)
        points = self.points[np.repeat(kept, sizes)]
        return Rings(self.vertex[kept], start, points, self.twins[chosen[self.twins[:, 0]]])


def rings_of(triangles: Indices, welded: Indices) -> Rings:
    """The rings of a surface.

    Parameters
    ----------
    triangles : ndarray of int32, shape (t, 3)
        Of any kind: with holes, with edges of three triangles, with sheets that touch at a point.
    welded : ndarray of int32, shape (n,)
        For each vertex the one that it shares its normal with (`mien.face.posing.welded_vertices`), which has itself.
    """
    count, corner = len(welded), welded[triangles.reshape(-1, 3)]
    # One line for each corner: its vertex, and the edge across from it.
    lines = np.concatenate([corner, corner[:, [1, 2, 0]], corner[:, [2, 0, 1]]])
    lines = np.ascontiguousarray(lines[np.argsort(lines[:, 0], kind="stable")])
    first = np.searchsorted(lines[:, 0], np.arange(count + 1)).astype(np.int32)
    size, points = np.zeros(count, np.int32), np.empty(5 * len(lines), np.int32)
    _walk(lines, first, size, points)
    begin = 5 * first[:-1].astype(np.int64)
    own = np.flatnonzero(welded == np.arange(count))
    own = own[np.argsort(size[own], kind="stable")]
    start = np.concatenate([[0], np.cumsum(size[own])]).astype(np.int32)
    places = np.repeat(begin[own] - start[:-1], size[own]) + np.arange(start[-1])
    others = np.flatnonzero(welded != np.arange(count))
    twins = np.stack([others, welded[others]], axis=1)
    return Rings(own.astype(np.int32), start, points[places], twins.astype(np.int32))


def normals_of(vertices: Floats, triangles: Indices, welded: Indices) -> Floats:
    """Unit normals (n, 3) of vertices (n, 3) as they stand; +z where there are no triangles, or only flat ones."""
    rings, normals = rings_of(triangles, welded), np.empty_like(vertices)
    ring_normals(vertices, rings.vertex, rings.start, rings.points, rings.twins, normals)
    return normals


@njit(cache=True, error_model="numpy", nogil=True)
def ring_normals(vertices, listed, start, points, twins, normals):  # type: ignore[no-untyped-def]
    """Fill ``normals`` at the vertices of `Rings` and at their twins."""
    for i in range(listed.shape[0]):
        at, quads, v = np.uint64(start[i]), (start[i + 1] - start[i]) // 2 - 1, listed[i]
        x = y = z = np.float32(0.0)
        if quads > 0:
            o, a = np.uint64(points[at]), np.uint64(points[at + np.uint64(1)])
            ox, oy, oz = vertices[o, 0], vertices[o, 1], vertices[o, 2]
            ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
            for _ in range(quads):
                at += np.uint64(2)
                b, c = np.uint64(points[at]), np.uint64(points[at + np.uint64(1)])
                cx, cy, cz = vertices[c, 0], vertices[c, 1], vertices[c, 2]
                ux, uy, uz = vertices[b, 0] - ox, vertices[b, 1] - oy, vertices[b, 2] - oz
                wx, wy, wz = cx - ax, cy - ay, cz - az
                x += uy * wz - uz * wy
                y += uz * wx - ux * wz
                z += ux * wy - uy * wx
                ax, ay, az = cx, cy, cz
        squared = x * x + y * y + z * z
        if squared > 0.0:
            share = np.float32(1.0) / np.sqrt(squared)
            normals[v, 0], normals[v, 1], normals[v, 2] = x * share, y * share, z * share
        else:
            normals[v, 0] = normals[v, 1] = 0.0
            normals[v, 2] = 1.0
    for i in range(twins.shape[0]):
        v, w = twins[i, 0], twins[i, 1]
        normals[v, 0], normals[v, 1], normals[v, 2] = normals[w, 0], normals[w, 1], normals[w, 2]


@njit(cache=True, error_model="numpy", nogil=True)
def _walk(lines, first, size, points):  # type: ignore[no-untyped-def]
    """Chain the edges (columns 1 and 2 of ``lines``) across from each vertex into one polygon.

    Chains are joined by ways there and back, which cancel. Of k edges it has at most 5 k - 1 points.
    """
    used = np.zeros(lines.shape[0], np.bool_)
    for v in range(first.shape[0] - 1):
        begin, end, at = first[v], first[v + 1], 5 * np.int64(first[v])
        origin, zero = np.int64(-1), at
        chained = end - begin <= _MOST_CHAINED
        for k in range(end - begin):
            edge = _next_chain(lines, used, begin, end) if chained else begin + k
            if edge < 0:
                break
            if origin >= 0:
                points[at] = origin
                at += 1
            head = at
            points[at], to = lines[edge, 1], lines[edge, 1]
            at += 1
            while edge >= 0:
                used[edge], to = True, lines[edge, 2]
                points[at], edge = to, -1
                at += 1
                for e in range(begin, end if chained else begin):
                    if not used[e] and lines[e, 1] == to:
                        edge = e
                        break
            if to == points[head]:
                at -= 1
            else:
                points[at] = v
                at += 1
            if origin < 0:
                origin = points[head]
            else:
                points[at] = points[head]
                at += 1
        if (at - zero) % 2:
            points[at] = points[at - 1]
            at += 1
        size[v] = at - zero


@njit(cache=True, error_model="numpy", nogil=True)
def _next_chain(lines, used, begin, end):  # type: ignore[no-untyped-def]
    """An edge that none leads to, which begins an open chain; else any that is left, of a closed one; else -1."""
    edge = -1
    for e in range(begin, end):
        if used[e]:
            continue
        led = False
        for other in range(begin, end):
            led |= (not used[other]) & (lines[other, 2] == lines[e, 1])
        if not led:
            return e
        edge = e if edge < 0 else edge
    return edge
