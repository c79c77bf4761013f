"""A mesh under work: dense offsets, double precision; and how it becomes a `mien.face.model.Part`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse
from makehuman import Floats, Ints

from mien.face.model import Material, Part, Target

_SMALLEST_MOVE = 0.02  # mm: smaller offsets are left out


@dataclass
class Sculpt:
    """Vertices (n, 3) in millimetres about the eyes, triangles (t, 3), and offsets (n, 3) by channel name."""

    name: str
    vertices: Floats
    triangles: Ints
    shapes: dict[str, Floats] = field(default_factory=dict)
    uv: Floats | None = None
    colours: Floats | None = None
    head_weight: Floats | None = None

    def through(self, matrix: sparse.csr_matrix, triangles: Ints) -> Sculpt:
        """The mesh whose vertices are mixtures (rows of ``matrix``) of this one's."""

        def mixed(field_: Floats | None) -> Floats | None:
            return None if field_ is None else matrix @ field_

        return Sculpt(
            self.name,
            matrix @ self.vertices,
            triangles,
            {name: matrix @ offsets for name, offsets in self.shapes.items()},
            mixed(self.uv),
            mixed(self.colours),
            mixed(self.head_weight),
        )

    def posed(self, **weights: float) -> Floats:
        """Vertices with the named shapes at the given weights."""
        shape = self.vertices.copy()
        for name, weight in weights.items():
            if name in self.shapes:
                shape += weight * self.shapes[name]
        return shape

    def part(self, material: Material) -> Part:
        """The finished part."""
        n = len(self.vertices)
        targets = {}
        for name, offsets in self.shapes.items():
            moved = np.flatnonzero(np.abs(offsets).max(axis=1) >= _SMALLEST_MOVE)
            if len(moved):
                targets[name] = Target(moved.astype(np.int32), offsets[moved].astype(np.float32))
        return Part(
            name=self.name,
            vertices=self.vertices.astype(np.float32),
            triangles=self.triangles.astype(np.int32),
            uv=(np.zeros((n, 2)) if self.uv is None else self.uv).astype(np.float32),
            colours=(np.ones((n, 3)) if self.colours is None else self.colours).astype(np.float32),
            material=material,
            head_weight=(np.ones(n) if self.head_weight is None else self.head_weight).astype(np.float32),
            targets=targets,
        )


def vertex_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Unit normals, weighted by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], face)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def smoothstep(low: float, high: float, x: Floats) -> Floats:
    """0 below ``low``, 1 above ``high``, smooth between (``low`` may be the larger: then it falls)."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def rigid_motion(before: Floats, after: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotation R and centres a, b with ``after ~ (before - a) @ R.T + b`` (Kabsch 1976)."""
    a, b = before.mean(0), after.mean(0)
    u, _, vt = np.linalg.svd((before - a).T @ (after - b))
    flip = np.diag([1, 1, np.linalg.det(u @ vt)])
    return (u @ flip @ vt).T, a, b
