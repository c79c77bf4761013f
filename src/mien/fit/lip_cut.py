"""Lips that a mesh holds together (a scan with a shut mouth): found, and cut apart along the mesh's own edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.face.contact import Seam
from mien.face.surface import edges_of

__all__ = ["cut_apart", "joined_share"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

_BINS, _FROM, _TO = 24, 0.08, 0.92  # of the mouth's width, from corner to corner
_NEAR_MM = 6.0


def joined_share(vertices: Floats, triangles: Indices, side: NDArray[np.int8], seam: Seam, skin: Floats) -> float:
    """Share of the mouth's width over which an edge of the mesh leads from the upper lip to the lower one.

    Parameters
    ----------
    vertices, triangles : ndarray
        The head.
    side : ndarray of int8, shape (n,)
        1 on the upper side of the mouth, -1 on the lower one, 0 elsewhere.
    seam : Seam
        The lips of the default skin, ``skin`` the fitted one.
    """
    edges = edges_of(triangles)
    across = edges[side[edges[:, 0]].astype(int) * side[edges[:, 1]] < 0]
    if not len(across):
        return 0.0
    line = (seam.upper @ skin + seam.lower @ skin) / 2
    low, high = line[:, 0].min(), line[:, 0].max()
    one, other = vertices[across[:, 0]], vertices[across[:, 1]]
    held = np.zeros(_BINS, dtype=np.bool_)
    for step in np.linspace(0, 1, 9):
        points = one + step * (other - one)
        away = np.linalg.norm(points[:, None, 1:] - _line_at(line, points[:, 0])[:, None], axis=2).min(axis=1)
        share = (points[:, 0] - low) / (high - low)
        inside = (away < _NEAR_MM) & (share > _FROM) & (share < _TO)
        held[((share[inside] - _FROM) / (_TO - _FROM) * _BINS).astype(int).clip(0, _BINS - 1)] = True
    return float(held.mean())


def _line_at(line: Floats, across: Floats) -> Floats:
    """Foremost places (y, z) of the seam at some x."""
    order = np.argsort(line[:, 0])
    bins = np.array_split(line[order], 40)
    front = np.array([part[np.argmax(part[:, 2])] for part in bins if len(part)])
    return np.stack([np.interp(across, front[:, 0], front[:, axis]) for axis in (1, 2)], axis=1)


def cut_apart(
    vertices: Floats, triangles: Indices, welded: Indices, side: NDArray[np.int8], corners: tuple[float, float]
) -> tuple[Indices, Indices, NDArray[np.int64], NDArray[np.int8]]:
    """Cut a mesh between the lips.

    Parameters
    ----------
    vertices, triangles, side
        As for `joined_share`; ``side`` is the same for vertices that are welded.
    welded : ndarray of int32, shape (n,)
        The vertex that stands for all that lie together.
    corners : tuple of float
        x of the right and the left corner of the mouth, mm.

    Returns
    -------
    triangles : ndarray of int32, shape (t, 3)
        The lower lip's use the new vertices along the cut.
    welded : ndarray of int32, shape (n + copies,)
    copied : ndarray of int64
        The vertices that the new ones, appended in this order, are copies of.
    side : ndarray of int8, shape (n + copies,)
        As given, made to agree with the cut.
    """
    joined, count = welded[triangles], len(vertices)
    belongs = side[joined].astype(int).sum(axis=1)
    labelled = (side[joined] != 0).all(axis=1)
    above, below = labelled & (belongs > 0), labelled & (belongs < 0)
    margin = 0.03 * (corners[1] - corners[0])
    inside = (vertices[:, 0] > corners[0] + margin) & (vertices[:, 0] < corners[1] - margin)
    touches = np.zeros((2, count), dtype=np.bool_)
    touches[0, np.unique(joined[above])], touches[1, np.unique(joined[below])] = True, True
    both = touches.all(axis=0) & inside
    copied = np.flatnonzero(both[welded] & (np.isin(np.arange(count), triangles[below]) | (welded == np.arange(count))))
    number = np.arange(count)
    number[copied] = count + np.arange(len(copied))
    out = triangles.copy()
    out[below] = number[triangles[below]]
    known = np.where(touches[0] & inside, 1, np.where(touches[1] & inside, -1, side))[welded]
    known = np.concatenate([known, np.full(len(copied), -1)]).astype(np.int8)
    stands = np.concatenate([welded, number[welded[copied]]]).astype(np.int32)
    return out.astype(np.int32), stands, copied, known
