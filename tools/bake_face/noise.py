"""Smooth random fields for paint: the same seed gives the same field."""

from __future__ import annotations

import numpy as np
from makehuman import Floats

_SIDE = 64


def _turn(axes: int, seed: int) -> Floats:
    """A random turn of the axes, so that the lattice does not show."""
    return np.asarray(np.linalg.qr(np.random.default_rng(seed + 1000).normal(size=(axes, axes)))[0])


def value_noise(points: Floats, scale: float, seed: int) -> Floats:
    """Value noise in -1..1 at points (n, 2) or (n, 3); features are about ``scale`` across in every direction."""
    lattice = np.random.default_rng(seed).uniform(-1, 1, (_SIDE,) * points.shape[1])
    place = points @ _turn(points.shape[1], seed) / scale
    low = np.floor(place).astype(int)
    share = place - low
    share = share**3 * (share * (6 * share - 15) + 10)
    total = np.zeros(len(points))
    for corner in np.ndindex((2,) * points.shape[1]):
        weight = np.prod(np.where(np.array(corner), share, 1 - share), axis=1)
        index = tuple(((low[:, axis] + step) % _SIDE) for axis, step in enumerate(corner))
        total += weight * lattice[index]
    return np.asarray(total)


def layered_noise(points: Floats, scale: float, seed: int, layers: int = 4) -> Floats:
    """Sum of value noise at halving scales and weights, about -1..1."""
    parts = [value_noise(points, scale / 2**k, seed + k) / 2**k for k in range(layers)]
    return np.asarray(np.sum(parts, axis=0) / (2 - 2 ** (1 - layers)))
