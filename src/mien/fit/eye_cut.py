"""Eyes that are one surface with their lids (a scan): the patch between the lids is cut out for an eyeball."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["EyeCut", "cut_out_eye", "eye_patch", "inside_outline"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

_DEPTH_MM = 9.0


@dataclass(frozen=True, eq=False)
class EyeCut:
    """Vertices, some moved onto the lids' margins, the triangles left, and how many were taken out."""

    vertices: Floats
    triangles: Indices
    removed: int


def inside_outline(points: Floats, outline: Floats) -> NDArray[np.bool_]:
    """Whether points (n, 2) lie inside a closed curve (m, 2): crossings of a ray counted (Shimrat 1962)."""
    start, end = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    at = start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return np.asarray((spans & (x < at)).sum(axis=1) % 2 == 1)


def eye_patch(vertices: Floats, triangles: Indices, margin: Floats) -> NDArray[np.bool_]:
    """Triangles that look forward and fill the opening of the lids, whose margin (m, 3) goes round in order."""
    corner = vertices[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    forward = facing[:, 2] > 0.3 * np.linalg.norm(facing, axis=1)
    middle = corner.mean(axis=1)
    near = (np.abs(middle[:, 2] - margin[:, 2].mean()) < _DEPTH_MM + np.ptp(margin[:, 2]) / 2) & forward
    patch = np.zeros(len(triangles), dtype=np.bool_)
    asked = np.flatnonzero(
        near & (np.abs(middle[:, :2] - margin[:, :2].mean(0)) < np.ptp(margin[:, :2], axis=0)).all(1)
    )
    patch[asked] = inside_outline(middle[asked][:, :2], margin[:, :2])
    return patch


def cut_out_eye(vertices: Floats, triangles: Indices, welded: Indices, margin: Floats) -> EyeCut:
    """Take the patch between the lids out, and draw its rim onto the margin of the lids.

    Parameters
    ----------
    vertices, triangles : ndarray
        The head, mm.
    welded : ndarray of int32, shape (n,)
        The vertex that stands for all that lie together.
    margin : ndarray, shape (m, 3)
        The lids' margin on it, in order.
    """
    patch = eye_patch(vertices, triangles, margin)
    joined = welded[triangles]
    out, kept = np.zeros(len(vertices), np.bool_), np.zeros(len(vertices), np.bool_)
    out[joined[patch]], kept[joined[~patch]] = True, True
    rim = np.flatnonzero(out & kept)
    moved = vertices.copy()
    if len(rim):
        moved[rim] = _on_curve(vertices[rim], margin)
        moved = np.where((out & kept)[welded][:, None], moved[welded], moved)
    return EyeCut(moved, triangles[~patch], int(patch.sum()))


def _on_curve(points: Floats, curve: Floats) -> Floats:
    """The nearest places on a closed curve of straight pieces."""
    start, along = curve, np.roll(curve, -1, axis=0) - curve
    share = np.einsum("nmc,mc->nm", points[:, None] - start, along) / np.maximum((along**2).sum(1), 1e-9)
    places = start + np.clip(share, 0, 1)[:, :, None] * along
    nearest = np.linalg.norm(places - points[:, None], axis=2).argmin(axis=1)
    return np.asarray(places[np.arange(len(points)), nearest])
