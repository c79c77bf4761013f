"""Hair: strands grown out of the skin, combed, falling, kept off the head; ribbons, drawn from both sides.

A strand starts at a place on the skin and takes steps; at each it is turned by the comb and by its weight, and what
would lie in the head is pushed out to the layer of hair that the strand belongs to. Inner strands are darker.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.cast.made_person import Person, looks
from mien.face.cast.noise import layered_noise, smoothstep
from mien.face.cast.scalp import hair_depth, hair_growth
from mien.face.cast.strands import Floats, Ground, Roots, along, roots_drawn, strand_colours, strands_part
from mien.face.head_space import HeadSpace
from mien.face.model import Face, Material, Part

__all__ = ["hair_parts"]

_CROWN = np.array([0.0, 98.0, -118.0])
_EAR_FREE = 0.25
_RISE = 24.0  # mm of its length in which a strand gets up to its layer
_FINER = 2  # long hair is grown in so many steps for each that is kept
_BLUNT = np.array([0.4, 0.6, 0.7, 0.8])  # its first pieces, where it leaves the head, as shares of the others
_TIP_MM = 4.5  # its last
_FRINGE_Y = 27.0  # mm over the eyes
_OFF_BROW = 6.0  # mm that hair may lie outside the hairline at the front
_CLEAR = 0.9  # mm that strands keep off the skin, whose shadow they would lie in


def _combed(
    cut: Mapping[str, Any], points: Floats, normal: Floats, part: float, tie: Floats | None, front: Floats
) -> Floats:
    """Which way the comb went at these points: unit vectors along the head."""
    comb = cut["comb"]
    if comb == "out":
        return normal
    if comb == "tie" and tie is not None:
        return along(tie - points, normal)
    away = points - _CROWN
    x, y, _ = points.T
    top = smoothstep(25.0, 75.0, y)[:, None]
    down = np.tile([0.0, -1.0, -0.25], (len(points), 1))
    if comb == "crown":
        return along(away, normal)
    if comb == "forward":
        return along(top * np.array([0.12, 0.0, 1.0]) + (1 - top) * np.array([0.0, -1.0, 0.25]), normal)
    if comb == "back":
        return along(top * np.array([0.0, 0.1, -1.0]) + (1 - top) * np.array([0.0, -0.45, -1.0]), normal)
    aside = np.tanh((x - part) / 9.0)[:, None] * np.array([1.0, 0.0, 0.0]) + np.array([0.0, -0.1, -0.45])
    if comb == "fringe":
        aside = aside + front[:, None] * (np.array([0.0, 0.0, 1.9]) - aside)
    return along(top * aside + (1 - top) * down, normal)


def _grow(
    ground: Ground,
    cut: Mapping[str, Any],
    roots: Roots,
    length: Floats,
    layer: Floats,
    thick: Floats,
    chance: np.random.Generator,
    part: float,
    tie: Floats | None,
    front: Floats,
) -> tuple[Floats, Floats]:
    """Points (k, steps + 1, 3) of strands, and the ground's normals below them."""
    count, steps = len(length), int(cut["steps"]) * (_FINER if "drop" in cut else 1)
    step = (length / steps)[:, None]
    lift, fall = float(cut["lift"]), float(cut["fall"])
    stray = chance.normal(size=(count, 3)) * (0.10 if tie is None else 0.03)
    place, normal = roots.place - 0.3 * roots.normal, roots.normal
    heading = _combed(cut, roots.place, normal, part, tie, front) + lift * normal + stray
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    line, normals = [place], [normal]
    for number in range(steps):
        place = place + step * heading
        height, normal = ground.height(place)
        wanted = layer * thick * np.minimum(1.0, (number + 1) * step[:, 0] / _RISE) + _CLEAR
        if tie is not None:
            wanted = wanted * np.clip(np.linalg.norm(tie - place, axis=1) / 30, 0.3, 1)
        place = place + np.maximum(wanted - height, 0)[:, None] * normal
        if cut["comb"] != "out":  # short hair and tied hair lie on, all hair on top of the head
            lies = 0.5 if fall < 0.3 else 0.9 * smoothstep(15.0, 55.0, place[:, 1])
            place = place - (lies * np.maximum(height - 1.15 * wanted - 1.0, 0))[:, None] * normal
        moved = place - line[-1]
        moved /= np.maximum(np.linalg.norm(moved, axis=1, keepdims=True), 1e-6)
        free = smoothstep(4.0, 30.0, height)[:, None] if fall >= 0.3 else np.zeros((count, 1))
        comb = _combed(cut, place, normal, part, tie, front)
        falls = fall * np.maximum(1 - 0.9 * smoothstep(30.0, 70.0, place[:, 1]), front)[:, None]
        heading = 0.55 * moved + (1 - falls) * (1 - free) * comb + falls * np.array([0.0, -1.0, 0.0]) + 0.25 * stray
        heading /= np.maximum(np.linalg.norm(heading, axis=1, keepdims=True), 1e-6)
        if tie is not None:
            near = np.linalg.norm(tie - place, axis=1, keepdims=True)
            heading = heading * np.minimum(1.0, near / step)
        line.append(place)
        normals.append(normal)
    return np.stack(line, axis=1), np.stack(normals, axis=1)


