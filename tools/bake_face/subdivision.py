"""One Catmull-Clark step as a sparse matrix, and clipping of triangles, so that rest and targets take the same way."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def _edges(quads: Ints) -> tuple[Ints, Ints, Ints]:
    """Unique edges (e, 2), the edge of each quad's side (f, 4), and how many quads each edge has (e,)."""
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    return edges, inverse.reshape(-1, 4), count


def _matrix(values: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> sparse.csr_matrix:
    return sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape)


def catmull_clark(vertex_count: int, quads: Ints) -> tuple[sparse.csr_matrix, Ints]:
    """Matrix from coarse to fine vertices and the fine quads (Catmull and Clark 1978).

    The fine vertices are the coarse ones, then one per edge, then one per face. Border edges are kept as curves.
    """
    n, f = vertex_count, len(quads)
    edges, side_edge, quads_of_edge = _edges(quads)
    m = len(edges)
    border = quads_of_edge == 1
    face_rows = np.repeat(np.arange(f), 4)
    face_points = _matrix(np.full(4 * f, 0.25), face_rows, quads, (f, n))
    midpoints = _matrix(np.full(2 * m, 0.5), np.repeat(np.arange(m), 2), edges, (m, n))
    faces_at_edge = _matrix(np.ones(4 * f), side_edge, face_rows, (m, f))
    inner_edge = sparse.diags(np.where(border, 0.0, 0.5))
    edge_points = (
        inner_edge @ midpoints
        + sparse.diags(np.where(border, 0.0, 0.25)) @ faces_at_edge @ face_points
        + sparse.diags(np.where(border, 1.0, 0.0)) @ midpoints
    )
    vertex_points = _vertex_rule(n, quads, edges, border, face_points, midpoints)
    matrix = sparse.vstack([vertex_points, edge_points, face_points]).tocsr()
    centre = np.broadcast_to((n + m + np.arange(f))[:, None], (f, 4))
    fine = np.stack([quads, n + side_edge, centre, n + np.roll(side_edge, 1, axis=1)], axis=2).reshape(-1, 4)
    return matrix, fine


def _vertex_rule(
    n: int,
    quads: Ints,
    edges: Ints,
    border: NDArray[np.bool_],
    face_points: sparse.csr_matrix,
    midpoints: sparse.csr_matrix,
) -> sparse.csr_matrix:
    f, m = len(quads), len(edges)
    at_face = _matrix(np.ones(4 * f), quads, np.repeat(np.arange(f), 4), (n, f))
    at_edge = _matrix(np.ones(2 * m), edges, np.repeat(np.arange(m), 2), (n, m))
    faces = np.maximum(np.asarray(at_face.sum(1)).ravel(), 1)
    valence = np.maximum(np.asarray(at_edge.sum(1)).ravel(), 1)
    inner = (
        sparse.diags(1 / faces / valence) @ at_face @ face_points
        + sparse.diags(2 / valence**2) @ at_edge @ midpoints
        + sparse.diags((valence - 3) / valence)
    )
    at_border = at_edge @ sparse.diags(border.astype(float))
    border_edges = np.asarray(at_border.sum(1)).ravel()
    along = sparse.diags(0.5 / np.maximum(border_edges, 1)) @ at_border @ midpoints + sparse.identity(n) * 0.5
    on_border = border_edges > 0
    return sparse.diags((~on_border).astype(float)) @ inner + sparse.diags(on_border.astype(float)) @ along


def triangulate(quads: Ints) -> Ints:
    """Two triangles per quad."""
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def clip(triangles: Ints, height: Floats) -> tuple[sparse.csr_matrix, Ints]:
    """Keep the part of a mesh where ``height`` is above zero, with a clean new edge where it is zero.

    Returns the matrix from the old vertices to the kept and the new ones, and the triangles on those.
    """
    n = len(height)
    inside = height > 0
    new: dict[tuple[int, int], int] = {}

    def cut(a: int, b: int) -> int:
        return new.setdefault((a, b) if inside[a] else (b, a), n + len(new))

    kept: list[tuple[int, int, int]] = []
    for triangle in triangles:
        a, b, c = (int(v) for v in triangle)
        count = int(inside[triangle].sum())
        if count == 3:
            kept.append((a, b, c))
        elif count == 1:
            while not inside[a]:
                a, b, c = b, c, a
            kept.append((a, cut(a, b), cut(a, c)))
        elif count == 2:
            while inside[a]:
                a, b, c = b, c, a
            kept += [(b, c, cut(b, a)), (cut(b, a), c, cut(c, a))]
    rows = [sparse.identity(n, format="csr")]
    if new:
        ends = np.array(list(new))
        share = (height[ends[:, 0]] / (height[ends[:, 0]] - height[ends[:, 1]]))[:, None]
        index = np.repeat(np.arange(len(ends)), 2)
        rows.append(_matrix(np.hstack([1 - share, share]), index, ends, (len(ends), n)))
    matrix = sparse.vstack(rows).tocsr()
    used, renumbered = np.unique(np.array(kept), return_inverse=True)
    return matrix[used], renumbered.reshape(-1, 3)
