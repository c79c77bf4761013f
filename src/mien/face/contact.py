"""Edges that meet (lips, lids) on a face made from the default one, measured at pairs of points and brought together.

A pair is an upper and a lower vertex that face each other where the default face's edges meet: lips at rest, lids in a
blink. In a pose in which the default's pair lies ``g0`` apart (up is positive, overlap negative), a fitted face's pair
should lie ``g0`` apart too; what is more is its gap.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from mien.face.head_space import SKIN, HeadSpace, head_space
from mien.face.surface import edges_of

__all__ = ["Seam", "dense_targets", "distance_along", "lid_seam", "lip_seam", "split_loop"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_BINS = 96
_PINCH_MM = 1.2
_TOUCH_MM = 2.5  # lips nearer than this at rest touch


@dataclass(frozen=True, eq=False)
class Seam:
    """Two edges that meet.

    Attributes
    ----------
    upper, lower : csr_matrix, shape (p, n)
        From the mesh's vertices to the points of the pairs (single vertices on the default skin).
    upper_pull, lower_pull : ndarray, shape (n,)
        How much of the closing each vertex takes: 1 (or a half, where both edges move) at the edge, falling to 0 away.
    """

    upper: sparse.csr_matrix
    lower: sparse.csr_matrix
    upper_pull: Floats
    lower_pull: Floats

    def gaps(self, vertices: Floats) -> Floats:
        """How far each pair stands apart in height, mm, shape (p,); negative: overlap."""
        return np.asarray((self.upper @ vertices - self.lower @ vertices)[:, 1])

    def across(self, vertices: Floats) -> Floats:
        """Where each pair is from side to side, mm, shape (p,)."""
        return np.asarray((self.upper @ vertices + self.lower @ vertices)[:, 0] / 2)

    def closing(self, vertices: Floats, wanted: Floats, smooth_mm: float = 2.5, most_mm: float = 12.0) -> Floats:
        """Offsets (n, 3), up and down, that bring the pairs of posed vertices to the wanted gaps."""
        moved = vertices.copy()
        for _ in range(4):
            excess = np.clip(self.gaps(moved) - wanted, -most_mm, most_mm)
            where = self.across(moved)
            low, high = where.min(), where.max()
            places = np.linspace(low, high, _BINS)
            along = np.interp(places, *_averaged(where, excess, places))
            along = gaussian_filter1d(along, smooth_mm / max((high - low) / _BINS, 1e-6), mode="nearest")
            at = np.interp(moved[:, 0], places, along)
            beyond = np.maximum(np.maximum(low - moved[:, 0], moved[:, 0] - high), 0.0)
            at *= np.exp(-((beyond / 3.0) ** 2))
            moved[:, 1] += (self.lower_pull - self.upper_pull) * at
        return moved - vertices

    def pinching(self, vertices: Floats, wanted: Floats) -> Floats:
        """Offsets (n, 3), up and down, that bring single pairs together which `closing` left too far apart.

        Each draws what lies within some millimetres along, however fine the mesh is.
        """
        moved = vertices.copy()
        for sign, half, pull in ((-1, self.upper, self.upper_pull), (1, self.lower, self.lower_pull)):
            near = np.flatnonzero(pull > 0.02)
            if len(near):
                about = cKDTree(vertices[near]).sparse_distance_matrix(
                    cKDTree(half @ vertices), 3 * _PINCH_MM, output_type="coo_matrix"
                )
                weight = np.exp(-((about.data / _PINCH_MM) ** 2))
                spread = sparse.csr_matrix((weight, (about.row, about.col)), (len(near), half.shape[0]))
                total = np.maximum(np.asarray(spread.sum(axis=1)).ravel(), 0.3)
                share = pull[near] / max(float(pull.max()), 1e-9) / total
                for _ in range(4):
                    excess = np.maximum(self.gaps(moved) - wanted, 0.0)
                    moved[near, 1] += sign * 0.7 * share * (spread @ excess)
        return moved - vertices


def _averaged(where: Floats, values: Floats, places: Floats) -> tuple[Floats, Floats]:
    """Means of the values in the bins between places, where there are any."""
    number = np.clip(np.searchsorted(places, where) - 1, 0, len(places) - 2)
    count = np.bincount(number, minlength=len(places) - 1)
    total = np.bincount(number, values, len(places) - 1)
    there = count > 0
    middle = (places[:-1] + places[1:]) / 2
    return middle[there], total[there] / count[there]


def _chosen(numbers: Indices, count: int) -> sparse.csr_matrix:
    return sparse.csr_matrix((np.ones(len(numbers)), (np.arange(len(numbers)), numbers)), (len(numbers), count))


def distance_along(vertices: Floats, triangles: NDArray[np.int32], seeds: Indices, limit: float = np.inf) -> Floats:
    """Distance along the mesh's edges from the nearest seed, shape (n,), mm; infinite beyond the limit."""
    edges = edges_of(triangles)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    graph = sparse.csr_matrix((length, (edges[:, 0], edges[:, 1])), (len(vertices), len(vertices)))
    return np.asarray(dijkstra(graph, directed=False, indices=seeds, min_only=True, limit=limit))


