"""Smooth random fields for paint: the same seed gives the same field."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.compiled import njit

__all__ = ["layered_noise", "smoothstep", "value_noise"]

_SIDE = 64

Floats = NDArray[np.float32]


def smoothstep(low: ArrayLike, high: ArrayLike, x: NDArray[np.floating]) -> NDArray[np.floating]:
    """0 below ``low``, 1 above ``high``, smooth between (``low`` may be the larger: then it falls)."""
    low = np.asarray(low)
    t = np.clip((x - low) / (np.asarray(high) - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def value_noise(points: NDArray[np.floating], scale: float, seed: int) -> Floats:
    """Value noise in -1..1 at points (n, 3); features are about ``scale`` across."""
    random = np.random.default_rng(seed)
    lattice = random.uniform(-1, 1, (_SIDE,) * 3).astype(np.float32)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]  # so that the lattice does not show
    out = np.empty(len(points), dtype=np.float32)
    _noise(np.ascontiguousarray(points, dtype=np.float32), (turn / scale).astype(np.float32), lattice, out)
    return out


def layered_noise(points: NDArray[np.floating], scale: float, seed: int, layers: int = 3) -> Floats:
    """Sum of value noise at halving scales and weights, about -1..1."""
    total = np.zeros(len(points), dtype=np.float32)
    for k in range(layers):
        total += value_noise(points, scale / 2**k, seed + 101 * k) / np.float32(2**k * (2 - 2 ** (1 - layers)))
    return total


@njit(cache=True, nogil=True)
def _noise(points, turn, lattice, out):  # type: ignore[no-untyped-def]
    side = lattice.shape[0]
    share, low = np.empty(3, np.float32), np.empty(3, np.int64)
    for n in range(len(points)):
        for k in range(3):
            place = points[n, 0] * turn[0, k] + points[n, 1] * turn[1, k] + points[n, 2] * turn[2, k]
            below = np.floor(place)
            t = place - below
            share[k] = t * t * t * (t * (6 * t - 15) + 10)
            low[k] = int(below)
        i, j, m = low[0] % side, low[1] % side, low[2] % side
        i1, j1, m1 = (i + 1) % side, (j + 1) % side, (m + 1) % side
        u, v, w = share[0], share[1], share[2]
        a = lattice[i, j, m] * (1 - u) + lattice[i1, j, m] * u
        b = lattice[i, j1, m] * (1 - u) + lattice[i1, j1, m] * u
        c = lattice[i, j, m1] * (1 - u) + lattice[i1, j, m1] * u
        d = lattice[i, j1, m1] * (1 - u) + lattice[i1, j1, m1] * u
        out[n] = (a * (1 - v) + b * v) * (1 - w) + (c * (1 - v) + d * v) * w
