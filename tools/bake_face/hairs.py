"""Lashes, brows and the hair on the head: thin opaque geometry rooted in the skin."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sparse
from contact import split_loop
from head import Head
from makehuman import Floats, Ints
from scipy.spatial import cKDTree
from sculpt import Sculpt, smoothstep, vertex_normals


def ribbons(
    roots: Floats, along: Floats, bend: Floats, across: Floats, width: Floats, steps: int
) -> tuple[Floats, Ints]:
    """Tapering ribbons, one per root; they are single sheets, to be drawn from both sides.

    Parameters
    ----------
    roots, along, bend, across : ndarray, shape (k, 3)
        A ribbon runs ``root + t * along + t**2 * bend`` for t in 0..1; ``across`` is the unit vector of its width.
    width : ndarray, shape (k,)
        At the root, millimetres; the tip is a point.

    Returns
    -------
    vertices (k * (2 * steps + 1), 3) and triangles; every ribbon has the same layout.
    """
    t = np.arange(steps) / steps
    line = roots[:, None] + t[None, :, None] * along[:, None] + (t**2)[None, :, None] * bend[:, None]
    half = (0.5 * width[:, None] * (1 - t**1.5)[None])[..., None] * across[:, None]
    tip = (roots + along + bend)[:, None]
    vertices = np.concatenate([np.stack([line - half, line + half], axis=2).reshape(len(roots), -1, 3), tip], axis=1)
    faces = []
    for step in range(steps - 1):
        a, b, c, d = 2 * step, 2 * step + 1, 2 * step + 2, 2 * step + 3
        faces += [(a, b, c), (b, d, c)]
    faces.append((2 * steps - 2, 2 * steps - 1, 2 * steps))
    each = 2 * steps + 1
    triangles = (np.array(faces)[None] + each * np.arange(len(roots))[:, None, None]).reshape(-1, 3)
    return vertices.reshape(-1, 3), triangles


def bound(skin: Sculpt, points: Floats, spread: int = 4) -> sparse.csr_matrix:
    """How points near the skin follow it: a matrix (points, skin vertices) of inverse-distance weights."""
    distance, nearest = cKDTree(skin.vertices).query(points, k=spread)
    weight = 1 / np.maximum(distance, 0.05) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(points)), spread)
    return sparse.csr_matrix((weight.ravel(), (rows, nearest.ravel())), (len(points), len(skin.vertices)))


def follow(piece: Sculpt, skin: Sculpt, matrix: sparse.csr_matrix) -> Sculpt:
    """Let a piece ride on the skin through every shape."""
    piece.shapes = {}
    for name, offsets in skin.shapes.items():
        moved = matrix @ offsets
        if np.abs(moved).max(initial=0) > 0.02:
            piece.shapes[name] = moved
    assert skin.head_weight is not None
    piece.head_weight = matrix @ skin.head_weight
    return piece


def build_lashes(head: Head, loops: list[Ints], seed: int) -> Sculpt:
    """Upper and lower lashes of both eyes; they turn with the lid's edge."""
    skin = head.skin
    random = np.random.default_rng(seed)
    pieces: list[tuple[Floats, Ints]] = []
    motion: dict[str, list[Floats]] = {}
    rows: list[tuple[Ints, Floats, bool]] = []
    for loop, centre in zip(loops, head.eye_centres, strict=True):
        upper, lower, _ = split_loop(skin.vertices, loop)
        rows += [(upper, centre, True), (lower, centre, False)]
    jitter = [random.normal(size=(2, 100, 3)) for _ in range(2)]  # the same on both sides
    shapes = ["", *skin.shapes]
    for number, (row, centre, is_upper) in enumerate(rows):
        side = 1.0 if centre[0] > 0 else -1.0
        ordered = row[np.argsort(side * skin.vertices[row][:, 0])]
        rest = None
        for name in shapes:
            points = skin.vertices[ordered] + (skin.shapes[name][ordered] if name else 0.0)
            vertices, triangles = _lash_row(points, centre, side, is_upper, jitter[number % 2])
            if rest is None:
                rest = vertices
                pieces.append((vertices, triangles))
            else:
                motion.setdefault(name, []).append(vertices - rest)
    starts = np.cumsum([0] + [len(v) for v, _ in pieces])
    vertices = np.vstack([v for v, _ in pieces])
    triangles = np.vstack([t + s for (_, t), s in zip(pieces, starts, strict=False)])
    lashes = Sculpt("lashes", vertices, triangles)
    lashes.shapes = {n: d for n, d in ((n, np.vstack(m)) for n, m in motion.items()) if np.abs(d).max() > 0.02}
    return lashes