def _curled(
    line: Floats, normals: Floats, radius: float, pitch: float, chance: np.random.Generator, together: bool
) -> Floats:
    """Strands wound about their own way, the roots held; neighbours ``together`` (waves) or each for itself (curls)."""
    steps = line.shape[1] - 1
    reach = np.cumsum(np.linalg.norm(np.diff(line, axis=1), axis=2), axis=1)
    along = np.concatenate([np.zeros((len(line), 1)), reach], axis=1)
    heading = np.gradient(line, axis=1)
    heading /= np.maximum(np.linalg.norm(heading, axis=2, keepdims=True), 1e-6)
    one = np.cross(heading, normals)
    one /= np.maximum(np.linalg.norm(one, axis=2, keepdims=True), 1e-6)
    other = np.cross(one, heading)
    own, start = chance.uniform(0.8, 1.2, (len(line), 1)), chance.uniform(size=(len(line), 1))
    if together:
        own, start = 1 + 0.15 * (own - 1), 0.5 * layered_noise(line[:, 0], 38.0, 9, layers=2)[:, None] + 0.12 * start
    turn = 2 * np.pi * (along / pitch * own + start)
    size = radius * chance.uniform(0.6, 1.3, (len(line), 1)) * np.minimum(1, np.arange(steps + 1) / 2)[None]
    return np.asarray(line + size[..., None] * (np.cos(turn)[..., None] * one + np.sin(turn)[..., None] * other))


def hair_parts(space: HeadSpace, face: Face, person: Person) -> tuple[Part, ...]:
    """The hair of a person, on their face (whose skin and shirt are there already)."""
    cut = looks()["cuts"][person.hair]
    if not cut["count"]:
        return ()
    ground, chance = Ground(space, face), np.random.default_rng([person.seed, 3])
    free = 1 - smoothstep(0.05, _EAR_FREE, space.ears)
    growth = hair_growth(space.rest, cut) * free
    count = int(cut["count"])

    crown = 0.5 if "drop" in cut else 0.25

    def grown(rest: Floats) -> Floats:
        depth = hair_depth(rest, cut)
        edge = smoothstep(-1.0, 2.5, depth + chance.normal(0, 1.4, len(rest)))
        return np.asarray(
            edge * (0.45 + 0.55 * smoothstep(18.0, 3.0, depth) + crown * smoothstep(40.0, 90.0, rest[:, 1]))
        )

    roots = roots_drawn(ground, growth, count, chance, grown)
    keep = smoothstep(0.05, _EAR_FREE, np.einsum("kc,kc->k", roots.shares, space.ears[roots.corners])) < 0.5
    roots = Roots(*(field[keep] for field in vars(roots).values()))
    count = len(roots.place)
    top = smoothstep(10.0, 78.0, roots.rest[:, 1])
    inside = smoothstep(-2.0, 22.0, hair_depth(roots.rest, cut))
    low, high = cut["length"]
    length = (low + (high - low) * top) * (0.55 + 0.45 * inside) * chance.uniform(0.82, 1.12, count)
    thin, deep = cut["thick"]
    thick = (thin + (deep - thin) * top) * (0.35 + 0.65 * inside)
    # What is tied lies flat, and of long hair most lies in the outer layer, which closes.
    layer = chance.uniform(size=count) ** (0.25 if "to" in cut else 0.45 if "drop" in cut else 0.7)
    part = float(chance.choice([-24.0, 24.0, 4.0]))
    thick = thick * _at_parting(cut, roots.rest, part)
    front = ((roots.rest[:, 2] > -50) & (np.abs(roots.rest[:, 0]) < 56) & (cut["comb"] == "fringe")).astype(float)
    tie = np.array([0.0, *cut["to"]]) if "to" in cut else None
    if "rows" in cut:
        length, layer = length, layer * 0.5 + 0.5 * np.abs(np.sin(np.pi * cut["rows"] * _turn(roots.rest) / 2)) ** 0.5
    if "drop" in cut:
        reach = np.maximum(roots.place[:, 1] - float(cut["drop"]), 18) * (1.0 + 0.45 * top) + 25
        length = np.where(front > 0.5, 110.0, reach)
    line, normals = _grow(ground, cut, roots, length, layer, thick, chance, part, tie, front)
    if "drop" in cut:
        line, normals = _cut_off(line, normals, _ends(cut, line, layer, front, person, chance), int(cut["steps"]))
    for key in ("curl", "wave"):
        if key in cut:
            radius, pitch = cut[key]
            line = _curled(line, normals, radius, pitch, chance, key == "wave")
    width = float(cut["width"]) * chance.uniform(0.7, 1.25, count) * (0.35 + 0.65 * inside)
    if float(cut["fall"]) >= 0.3:
        width = width * (1 + 0.9 * smoothstep(0.55, 0.1, layer))  # inner strands fill the gaps
    kept = np.flatnonzero(~(_over_the_face(ground, cut, line) & (front < 0.5) & (length > 60)))
    kept = kept[np.argsort(-layer[kept], kind="stable")]  # the outermost are drawn first: they hide the others
    pieces = [(line[kept], normals[kept], width[kept], layer[kept])]
    if tie is not None:
        pieces.append(_tied(cut, ground, tie, person, chance))
    named = zip(("hair", "hair_tail"), pieces, strict=False)
    twist = 0.1 if tie is None else 0.06
    parts = [strands_part(name, *piece, person, chance, twist, "drop" in cut) for name, piece in named]
    return (_cap(space, face, ground, cut, person, part), *parts) if cut.get("cap", 1) else tuple(parts)


