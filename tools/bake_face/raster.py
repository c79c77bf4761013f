"""Filling triangles on a grid: for height fields, shadows and paint."""

from __future__ import annotations

import numpy as np
from makehuman import Floats, Ints
from numba import njit


@njit(cache=False)
def _fill(places: Floats, depth: Floats, triangles: Ints, nearest: Floats, index: Ints, shares: Floats) -> None:
    height, width = nearest.shape
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        x0, y0, x1, y1, x2, y2 = places[a, 0], places[a, 1], places[b, 0], places[b, 1], places[c, 0], places[c, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if abs(area) < 1e-12:
            continue
        for row in range(max(0, int(min(y0, y1, y2) - 0.5)), min(height - 1, int(max(y0, y1, y2) + 0.5)) + 1):
            for column in range(max(0, int(min(x0, x1, x2) - 0.5)), min(width - 1, int(max(x0, x1, x2) + 0.5)) + 1):
                px, py = column + 0.5, row + 0.5
                u = ((x1 - px) * (y2 - py) - (x2 - px) * (y1 - py)) / area
                v = ((x2 - px) * (y0 - py) - (x0 - px) * (y2 - py)) / area
                w = 1 - u - v
                if u < -1e-6 or v < -1e-6 or w < -1e-6:
                    continue
                d = u * depth[a] + v * depth[b] + w * depth[c]
                if d > nearest[row, column]:
                    nearest[row, column] = d
                    index[row, column] = t
                    shares[row, column, 0] = u
                    shares[row, column, 1] = v
                    shares[row, column, 2] = w


def rasterise(places: Floats, depth: Floats, triangles: Ints, height: int, width: int) -> tuple[Floats, Ints, Floats]:
    """Cover a grid of cells by triangles; the greatest depth wins.

    Parameters
    ----------
    places : ndarray, shape (n, 2)
        Column and row of each vertex in cells; cell (r, c) has its centre at (c + 0.5, r + 0.5).
    depth : ndarray, shape (n,)

    Returns
    -------
    depth (height, width; -inf where nothing is), triangle index (-1 where nothing is), barycentric shares (..., 3).
    """
    nearest = np.full((height, width), -np.inf)
    index = np.full((height, width), -1, np.int64)
    shares = np.zeros((height, width, 3))
    _fill(np.ascontiguousarray(places, float), np.ascontiguousarray(depth, float), triangles, nearest, index, shares)
    return nearest, index, shares


def openness(vertices: Floats, normals: Floats, triangles: Ints, directions: int = 160, cells: int = 320) -> Floats:
    """How much of the sky each vertex sees, 0 shut .. 1 open (ambient occlusion by shadow maps from all round)."""
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(directions)
    rise = 1 - 2 * (np.arange(directions) + 0.5) / directions
    sky = np.stack([np.sqrt(1 - rise**2) * np.cos(turn), rise, np.sqrt(1 - rise**2) * np.sin(turn)], axis=1)
    seen = np.zeros(len(vertices))
    whole = np.zeros(len(vertices))
    centre = vertices.mean(0)
    reach = np.linalg.norm(vertices - centre, axis=1).max() * 1.01
    for towards in sky:
        aside = np.cross(towards, [0.31, 0.2, 0.93])
        aside /= np.linalg.norm(aside)
        across = np.cross(towards, aside)
        lifted = vertices + 0.8 * normals - centre
        flat = np.stack([(vertices - centre) @ aside, (vertices - centre) @ across], axis=1)
        nearest, _, _ = rasterise(
            (flat / reach + 1) * cells / 2, (vertices - centre) @ towards, triangles, cells, cells
        )
        place = ((np.stack([lifted @ aside, lifted @ across], axis=1) / reach + 1) * cells / 2).astype(int)
        place = np.clip(place, 0, cells - 1)
        weight = np.maximum(normals @ towards, 0)
        clear = lifted @ towards >= nearest[place[:, 1], place[:, 0]] - 0.9
        seen += weight * clear
        whole += weight
    return seen / np.maximum(whole, 1e-9)
