"""Shapes that FACS asks for and ARKit lacks (`mien.core.channels.MUSCLES`), on the fine skin.

Where MakeHuman has an expression unit it is taken (nostrils), where an ARKit shape holds what is wanted it is split or
reshaped (inner brows, sharp corner pull), and the rest is sculpted here (nasolabial furrow, tightened lips). All
hand-made: sizes by looking at the sheet of action units that ``make sheets`` draws.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from head import Head
from makehuman import Floats
from sculpt import smoothstep, vertex_normals

_SIDES = (("Left", 1.0), ("Right", -1.0))
_MIDDLE = 7.0  # mm: halves of the face fade into each other over this distance from the middle
_FLARE, _COMPRESS = 3.0, 3.4  # how much of MakeHuman's units
# Nasolabial furrow of the left side, from the wing of the nose to beside the mouth's corner: (x, y) in mm.
_FURROW = ((17.0, -41.0), (24.0, -48.5), (31.0, -58.0))
# The same in a smile, whose corner it passes: where it lies before the corner is pulled up; and how deep it is.
_SMILE_FURROW = ((17.0, -42.0), (26.0, -53.0), (36.0, -65.0), (38.0, -74.0))
_SMILE_DEPTH = 0.5
_CHIN_OUT = 1.2  # mm by which a raised chin brings the line between the lips forward
_FOLD = 6.4  # mm from one fold of a wrinkled nose to the next
# The raw units by which `makehuman.MakeHuman.expression_units` calls them.
RAW = ("nose-compression", "nose-dilatation")


def add_muscles(head: Head) -> None:
    """Add the shapes to the skin and drop the raw units they are made of."""
    skin = head.skin
    raw = {name: skin.shapes.pop(name) for name in RAW}
    for name in RAW:
        head.units.pop(name)
    _raise_chin(head)
    for side, sign in _SIDES:
        _wrinkle_nose(head, side, sign)
        half = smoothstep(-_MIDDLE, _MIDDLE, sign * skin.vertices[:, 0])[:, None]
        skin.shapes["browInnerUp" + side] = skin.shapes["browInnerUp"] * half
        skin.shapes["noseFlare" + side] = _FLARE * raw["nose-dilatation"] * half
        skin.shapes["noseCompress" + side] = _COMPRESS * raw["nose-compression"] * half
        furrow = _furrow(head, sign, _FURROW)
        lip = 0.30 * skin.shapes["mouthUpperUp" + side] * smoothstep(4.0, 16.0, sign * skin.vertices[:, 0])[:, None]
        skin.shapes["nasolabialDeepen" + side] = furrow + lip
        skin.shapes["mouthSmile" + side] = skin.shapes["mouthSmile" + side] + _SMILE_DEPTH * _furrow(
            head, sign, _SMILE_FURROW
        )
        skin.shapes["mouthSharpPull" + side] = _sharp_pull(head, side, sign)
        skin.shapes["mouthTighten" + side] = _tightened(head) * half


def _wrinkle_nose(head: Head, side: str, sign: float) -> None:
    """The skin of ARKit's sneer gathers: folds across the nose's side, its wing up, the cheek beside it pulled in."""
    skin = head.skin
    x, y, z = (skin.vertices * np.array([sign, 1.0, 1.0])).T
    normals = vertex_normals(skin.vertices, skin.triangles)
    half = smoothstep(-1.5, 2.5, x)
    flank = (
        half
        * smoothstep(17.0, 8.0, x)
        * smoothstep(-34.0, -26.0, y)
        * smoothstep(4.0, -4.0, y)
        * smoothstep(2.0, 12.0, z)
    )
    folds = 0.8 * np.cos(2 * np.pi * (y + 0.55 * x + 14.0) / _FOLD) * flank
    wing = np.exp(-(((x - 14.0) / 6.0) ** 2) - (((y + 40.0) / 7.0) ** 2)) * smoothstep(0.0, 12.0, z)
    beside = np.exp(-(((x - 22.0) / 8.0) ** 2) - (((y + 30.0) / 10.0) ** 2)) * smoothstep(-5.0, 10.0, z)
    lifted = np.outer(wing, [-0.4 * sign, 2.2, 0.4]) + np.outer(beside, [-1.2 * sign, 2.4, 0.7])
    skin.shapes["noseSneer" + side] = skin.shapes["noseSneer" + side] + normals * folds[:, None] + lifted


def _raise_chin(head: Head) -> None:
    """The chin's boss goes up and flattens, the lower lip rides on it and out, a furrow forms below the lip."""
    skin = head.skin
    x, y, z = skin.vertices.T
    front = smoothstep(-5.0, 12.0, z) * (1 - head.masks["inside-mouth"])
    boss = np.exp(-((x / 15.0) ** 2) - (((y + 92.0) / 10.0) ** 2)) * front
    furrow = np.exp(-((x / 13.0) ** 2) - (((y + 81.5) / 3.6) ** 2)) * front
    lip = np.exp(-((x / 17.0) ** 2) - (((y + 73.0) / 5.5) ** 2)) * front
    moved = np.outer(boss, [0.0, 4.6, 0.9]) + np.outer(furrow, [0.0, 1.6, -2.0]) + np.outer(lip, [0.0, 2.6, 1.2])
    raised = skin.shapes["mouthShrugLower"] + moved
    # The lower lip pushes up; where the lips meet it goes no farther out than the upper one that it lifts.
    seam = np.exp(-((x / 24.0) ** 2) - (((y + 66.5) / 4.5) ** 2)) * front
    raised[:, 2] += seam * (np.minimum(raised[:, 2], _CHIN_OUT) - raised[:, 2])
    skin.shapes["mouthShrugLower"] = raised