def _over_the_face(ground: Ground, cut: Mapping[str, Any], line: Floats) -> NDArray[np.bool_]:
    """Which strands hang into the face."""
    x, y, z = np.moveaxis(line, 2, 0)
    over = ((np.abs(x) < 60) & (y < 56) & (z > 6)).any(axis=1)
    if "drop" in cut:
        # Nor do single strands hang on the brow or before the ear.
        outside = ground.depth(line, cut) < -_OFF_BROW
        over |= (outside & (np.where(y > 20, z + 5, z + 45) > 0)).any(axis=1)
    return np.asarray(over)


def _ends(
    cut: Mapping[str, Any], line: Floats, layer: Floats, front: Floats, person: Person, chance: np.random.Generator
) -> Floats:
    """The height at which each strand is cut: all at one, but for a little; a fringe above the brows."""
    wave = layered_noise(line[:, -1] * np.array([1.0, 0.0, 1.0]), 22.0, person.seed + 72, layers=2)
    level = np.where(front > 0.5, _FRINGE_Y, float(cut["drop"]))
    soft = np.where(front > 0.5, 1.0, 1.6 if float(cut["drop"]) > -150 else 4.0)
    return np.asarray(level + soft * (1.2 * wave + chance.normal(0, 0.6, len(line)) + 1.5 * (1 - layer)))


def _cut_off(line: Floats, normals: Floats, level: Floats, steps: int) -> tuple[Floats, Floats]:
    """Strands that end at these heights, in so many pieces: short ones at the head and at the tip."""
    pieces = np.r_[_BLUNT, np.ones(max(steps - 1 - len(_BLUNT), 1))]
    inner = np.cumsum(pieces) / pieces.sum()
    new, turned = np.empty((len(line), len(inner) + 2, 3)), np.empty((len(line), len(inner) + 2, 3))
    for n, (points, upright) in enumerate(zip(line, normals, strict=True)):
        reach = np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
        below = np.flatnonzero(points[:, 1] < level[n])
        end = reach[-1]
        if len(below) and below[0]:
            b = below[0]
            share = (points[b - 1, 1] - level[n]) / (points[b - 1, 1] - points[b, 1])
            end = reach[b - 1] + share * (reach[b] - reach[b - 1])
        at = np.r_[0, inner * max(end - _TIP_MM, 0.7 * end), end]
        for k in range(3):
            new[n, :, k] = np.interp(at, reach, points[:, k])
            turned[n, :, k] = np.interp(at, reach, upright[:, k])
    return new, turned


def _at_parting(cut: Mapping[str, Any], rest: Floats, part: float) -> Floats:
    """How thick hair lies beside the parting, 0..1: there it starts, and neither stands up nor hides behind a layer."""
    if cut["comb"] not in ("side", "fringe"):
        return np.ones(len(rest))
    return np.asarray(0.2 + 0.8 * smoothstep(2.0, 34.0, np.abs(rest[:, 0] - part)))


def _turn(rest: Floats) -> Floats:
    """Azimuth about the head's long axis, in half turns: what rows of braids are counted along."""
    return np.asarray(np.arctan2(rest[:, 0], rest[:, 1] - 20.0) / (np.pi / 2))


