"""The mesh that a picture needs: what is finer than its pixels is drawn by fewer triangles.

Every vertex of the coarser face stands where one of the full face stands, in any pose, and has its normal: light and
shape stay those of the full mesh. Ribbons (strands of hair, lashes) become fewer and as much wider, so that they cover
as much and none is thinner than a pixel. Of other parts, vertices that lie, move and face alike within a pixel become
one; open edges and seams of textures stay.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.face.model import Face, Part
from mien.face.normals import normals_of
from mien.face.posing import welded_vertices
from mien.face.row_groups import row_groups
from mien.face.subset import nearest_to_middle, subset, without_flat

__all__ = ["Detail", "moves"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int64]

_RIBBON_PIXELS, _MOST_WIDENED = 4.5, 2.2  # a ribbon is to be so wide, at its widest; and so many times as it was
_STEP_PIXELS = 2.5  # shorter steps along a ribbon are taken together
_LEAST_RIBBONS = 40
# Vertices within so many pixels become one; of what lies within the mouth, the sockets or below hair, within more.
_CELL, _CELL_INSIDE = 1.8, 2.4
_INSIDE = ("teeth", "gum", "tongue", "eye", "hair_cap")
_MOVE_MM = 7.0
_WORTH = 0.8  # a part that keeps more of its vertices stays as it is


@dataclass(frozen=True, eq=False)
class Detail:
    """A face of fewer triangles, and how it is posed.

    Attributes
    ----------
    face : Face
    kept : ndarray, shape (vertices of ``face``,)
        Vertex of the full face, all parts end to end.
    side, other : ndarray, shape (vertices of ribbons that are wider,)
        Vertices of ``face``, and those on the other side of their ribbons.
    wider : float32 ndarray, shape (vertices of ribbons that are wider, 1)
        How far they move away from these, as a share of their distance.
    """

    face: Face
    kept: Indices
    side: Indices
    other: Indices
    wider: Floats

    @classmethod
    def of(cls, face: Face, pixel_mm: float) -> Detail | None:
        """What pixels of this size need; None for the full mesh."""
        found = [_ribbons(part, pixel_mm) or _clusters(part, pixel_mm) for part in face.parts]
        if not any(found):
            return None
        parts, kept, side, other, wider = [], [], [], [], []
        start = first = 0
        for part, less in zip(face.parts, found, strict=True):
            fewer, keep, times = less or (part, np.arange(len(part.vertices)), 1.0)
            if times > 1:
                line = np.arange(len(keep)).reshape(-1, _ribbon_size(fewer))[:, :-1]
                side.append(first + line.reshape(-1))
                other.append(first + line.reshape(len(line), -1, 2)[:, :, ::-1].reshape(-1))
                wider.append(np.full((line.size, 1), (times - 1) / 2, np.float32))
            parts.append(fewer)
            kept.append(start + keep)
            start, first = start + len(part.vertices), first + len(keep)
        none: Indices = np.zeros(0, np.int64)
        return cls(
            replace(face, parts=tuple(parts)),
            np.concatenate(kept),
            np.concatenate([none, *side]),
            np.concatenate([none, *other]),
            np.concatenate([np.zeros((0, 1), np.float32), *wider]),
        )

    def posed(self, vertices: Floats, normals: Floats) -> tuple[Floats, Floats]:
        """Vertices and normals of this face from those of the full one."""
        here = np.take(vertices, self.kept, axis=0)
        one = np.take(here, self.side, axis=0)
        here[self.side] = one + self.wider * (one - np.take(here, self.other, axis=0))
        return here, np.take(normals, self.kept, axis=0)


def moves(part: Part) -> Floats:
    """How each vertex moves, as two mixtures of its targets: lips that touch at rest differ. Shape (n, 6), mm."""
    mixed = np.zeros((len(part.vertices), 2, 3), dtype=np.float32)
    for number, name in enumerate(sorted(part.targets)):
        target = part.targets[name]
        for k, step in enumerate((0.6180339887, 0.4142135624)):
            np.add.at(mixed[:, k], target.vertices, np.float32(np.cos(2 * np.pi * step * number)) * target.offsets)
    return mixed.reshape(len(part.vertices), 6)


_Less = tuple[Part, Indices, float]  # what is left of a part, of which vertices, how many times as wide


def _ribbons(part: Part, pixel_mm: float) -> _Less | None:
    """Fewer and wider ribbons, if the part is made of them: vertices by pairs from the root on, and one at the tip."""
    size = _ribbon_size(part)
    if not size:
        return None
    count = len(part.vertices) // size
    line = part.vertices.reshape(count, size, 3)
    width = np.median(np.linalg.norm(line[:, 1:-1:2] - line[:, :-1:2], axis=2).max(axis=1)) / pixel_mm
    times = float(np.clip(_RIBBON_PIXELS / max(width, 1e-6), 1.0, _MOST_WIDENED))
    step = np.median(np.linalg.norm(line[:, 2:-1:2] - line[:, :-3:2], axis=2)) / pixel_mm if size > 5 else 0.0
    every = 2 if size > 5 and step < _STEP_PIXELS else 1
    left = np.r_[0 : size - 1 : 2 * every]
    column = np.append(np.stack([left, left + 1], axis=1).reshape(-1), size - 1)
    strands = np.arange(count)[(np.arange(count) * 0.6180339887) % 1.0 < 1 / times]
    if count < _LEAST_RIBBONS or (len(strands) > _WORTH * count and every == 1):
        return None
    keep = (size * strands[:, None] + column).reshape(-1)
    fewer = len(column)
    triangles = (_strip(fewer) + fewer * np.arange(len(strands))[:, None, None]).reshape(-1, 3)
    return subset(part, keep, triangles), keep, times


def _ribbon_size(part: Part) -> int:
    """Vertices of each ribbon of a part that is made of them; else 0."""
    for size in range(5, 64, 2):
        if len(part.vertices) % size == 0 and len(part.triangles) * size == (size - 2) * len(part.vertices):
            corners, firsts = part.triangles.reshape(-1, size - 2, 3), np.arange(0, len(part.vertices), size)
            if np.array_equal(corners, _strip(size) + firsts[:, None, None]):
                return size
    return 0


def _strip(size: int) -> NDArray[np.int64]:
    """Triangles of one ribbon of so many vertices."""
    pairs = [t for k in range(0, size - 3, 2) for t in ((k, k + 1, k + 2), (k + 1, k + 3, k + 2))]
    return np.array([*pairs, (size - 3, size - 2, size - 1)])


def _clusters(part: Part, pixel_mm: float) -> _Less | None:
    """One vertex for all that are nearer than a pixel."""
    if not len(part.triangles):
        return None
    count, inside = len(part.vertices), part.name.startswith(_INSIDE)
    cell = (_CELL_INSIDE if inside else _CELL) * pixel_mm
    welded = welded_vertices(part)
    normals = normals_of(part.vertices, part.triangles, welded)
    single = np.zeros(count, dtype=np.bool_)
    others = welded != np.arange(count)
    single[others] = single[welded[others]] = True
    corner = welded[part.triangles].astype(np.int64)
    one, other = corner.reshape(-1), np.roll(corner, -1, axis=1).reshape(-1)
    edges, times = np.unique(np.minimum(one, other) * count + np.maximum(one, other), return_counts=True)
    rim = edges[times == 1]
    single[rim // count] = single[rim % count] = True
    single |= single[welded]
    alone = np.where(single, np.arange(count), -1)
    group = row_groups(
        np.column_stack([alone, np.floor(part.vertices / cell), np.rint(moves(part) / _MOVE_MM), np.rint(normals)])
    )
    if group.max() + 1 > _WORTH * count:
        return None
    keep = nearest_to_middle(part.vertices, group)
    return subset(part, keep, without_flat(group[part.triangles])), keep, 1.0