def _smoothed(head: Head, field: Floats, where: Floats, rounds: int) -> Floats:
    """A field of offsets evened out over the mesh's edges where ``where`` (0..1) says so."""
    sides = np.vstack([head.skin.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    count = np.bincount(sides.ravel(), minlength=len(field))[:, None]
    for _ in range(rounds):
        total = np.zeros_like(field)
        np.add.at(total, sides[:, 0], field[sides[:, 1]])
        np.add.at(total, sides[:, 1], field[sides[:, 0]])
        field = field + where[:, None] * (total / np.maximum(count, 1) - field)
    return field


def _furrow(head: Head, sign: float, line: tuple[tuple[float, float], ...]) -> Floats:
    """The middle of the furrow pulled in, its outer bank up and out."""
    skin = head.skin
    x, y, z = (skin.vertices * np.array([sign, 1.0, 1.0])).T
    away, along = _from_line(np.c_[x, y], np.array(line))
    ends = smoothstep(-0.15, 0.2, along) * smoothstep(1.2, 0.75, along) * smoothstep(-10.0, 5.0, z)
    normals = vertex_normals(skin.vertices, skin.triangles)
    groove = -1.7 * np.exp(-(((away + 0.5) / 2.6) ** 2)) * ends
    bank = 2.4 * np.exp(-(((away - 6.0) / 5.0) ** 2)) * ends
    lifted = np.array([0.35 * sign, 1.0, 0.0]) * (1.6 * np.exp(-(((away - 5.0) / 6.0) ** 2)) * ends)[:, None]
    return np.asarray(normals * (groove + bank)[:, None] + lifted)


def _from_line(points: Floats, line: Floats) -> tuple[Floats, Floats]:
    """Signed distance from a broken line (positive on its outer, upper side) and the share of its length, per point."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    starts = np.r_[0.0, np.cumsum(lengths)][:-1] / lengths.sum()
    best, along = np.full(len(points), np.inf), np.zeros(len(points))
    for number, (a, b) in enumerate(pairwise(line)):
        step = b - a
        share = (points - a) @ step / (step @ step)
        first, last = number == 0, number == len(line) - 2
        foot = a + np.clip(share, 0, 1)[:, None] * step
        arm = points - foot
        outward = np.array([-step[1], step[0]]) / np.linalg.norm(step)
        distance = np.linalg.norm(arm, axis=1)
        nearer = distance < np.abs(best)
        best = np.where(nearer, np.where(arm @ outward >= 0, distance, -distance), best)
        free = np.clip(share, None if first else 0.0, None if last else 1.0)
        along = np.where(nearer, starts[number] + free * lengths[number] / lengths.sum(), along)
    return best, along


def _sharp_pull(head: Head, side: str, sign: float) -> Floats:
    """A smile whose corner goes straight up, under a puffed cheek."""
    skin = head.skin
    smile = skin.shapes["mouthSmile" + side]
    x, y, _ = (skin.vertices * np.array([sign, 1.0, 1.0])).T
    cheek = np.exp(-(((x - 40.0) / 18.0) ** 2) - (((y + 44.0) / 18.0) ** 2))[:, None]
    pulled = smile * np.array([0.30, 0.95, 0.75]) + 0.45 * cheek * skin.shapes["cheekPuff"]
    corner = np.exp(-(((x - 32.0) / 14.0) ** 2) - (((y + 58.0) / 14.0) ** 2))
    soft = corner * (1 - np.clip(head.masks["lips"] * 2, 0, 1)) * (1 - head.masks["inside-mouth"])
    return _smoothed(head, np.asarray(pulled), soft, rounds=14)


def _tightened(head: Head) -> Floats:
    """Both lips drawn towards the line where they meet, narrower, and a little back."""
    skin = head.skin
    x, y, z = skin.vertices.T
    loop = skin.vertices[head.lip_loop]
    order = np.argsort(loop[:, 0])
    seam = np.interp(x, loop[order, 0], loop[order, 1])
    reach = np.sqrt((x / 31.0) ** 2 + ((y - seam) / 17.0) ** 2)
    near = smoothstep(1.0, 0.25, reach) * smoothstep(-25.0, 5.0, z) * (1 - head.masks["inside-mouth"])
    offsets = np.zeros_like(skin.vertices)
    offsets[:, 0] = -0.07 * x * near
    offsets[:, 1] = -0.42 * (y - seam) * near
    offsets[:, 2] = -1.3 * near * head.masks["lips"]
    return offsets
