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
