"""Short hair: a cap grown out of the scalp, with clumps of strands on it."""

from __future__ import annotations

import numpy as np
from hairs import ribbons
from head import Head
from makehuman import Floats
from noise import layered_noise, value_noise
from sculpt import Sculpt, smoothstep, vertex_normals
from subdivision import catmull_clark, triangulate

_AXIS_Z = -75.0  # mm: the hairline is described by the azimuth about this upright line
# Azimuth in degrees from the front, and the height of the hairline there, mm over the eyes.
_HAIRLINE = (
    (0, 64), (12, 65), (24, 68), (34, 68), (43, 60), (52, 47), (61, 34), (69, 18), (75, 2), (78, -8), (83, -10),
    (86, 10), (92, 15), (101, 14), (105, 0), (108, -28), (114, -46), (128, -55), (150, -60), (180, -63),
)  # fmt: skip
_CROWN = np.array([0.0, 98.0, -118.0])  # the hair runs away from here
_DARK, _LIGHT = np.array([0.165, 0.122, 0.096]), np.array([0.285, 0.212, 0.160])


def hair_depth(points: Floats) -> Floats:
    """How far inside the hair a point of the head is, millimetres (negative: outside)."""
    azimuth = np.degrees(np.arctan2(np.abs(points[:, 0]), points[:, 2] - _AXIS_Z))
    at, height = np.array(_HAIRLINE, float).T
    line = np.interp(azimuth, at, height)
    slope = np.abs(np.interp(azimuth + 1, at, height) - np.interp(azimuth - 1, at, height)) / 2.6
    above = points[:, 1] - line
    # Beside a steep stretch of the line the way to it is shorter than the height over it; far above, no longer.
    steep = 1 / np.hypot(1, slope)
    return np.asarray(above * (steep + (1 - steep) * smoothstep(3.0, 30.0, above)))


def hair_mask(head: Head) -> Floats:
    """How much hair grows at each skin vertex, 0..1."""
    depth = hair_depth(head.skin.vertices)
    return np.asarray(smoothstep(-4.0, 6.0, depth) * (1 - smoothstep(0.05, 0.4, head.masks["ears"])))


def _runs(points: Floats) -> tuple[Floats, Floats]:
    """Azimuth about the crown and distance from it: hair runs along the distance."""
    arm = points - _CROWN
    axis = np.array([0.0, 0.86, -0.51])
    forward = np.array([0.0, 0.51, 0.86])
    along = arm @ axis
    turn = np.arctan2(arm[:, 0], arm @ forward)
    return turn, np.arctan2(np.linalg.norm(arm - along[:, None] * axis, axis=1), 90 + along)


def _picture_place(points: Floats) -> Floats:
    turn, away = _runs(points)
    return np.asarray(
        0.5 + 0.47 * (np.minimum(away / 1.95, 1))[:, None] * np.stack([np.sin(turn), -np.cos(turn)], axis=1)
    )


def build_cap(head: Head, seed: int) -> tuple[Sculpt, Floats]:
    """A finer copy of the scalp, lifted off it and sunk under the skin at the hairline; and the scalp's normals."""
    skin = head.skin
    mask = hair_mask(head)
    chosen = head.quads[(mask[head.quads] > 0.02).any(axis=1)]
    used, local = np.unique(chosen, return_inverse=True)
    matrix, fine = catmull_clark(len(used), local.reshape(-1, 4))
    scalp = Sculpt("hair", skin.vertices[used], chosen, {k: v[used] for k, v in skin.shapes.items()})
    assert skin.head_weight is not None
    scalp.head_weight = skin.head_weight[used]
    cap = scalp.through(matrix, triangulate(fine))
    depth = hair_depth(cap.vertices) - 30 * smoothstep(0.0, 0.4, matrix @ head.masks["ears"][used])
    normals = vertex_normals(cap.vertices, cap.triangles)
    turn, away = _runs(cap.vertices)
    top = smoothstep(10.0, 80.0, cap.vertices[:, 1])
    full = 2.2 + 7.5 * top * smoothstep(-10.0, 30.0, depth)
    streaks = value_noise(np.stack([turn * 34, away * 2.2], axis=1), 1.0, seed)
    tousle = layered_noise(cap.vertices, 26.0, seed + 1, layers=2)
    ragged = depth + 3.0 * value_noise(np.stack([turn * 40, away * 2], axis=1), 1.0, seed + 2)
    lift = full * smoothstep(-1.0, 26.0, ragged) * (1 + 0.22 * streaks + 0.25 * tousle) - 1.6 * smoothstep(
        3.0, -2.0, ragged
    )
    cap.vertices = cap.vertices + lift[:, None] * normals
    cap.uv = _picture_place(cap.vertices)
    return cap, normals


