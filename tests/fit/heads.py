"""Heads to fit to whose truth is known: members of the space of heads, turned, scaled, in another order of vertices."""

from __future__ import annotations

import numpy as np

from mien.face.head_space import head_space
from mien.fit.fit_head import GivenMesh
from mien.fit.landmarks import known_landmarks

Z_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def other_shape(seed: int = 3, count: int = 30) -> np.ndarray:
    """A made-up head on the default skin's vertices, mm."""
    chance = np.random.default_rng(seed)
    return head_space().shape(chance.normal(0, 1, count))


def mesh_of(vertices, triangles=None) -> GivenMesh:
    """A bare mesh."""
    triangles = head_space().triangles if triangles is None else triangles
    return GivenMesh(vertices, triangles, np.zeros((len(vertices), 2)), np.ones((len(vertices), 3)))


def marks_of(vertices, some=("eye_", "nose_t", "nose_b", "lip", "chin", "lid", "ear_top", "crown")):
    """Landmarks of a head on the default skin's vertices, as places."""
    return {
        name: tuple(vertices[mark.vertex])
        for name, mark in known_landmarks().items()
        if mark.needed or name.startswith(some)
    }


def icosahedron(rounds: int) -> tuple[np.ndarray, np.ndarray]:
    """A ball of triangles: what is no head."""
    gold = (1 + 5**0.5) / 2
    points = [(0, a, b * gold) for a in (-1, 1) for b in (-1, 1)]
    vertices = np.array([np.roll(p, k) for k in range(3) for p in points], dtype=float)
    from scipy.spatial import ConvexHull

    for _ in range(rounds):
        edges = {tuple(sorted(e)) for t in ConvexHull(vertices).simplices for e in zip(t, np.roll(t, 1), strict=True)}
        vertices = np.vstack([vertices, [(vertices[a] + vertices[b]) / 2 for a, b in edges]])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    triangles = ConvexHull(vertices).simplices
    corner = vertices[triangles]
    inward = (
        np.einsum("td,td->t", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), corner.mean(1)) < 0
    )
    return vertices, np.where(inward[:, None], triangles[:, ::-1], triangles).astype(np.int32)