def _tied(
    cut: Mapping[str, Any], ground: Ground, tie: Floats, person: Person, chance: np.random.Generator
) -> tuple[Floats, Floats, Floats, Floats]:
    """What hangs or sits where hair is tied: a tail that falls, or a knot."""
    count = 420
    layer = chance.uniform(size=count) ** 0.6
    turn = chance.uniform(0, 2 * np.pi, count)
    if "tail" in cut:
        steps = 9
        t = np.linspace(0, 1, steps + 1)[None]
        length = float(cut["tail"]) * chance.uniform(0.8, 1.05, (count, 1))
        wide = (5 + 13 * np.sin(np.pi * np.minimum(t * 0.8 + 0.12, 1))) * layer[:, None]
        x = np.cos(turn)[:, None] * wide
        z = tie[2] - 6 - 26 * np.sin(np.pi * np.minimum(t * 1.1, 1)) * 0.8 + np.sin(turn)[:, None] * wide * 0.8
        y = tie[1] + 8 * np.sin(np.pi * np.minimum(t * 2.2, 1)) - length * t**1.25
        line = np.stack([x, y * np.ones_like(x), z * np.ones_like(x)], axis=2)
        normals = np.stack(
            [np.cos(turn)[:, None] * np.ones_like(x), 0 * x, np.sin(turn)[:, None] * np.ones_like(x)], axis=2
        )
        return line, normals, np.full(count, 2.6), layer
    radius = float(cut["knot"]) * 0.62
    _, out = ground.height(tie[None])
    centre = tie + out[0] * radius * 0.75
    tilt = chance.uniform(-0.95, 0.95, count)
    t = np.linspace(0, 1, 9)[None] * chance.uniform(1.2, 2.4, (count, 1)) + turn[:, None]
    ring = np.sqrt(np.maximum(1 - (tilt[:, None] + 0.12 * np.sin(2 * t)) ** 2 * 0.9, 0.02))
    axis = out[0]
    one = np.cross(axis, [1.0, 0.0, 0.0])
    one /= np.linalg.norm(one)
    other = np.cross(axis, one)
    size = radius * (0.86 + 0.14 * layer)[:, None, None]
    normals = ring[..., None] * (np.cos(t)[..., None] * one + np.sin(t)[..., None] * other) + tilt[:, None, None] * axis
    return centre + size * normals, normals, np.full(count, 3.0), layer


def _cap(space: HeadSpace, face: Face, ground: Ground, cut: Mapping[str, Any], person: Person, part: float) -> Part:
    """A dark layer below the strands, so that no skin shows between them; sunk into the skin at the hairline."""
    triangles = space.triangles[(hair_depth(space.rest, cut)[space.triangles] > -9).any(axis=1)]
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    rest, place, normal = space.rest[used], ground.skin[used], ground.normals[used]
    ears = space.ears[used]
    local, ends = _split(local, len(rest))
    rest, place, normal = (np.vstack([f, f[ends].mean(axis=1)]) for f in (rest, place, normal))
    ears = np.r_[ears, ears[ends].max(axis=1)]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    depth = hair_depth(rest, cut) - 40 * smoothstep(0.0, 0.2, ears)
    thin, deep = cut["thick"]
    full = float(cut.get("cap", 0.22)) * (thin + (deep - thin) * smoothstep(10.0, 78.0, rest[:, 1]))
    full = full * (1 + 0.12 * layered_noise(rest, 16.0, person.seed + 70, layers=2)) if "cap" in cut else full
    lift = full * _at_parting(cut, rest, part) * smoothstep(2.0, 26.0, depth) - 1.6 * smoothstep(6.0, 0.0, depth)
    weight = 0.35 + 0.65 * smoothstep(-190.0, -80.0, place[:, 1])
    dark = np.asarray(strand_colours(person, np.full(1, 0.3), np.random.default_rng(0)))[0]
    grain = {"side": (0.15, 0.4, 1.0), "fringe": (0.4, 0.4, 0.8), "back": (1.0, 0.4, 0.2)}.get(cut["comb"], (1, 1, 1))
    speck = 1 + 0.35 * layered_noise(rest * np.array(grain), 4.5, person.seed + 71, layers=2)[:, None]
    keep = (depth[local] > -8).any(axis=1)
    used, local = np.unique(local[keep], return_inverse=True)
    vertices = (place + lift[:, None] * normal)[used]
    return Part(
        "hair_cap", vertices.astype(np.float32), local.reshape(-1, 3).astype(np.int32),
        np.zeros((len(used), 2), np.float32), np.clip(dark * speck, 0, 1)[used].astype(np.float32),
        Material("hair_cap", roughness=0.9, specular=0.05), weight[used].astype(np.float32),
    )  # fmt: skip


def _split(triangles: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Every triangle in four; the new vertices stand amid the ends (e, 2) that are given back."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    ends, place = np.unique(sides, axis=0, return_inverse=True)
    ab, bc, ca = place.reshape(3, -1) + count
    a, b, c = triangles.T
    return np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]), ends
