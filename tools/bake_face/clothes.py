"""A plain T-shirt, and the smooth curve on which the bust ends."""

from __future__ import annotations

import numpy as np
from head import Head
from makehuman import Floats
from noise import layered_noise
from sculpt import Sculpt, smoothstep, vertex_normals
from subdivision import clip
from uv import border_loops

_CLOTH = np.array([0.235, 0.285, 0.345])
_UNDER = 36.0  # mm of skin below the collar's edge, so that its own open edge lies far from what is seen


def _collar_height(points: Floats) -> Floats:
    """Height over the collar's edge, a tilted and slightly hollow surface; negative: under the shirt."""
    front = smoothstep(-110.0, -10.0, points[:, 2])
    edge = -128.0 - 30.0 * front + 0.0016 * points[:, 0] ** 2
    return np.asarray(points[:, 1] - edge)


def _bust(points: Floats) -> Floats:
    """Positive inside the bust's rounded outline."""
    low = np.minimum(points[:, 1] + 150.0, 0.0)
    return np.asarray(1 - (points[:, 0] / 250.0) ** 2 - (low / 138.0) ** 2)


def dress(head: Head, seed: int) -> tuple[Sculpt, Sculpt]:
    """The skin that stays in sight, and the shirt."""
    skin = head.skin
    matrix, triangles = clip(skin.triangles, np.minimum(-_collar_height(skin.vertices), 40 * _bust(skin.vertices)))
    shirt = skin.through(matrix, triangles)
    shirt.name, shirt.uv, shirt.colours = "shirt", None, None
    normals = vertex_normals(shirt.vertices, shirt.triangles)
    height = -_collar_height(shirt.vertices)
    folds = layered_noise(shirt.vertices * np.array([1, 0.6, 1]), 60.0, seed, layers=2)
    rise = 1.3 + 1.4 * smoothstep(2, 15, height) + 2.2 * smoothstep(15, 70, height) * (1 + 0.8 * folds)
    shirt.vertices = shirt.vertices + rise[:, None] * normals
    _turn_in(shirt)
    shade = 1 + 0.05 * folds
    shirt.colours = _CLOTH * np.r_[shade, np.ones(len(shirt.vertices) - len(shade))][:, None]
    matrix, triangles = clip(skin.triangles, _collar_height(skin.vertices) + _UNDER)
    return skin.through(matrix, triangles), shirt


def _turn_in(shirt: Sculpt) -> None:
    """A hem at the collar: the edge turns in below the skin and is closed inside the neck, out of sight."""
    loops = border_loops(shirt.triangles)
    collar = max(loops, key=lambda loop: shirt.vertices[loop][:, 1].mean())
    middle = shirt.vertices[collar].mean(0)
    inward = middle - shirt.vertices[collar]
    inward[:, 1] = 0
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    n = len(shirt.vertices)
    inner = n + np.arange(len(collar))
    after = np.roll(np.arange(len(collar)), -1)
    hub = np.full(len(collar), n + len(collar))
    hem = (
        np.stack([collar[after], collar, inner], axis=1),
        np.stack([collar[after], inner, inner[after]], axis=1),
        np.stack([inner[after], inner, hub], axis=1),
    )
    edge = shirt.vertices[collar]
    drop = np.array([0, 1.0, 0])
    shirt.vertices = np.vstack([shirt.vertices, edge + 5.0 * inward - drop, middle - 20 * drop])
    shirt.triangles = np.vstack([shirt.triangles, *hem])
    still = np.zeros((1, 3))
    shirt.shapes = {name: np.vstack([field, field[collar], still]) for name, field in shirt.shapes.items()}
    assert shirt.head_weight is not None
    shirt.head_weight = np.r_[shirt.head_weight, shirt.head_weight[collar], shirt.head_weight[collar].mean()]
