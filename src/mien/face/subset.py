"""Parts of fewer vertices: which of a group stands for it, and what is left of a part."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.model import Part, Target

__all__ = ["nearest_to_middle", "subset", "without_flat"]

Indices = NDArray[np.integer[Any]]


def nearest_to_middle(vertices: NDArray[np.float32], group: Indices) -> NDArray[np.intp]:
    """Of each group (numbers from 0 on, none missing) the vertex nearest to the middle of its vertices (n, 3)."""
    size = np.bincount(group)
    middle = np.stack([np.bincount(group, vertices[:, k]) for k in range(3)], axis=1) / size[:, None]
    order = np.lexsort((((vertices - middle[group]) ** 2).sum(axis=1), group))
    return np.asarray(order[np.cumsum(size) - size])


def without_flat(triangles: Indices) -> Indices:
    """The triangles (n, 3) whose corners are three different ones."""
    a, b, c = triangles.T
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])


def subset(part: Part, order: Indices, triangles: Indices) -> Part:
    """The part with these of its vertices in this order, and triangles by their new numbers."""
    place = np.full(len(part.vertices), -1)
    place[order] = np.arange(len(order))
    targets = {}
    for name, target in part.targets.items():
        there = place[target.vertices]
        targets[name] = Target(there[there >= 0].astype(np.int32), target.offsets[there >= 0])
    return replace(
        part,
        vertices=part.vertices[order],
        triangles=np.ascontiguousarray(triangles, dtype=np.int32),
        uv=part.uv[order],
        colours=part.colours[order],
        head_weight=part.head_weight[order],
        targets=targets,
    )
