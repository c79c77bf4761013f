"""Bringing two edges that face each other (lips, eyelids) exactly together, at rest and in the shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from makehuman import Floats, Ints
from raster import rasterise
from scipy.sparse.csgraph import dijkstra

_CELL = 0.25  # mm
_ROUNDS = 6
_MOST = 8.0  # mm that one round moves an edge


@dataclass
class Edges:
    """An upper and a lower edge that can meet.

    Attributes
    ----------
    upper, lower : ndarray, shape (t,)
        Triangles of the two sides near the edge.
    upper_pull, lower_pull : ndarray, shape (n,)
        How much a vertex follows its edge: 1 on it, falling to 0 away from it.
    corners : tuple of int
        The vertices where the edges end; nothing is measured beyond them.
    columns : bool
        Measure the gap between surfaces above one another (lips) rather than between the lowest and the highest
        point at the same x (lids, of which one may pass in front of the other).
    """

    triangles: Ints
    upper: Ints
    lower: Ints
    upper_pull: Floats
    lower_pull: Floats
    corners: tuple[int, int]
    columns: bool

    def gap(self, vertices: Floats) -> tuple[Floats, Floats]:
        """Places x and the gap there in millimetres (negative: overlap), where both edges are."""
        used = np.unique(self.triangles[np.r_[self.upper, self.lower]])
        low, high = vertices[used].min(0) - 1, vertices[used].max(0) + 1
        width, depth = (int(np.ceil((high[k] - low[k]) / _CELL)) for k in (0, 2))
        places = (vertices[:, [0, 2]] - low[[0, 2]]) / _CELL
        under, _, _ = rasterise(places, -vertices[:, 1], self.triangles[self.upper], depth, width)
        over, _, _ = rasterise(places, vertices[:, 1], self.triangles[self.lower], depth, width)
        if self.columns:
            both = np.isfinite(under) & np.isfinite(over)
            gap = np.where(both, -under - over, np.inf).min(0)
        else:
            gap = -under.max(0) - over.max(0)
        x = low[0] + (np.arange(width) + 0.5) * _CELL
        ends = np.sort(vertices[list(self.corners), 0])
        there = np.isfinite(gap) & (x > ends[0]) & (x < ends[1])
        return x[there], gap[there]

    def closing(self, vertices: Floats, wanted: float, at_corners: float = 0.0, smooth: float = 2.0) -> Floats:
        """Offsets (n, 3), straight up and down, that bring the gap to ``wanted``, plus ``at_corners`` by the corners.

        ``smooth`` is the width in millimetres over which one round evens out along the edge.
        """
        side = int(smooth / _CELL)
        kernel = np.hanning(2 * side + 1)
        kernel /= kernel.sum()
        moved = vertices.copy()
        for _ in range(_ROUNDS):
            x, gap = self.gap(moved)
            if len(x) < 8:
                break
            aside = np.abs(2 * (x - x[0]) / (x[-1] - x[0]) - 1) ** 4
            padded = np.pad(np.clip(gap - wanted - at_corners * aside, -_MOST, _MOST), side, mode="edge")
            excess = np.convolve(padded, kernel, mode="valid")
            at = np.interp(moved[:, 0], x, excess)
            beyond = np.maximum(np.maximum(x[0] - moved[:, 0], moved[:, 0] - x[-1]), 0)
            at = at * np.exp(-((beyond / 2.0) ** 2))
            moved[:, 1] += (self.lower_pull - self.upper_pull) * at / 2
        return moved - vertices


def geodesic(vertices: Floats, triangles: Ints, seeds: Ints) -> Floats:
    """Distance along the mesh's edges from the nearest seed, shape (n,), millimetres."""
    sides = np.vstack([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    length = np.linalg.norm(vertices[sides[:, 0]] - vertices[sides[:, 1]], axis=1)
    n = len(vertices)
    graph = sparse.csr_matrix((length, (sides[:, 0], sides[:, 1])), (n, n)).maximum(
        sparse.csr_matrix((length, (sides[:, 1], sides[:, 0])), (n, n))
    )
    return np.asarray(dijkstra(graph, directed=False, indices=seeds, min_only=True))


def split_loop(vertices: Floats, loop: Ints) -> tuple[Ints, Ints, tuple[int, int]]:
    """The upper and the lower half of a closed curve about an opening, and its two corners."""
    left, right = int(np.argmax(vertices[loop][:, 0])), int(np.argmin(vertices[loop][:, 0]))
    rolled = np.roll(loop, -left)
    cut = (right - left) % len(loop)
    one, other = rolled[1:cut], rolled[cut + 1 :]
    if vertices[one][:, 1].mean() < vertices[other][:, 1].mean():
        one, other = other, one
    return one, other, (int(loop[left]), int(loop[right]))


def edges_between(vertices: Floats, triangles: Ints, loop: Ints, reach: float, pull: float, columns: bool) -> Edges:
    """Edges from the loop along them: triangles within ``reach`` mm, and a pull that falls off over ``pull`` mm."""
    upper_seeds, lower_seeds, corners = split_loop(vertices, loop)
    to_upper = geodesic(vertices, triangles, upper_seeds)
    to_lower = geodesic(vertices, triangles, lower_seeds)
    near_upper, near_lower = (distance[triangles].mean(1) for distance in (to_upper, to_lower))
    share = np.clip(0.5 + (to_lower - to_upper) / 4, 0, 1)
    return Edges(
        triangles,
        np.flatnonzero((near_upper < reach) & (near_upper < near_lower)),
        np.flatnonzero((near_lower < reach) & (near_lower < near_upper)),
        np.exp(-((to_upper / pull) ** 2)) * share,
        np.exp(-((to_lower / pull) ** 2)) * (1 - share),
        corners,
        columns,
    )