def _lash_row(row: Floats, centre: Floats, side: float, is_upper: bool, jitter: Floats) -> tuple[Floats, Ints]:
    """Lashes along one lid edge given as an ordered row of points, from the nose outward."""
    count = 92 if is_upper else 44
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(row, axis=0), axis=1))]
    share = np.linspace(0.10, 0.985, count)
    roots = np.stack([np.interp(share * along[-1], along, row[:, k]) for k in range(3)], axis=1)
    tangent = np.stack([np.gradient(roots[:, k]) for k in range(3)], axis=1)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    outward = roots - centre
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    up = np.cross(outward, tangent) * side
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    up = up * np.sign(up[:, 1:2].mean()) * (1 if is_upper else -1)
    fan = (share - 0.42)[:, None] * np.array([side, 0.0, 0.0])
    random = jitter[0 if is_upper else 1, :count]
    swell = np.sin(np.pi * np.clip(share * 0.82 + 0.14, 0, 1))[:, None]
    length = ((7.0 if is_upper else 2.9) * swell + 0.4) * (1 + 0.16 * random[:, :1])
    # A shut lid points its lashes down; an open one lets them curl up.
    shut = np.clip(0.25 - outward[:, 1:2], 0, 0.7) if is_upper else np.zeros((count, 1))
    start = 0.92 * outward + ((-0.12 if is_upper else 0.30) - 0.75 * shut) * up + 0.75 * fan + 0.09 * random
    bend = ((0.62 if is_upper else 0.22) - 0.5 * shut) * up - 0.18 * outward
    roots = roots + 0.12 * outward + 0.10 * random[:, 1:2] * up * (1 if is_upper else 0.5)
    across = tangent
    width = np.full(count, 0.26 if is_upper else 0.17)
    return ribbons(roots, length * start * 0.72, length * bend * 0.72, across, width, steps=4)


def brow_density(head: Head) -> Floats:
    """How thick the brows grow at each skin vertex, 0..1."""
    x, y, z = head.skin.vertices.T
    side = np.abs(x)
    share = np.clip((side - 11.0) / 37.0, 0, 1)
    middle, half = _brow_line(share)
    inside = 1 - smoothstep(0.75, 1.25, np.abs(y - middle) / half)
    ends = smoothstep(9.5, 14.0, side) * smoothstep(49.5, 45.0, side)
    return np.asarray(inside * ends * (z > -5))


def _brow_line(share: Floats) -> tuple[Floats, Floats]:
    """Height of the brow's middle line and half its thickness, from the inner (0) to the outer end (1)."""
    # The inner end lowest: brows that start high look worried before anything is felt.
    line = 14.0 + 5.0 * np.sin(np.pi * np.clip(share, 0, 1) ** 1.10 * 0.86) - 1.0 * share
    half = 3.2 * (1 - 0.62 * smoothstep(0.45, 1.0, share)) * (0.6 + 0.4 * smoothstep(-0.02, 0.2, share))
    return line, half


def _projector(skin: Sculpt) -> Callable[[Floats], tuple[Floats, Floats]]:
    """A function that lays points (k, 3) straight back onto the brow of the left side: places and normals there."""
    x, y, z = skin.vertices.T
    front = np.flatnonzero((z > -5) & (y > 5) & (y < 45) & (x > 0))
    points, normals = skin.vertices[front], vertex_normals(skin.vertices, skin.triangles)[front]
    tree = cKDTree(points[:, :2])

    def on_skin(given: Floats) -> tuple[Floats, Floats]:
        distance, near = tree.query(given[:, :2], k=4)
        weight = 1 / np.maximum(distance, 0.1) ** 2
        weight /= weight.sum(axis=1, keepdims=True)
        slope = np.einsum("kn,knc->kc", weight, normals[near])
        slope /= np.linalg.norm(slope, axis=1, keepdims=True)
        aside = ((given[:, None, :2] - points[near][..., :2]) * slope[:, None, :2]).sum(2)
        place = given.copy()
        place[:, 2] = (weight * (points[near][..., 2] - aside / np.maximum(slope[:, None, 2], 0.2))).sum(1)
        return place, slope

    return on_skin


def build_brows(head: Head, seed: int) -> Sculpt:
    """Brow hairs: rooted on the skin, lying along the brow; one side is the mirror of the other."""
    skin = head.skin
    random = np.random.default_rng(seed)
    count = 430
    share = random.uniform(-0.02, 1, count) + random.normal(0, 0.02, count)
    offset = np.clip(random.normal(0, 0.52, count), -1, 1)
    share = share + 0.06 * np.maximum(offset, 0) * (share < 0.2)
    middle, half = _brow_line(share)
    roots = np.stack([11.0 + 37.0 * share, middle + offset * half, np.zeros(count)], axis=1)
    on_skin = _projector(skin)
    roots, normal = on_skin(roots)
    angle = np.interp(share, [0, 0.18, 0.5, 1.0], [0.95, 0.62, 0.28, -0.38]) - 0.55 * offset * smoothstep(
        0.1, 0.4, share
    )
    angle = angle + random.normal(0, 0.13, count)
    length = (5.2 - 0.9 * share) * random.uniform(0.75, 1.2, count)
    tips = roots + length[:, None] * np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    tips, tip_normal = on_skin(tips)
    roots, tips = roots + 0.05 * normal, tips + 0.35 * tip_normal
    middle_points, middle_normal = on_skin((roots + tips) / 2)
    arch = (middle_points + 0.55 * middle_normal) - (roots + tips) / 2
    along, bend = tips - roots + 4 * arch, -4 * arch
    across = np.cross(normal, tips - roots)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    vertices, triangles = ribbons(roots, along, bend, across, random.uniform(0.22, 0.36, count), steps=3)
    tone = np.repeat(random.uniform(0.8, 1.2, count), len(vertices) // count)[:, None]
    mirrored = vertices * np.array([-1.0, 1.0, 1.0])
    both = Sculpt("brows", np.vstack([vertices, mirrored]), np.vstack([triangles, triangles[:, ::-1] + len(vertices)]))
    both.colours = np.clip(np.vstack([tone, tone]) * np.array([0.80, 0.80, 0.80]), 0, 1)
    return follow(both, skin, bound(skin, both.vertices))
