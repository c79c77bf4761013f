"""A second face with a known truth: the default one bent to other proportions, cut, its vertices shuffled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.face.model import Face, Part, Target


def bend(points: np.ndarray) -> np.ndarray:
    """Other proportions, smoothly: broad jaw, long face, short nose, eyes closer together, lips lower and fuller."""
    x, y, z = np.asarray(points, dtype=np.float64).T
    broad = 1.06 + 0.14 * np.exp(-(((y + 80) / 45) ** 2))
    near = 1 - 0.07 * np.exp(-((y / 25) ** 2))
    tall = y * (1.08 + 0.05 * np.tanh(-(y + 20) / 60))
    nose = -5.0 * np.exp(-((x / 14) ** 2) - (((y + 32) / 16) ** 2)) * (z > 20)
    lips = 2.5 * np.exp(-((x / 24) ** 2) - (((y + 66) / 12) ** 2))
    return np.stack([x * broad * near, tall, 0.94 * z + nose + lips], axis=1)


def bent_part(part: Part) -> Part:
    rest = bend(part.vertices)
    targets = {
        name: Target(
            target.vertices,
            (bend(part.vertices[target.vertices] + target.offsets) - rest[target.vertices]).astype(np.float32),
        )
        for name, target in part.targets.items()
    }
    return replace(part, vertices=rest.astype(np.float32), targets=targets)


def shuffled(part: Part, seed: int = 5) -> tuple[Part, np.ndarray]:
    """Without the back of the head, vertices in another order; and each old vertex' new number (-1: gone)."""
    kept = part.vertices[:, 2] > -90
    triangles = part.triangles[kept[part.triangles].all(axis=1)]
    used = np.unique(triangles)
    order = np.random.default_rng(seed).permutation(used)
    new = np.full(len(part.vertices), -1, np.int64)
    new[order] = np.arange(len(order))
    targets = {}
    for name, target in part.targets.items():
        there = new[target.vertices] >= 0
        targets[name] = Target(new[target.vertices[there]].astype(np.int32), target.offsets[there])
    return (
        replace(
            part, vertices=part.vertices[order], triangles=new[triangles].astype(np.int32), uv=part.uv[order],
            colours=part.colours[order], head_weight=part.head_weight[order], targets=targets,
        ),
        new,
    )  # fmt: skip


def another_face(face: Face, sites: bool = False, shuffle: bool = True) -> tuple[Face, np.ndarray]:
    """The second face, and for each vertex of the default skin its number on the second one (-1: not there)."""
    parts = [bent_part(part) for part in face.parts]
    number = [part.name for part in parts].index("skin")
    new = np.arange(len(parts[number].vertices))
    if shuffle:
        parts[number], new = shuffled(parts[number])
    eyes = tuple(replace(eye, centre=tuple(float(c) for c in bend(np.array([eye.centre]))[0])) for eye in face.eyes)
    pivot = tuple(float(c) for c in bend(np.array([face.head_pivot]))[0])
    named = {name: (part, int(new[vertex])) for name, (part, vertex) in face.sites.items()} if sites else {}
    return Face("another", tuple(parts), eyes, pivot, named, "CC0"), new  # type: ignore[arg-type]
