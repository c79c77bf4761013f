"""Triangles drawn into grids: which place of a surface each cell shows. Compiled loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["Grid", "draw_triangles", "sample"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Grid:
    """What the cells show: the triangle (-1: none), the weights of its corners, and the depth (infinite: none)."""

    triangle: NDArray[np.int32]  # (height, width)
    weights: NDArray[np.float32]  # (height, width, 3)
    depth: NDArray[np.float64]  # (height, width)


def draw_triangles(places: Floats, depth: Floats, triangles: NDArray[np.int32], height: int, width: int) -> Grid:
    """Draw triangles; of several in one cell the one of least depth shows.

    Parameters
    ----------
    places : ndarray, shape (n, 2)
        Column and row of each vertex in cells; cell (r, c) has its middle at (c + 0.5, r + 0.5).
    depth : ndarray, shape (n,)
        Vertices of depth 0 or less are behind the camera; their triangles are left out.
    triangles : ndarray of int32, shape (t, 3)
    height, width : int
    """
    nearest = np.full((height, width), np.inf)
    index = np.full((height, width), -1, dtype=np.int32)
    weights = np.zeros((height, width, 3), dtype=np.float32)
    _draw(np.ascontiguousarray(places), np.ascontiguousarray(depth), triangles, nearest, index, weights)
    return Grid(index, weights, nearest)


@njit(cache=True)
def _draw(places, depth, triangles, nearest, index, weights):  # type: ignore[no-untyped-def]
    height, width = nearest.shape
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        if depth[a] <= 0 or depth[b] <= 0 or depth[c] <= 0:
            continue
        x0, y0, x1, y1 = places[a, 0], places[a, 1], places[b, 0], places[b, 1]
        x2, y2 = places[c, 0], places[c, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if abs(area) < 1e-12:
            continue
        top, bottom = max(0, int(np.floor(min(y0, y1, y2) - 0.5))), min(height - 1, int(np.ceil(max(y0, y1, y2))))
        left, right = max(0, int(np.floor(min(x0, x1, x2) - 0.5))), min(width - 1, int(np.ceil(max(x0, x1, x2))))
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                px, py = column + 0.5, row + 0.5
                u = ((x1 - px) * (y2 - py) - (x2 - px) * (y1 - py)) / area
                v = ((x2 - px) * (y0 - py) - (x0 - px) * (y2 - py)) / area
                w = 1 - u - v
                if u < -1e-6 or v < -1e-6 or w < -1e-6:
                    continue
                d = u * depth[a] + v * depth[b] + w * depth[c]
                if d < nearest[row, column]:
                    nearest[row, column] = d
                    index[row, column] = t
                    weights[row, column, 0] = u
                    weights[row, column, 1] = v
                    weights[row, column, 2] = w


def sample(picture: NDArray[np.float32], places: Floats) -> NDArray[np.float32]:
    """Bilinear samples (n, c) of a picture (height, width, c) at columns and rows (n, 2); held at its edges."""
    height, width = picture.shape[:2]
    x = np.clip(places[:, 0] - 0.5, 0, width - 1.001)
    y = np.clip(places[:, 1] - 0.5, 0, height - 1.001)
    column, row = x.astype(np.int64), y.astype(np.int64)
    u, v = (x - column)[:, None].astype(np.float32), (y - row)[:, None].astype(np.float32)
    column2, row2 = np.minimum(column + 1, width - 1), np.minimum(row + 1, height - 1)
    top = picture[row, column] * (1 - u) + picture[row, column2] * u
    bottom = picture[row2, column] * (1 - u) + picture[row2, column2] * u
    return np.asarray(top * (1 - v) + bottom * v, dtype=np.float32)