def split_loop(vertices: Floats, loop: Indices) -> tuple[Indices, Indices, tuple[int, int]]:
    """The upper and the lower half of a closed curve about an opening, and its left and right corner."""
    left, right = int(np.argmax(vertices[loop][:, 0])), int(np.argmin(vertices[loop][:, 0]))
    rolled = np.roll(loop, -left)
    cut = (right - left) % len(loop)
    one, other = rolled[1:cut], rolled[cut + 1 :]
    if vertices[one][:, 1].mean() < vertices[other][:, 1].mean():
        one, other = other, one
    return one, other, (int(loop[left]), int(loop[right]))


def dense_targets(space: HeadSpace) -> dict[str, Floats]:
    """Offsets (n, 3) of the default skin's targets by name."""
    dense = {}
    for name, target in space.skin.targets.items():
        offsets = np.zeros_like(space.rest)
        offsets[target.vertices] = target.offsets
        dense[name] = offsets
    return dense


@cache
def lip_seam() -> Seam:
    """Where the default face's lips lie on each other at rest."""
    space = head_space()
    upper_half, lower_half, _ = split_loop(space.rest, space.lip_loop.astype(np.int64))
    to_upper = distance_along(space.rest, space.triangles, upper_half)
    to_lower = distance_along(space.rest, space.triangles, lower_half)
    share = np.clip(0.5 + (to_lower - to_upper) / 4, 0, 1)
    above = np.flatnonzero((to_upper < 9.0) & (to_upper < to_lower - 1.0))
    below = np.flatnonzero((to_lower < 9.0) & (to_lower < to_upper - 1.0))
    away = np.linalg.norm(space.rest[above][:, None] - space.rest[below][None], axis=2)
    mate = away.argmin(axis=1)
    touching = away[np.arange(len(above)), mate] < _TOUCH_MM
    return Seam(
        _chosen(above[touching], len(space.rest)),
        _chosen(below[mate[touching]], len(space.rest)),
        np.exp(-((to_upper / 7.0) ** 2)) * share / 2,
        np.exp(-((to_lower / 7.0) ** 2)) * (1 - share) / 2,
    )


@cache
def lid_seam(side: str) -> Seam:
    """The margins of one eye's lids; the upper lid does the closing. ``side`` is "Left" or "Right"."""
    space = head_space()
    loop = (space.lid_loop_left if side == "Left" else space.lid_loop_right).astype(np.int64)
    upper, lower, _ = split_loop(space.rest, loop)
    offsets = np.zeros_like(space.rest)
    blink = space.face.part(SKIN).targets["eyeBlink" + side]
    offsets[blink.vertices] = blink.offsets
    shut = space.rest + offsets
    mate = np.abs(shut[upper][:, None, 0] - shut[lower][None, :, 0]).argmin(axis=1)
    to_upper = distance_along(space.rest, space.triangles, upper)
    to_lower = distance_along(space.rest, space.triangles, lower)
    share = np.clip(0.5 + (to_lower - to_upper) / 4, 0, 1)
    count = len(space.rest)
    pull = np.exp(-((to_upper / 6.0) ** 2)) * share
    return Seam(_chosen(upper, count), _chosen(lower[mate], count), pull, np.zeros(count))