def paint_hair(size: int, seed: int) -> Floats:
    """Strands that run away from the crown, shape (size, size, 3)."""
    grid = (np.arange(size) + 0.5) / size - 0.5
    x, y = (a.ravel() for a in np.meshgrid(grid, grid))
    away = np.hypot(x, y) / 0.47 * 1.95
    circle = np.stack([x, -y], axis=1) / np.maximum(np.hypot(x, y), 1e-6)[:, None]
    sway = 0.05 * layered_noise(np.stack([x, y], axis=1), 0.12, seed + 9)
    strands = np.zeros(len(x))
    for number, (fineness, run, weight) in enumerate(((16, 2.5, 0.30), (42, 5.0, 0.35), (95, 9.0, 0.35))):
        turned = circle + sway[:, None] * circle[:, ::-1] * np.array([1, -1])
        strands += weight * value_noise(np.c_[turned * fineness, away * run], 1.0, seed + number)
    tone = smoothstep(-0.55, 0.75, strands)[:, None]
    return np.asarray((_DARK + (_LIGHT - _DARK) * tone).reshape(size, size, 3))


def build_clumps(cap: Sculpt, normals: Floats, count: int, seed: int) -> Sculpt:
    """Clumps of strands lying on the cap, so that its outline and its hairline are those of hair."""
    random = np.random.default_rng(seed)
    depth = hair_depth(cap.vertices)
    wanted = (1.0 + 1.2 * smoothstep(30, 90, cap.vertices[:, 1])) * (depth > 0.0) * (1 + 6.0 * (depth < 9))
    roots = random.choice(len(depth), size=count, p=wanted / wanted.sum())
    near_edge = smoothstep(12.0, 3.0, depth[roots])[:, None]
    points, normal = cap.vertices[roots], normals[roots]
    away = points - _CROWN
    flow = away - (away * normal).sum(1, keepdims=True) * normal
    near = np.linalg.norm(flow, axis=1, keepdims=True)
    flow = flow / np.maximum(near, 1e-6)
    swirl = np.cross(normal, flow)
    flow = flow + swirl * (0.25 + 0.28 * random.normal(size=(count, 1)))
    flow /= np.linalg.norm(flow, axis=1, keepdims=True)
    top = smoothstep(0.0, 80.0, points[:, 1])[:, None]
    length = (6.0 + 9.0 * top) * random.uniform(0.7, 1.25, (count, 1)) * (1 - 0.45 * near_edge)
    start = flow + (0.02 + 0.18 * top + 0.045 * random.normal(size=(count, 1))) * normal
    across = np.cross(normal, flow)
    width = random.uniform(0.7, 1.5, count) * (1 - 0.6 * near_edge[:, 0]) * (0.7 + 0.5 * top[:, 0])
    vertices, triangles = ribbons(
        points - 0.7 * normal, length * start, -0.20 * length * normal, across, width, steps=2
    )
    each = len(vertices) // count
    clumps = Sculpt("hair_clumps", vertices, triangles)
    tone = np.linspace(0.25, 0.75, each)[None, :, None] + 0.2 * random.normal(size=(count, 1, 1))
    clumps.colours = np.clip(_DARK + (_LIGHT - _DARK) * np.clip(tone, 0, 1), 0, 1).reshape(-1, 3)
    assert cap.head_weight is not None
    owner = np.repeat(roots, each)
    clumps.head_weight = cap.head_weight[owner]
    for name, offsets in cap.shapes.items():
        if np.abs(offsets[owner]).max(initial=0) > 0.05:
            clumps.shapes[name] = offsets[owner]
    return clumps
