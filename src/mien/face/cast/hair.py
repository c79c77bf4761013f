"""Hair and beards: strands grown out of the skin, combed, falling, kept off the head; ribbons, drawn from both sides.

A strand starts at a place on the skin and takes steps; at each it is turned by the comb and by its weight, and what
would lie in the head is pushed out to the layer of hair that the strand belongs to. Inner strands are darker.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.cast.noise import layered_noise, smoothstep
from mien.face.cast.person import Person, looks
from mien.face.cast.scalp import beard_growth, hair_depth, hair_growth
from mien.face.head_space import SKIN, HeadSpace
from mien.face.model import Face, Material, Part, Target
from mien.face.surface import vertex_normals

__all__ = ["beard_part", "hair_parts"]

_CROWN = np.array([0.0, 98.0, -118.0])
_EAR_FREE = 0.25
_LANES = 12
_RISE = 24.0  # mm of its length in which a strand gets up to its layer
_CLEAR = 0.9  # mm that strands keep off the skin, whose shadow they would lie in

Floats = NDArray[np.float64]
Indices = NDArray[np.integer[Any]]


class _Ground:
    """The skin and the clothes that strands lie on."""

    def __init__(self, space: HeadSpace, face: Face) -> None:
        skin, shirt = face.part(SKIN), face.part("shirt")
        self.skin = skin.vertices.astype(np.float64)
        self.normals = vertex_normals(self.skin, skin.triangles)
        self.space = space
        outer = space.outer()
        cloth = shirt.vertices.astype(np.float64)
        cloth_normals = vertex_normals(cloth, shirt.triangles)
        self._points = np.vstack([self.skin[outer], cloth])
        self._normals = np.vstack([self.normals[outer], cloth_normals])
        self._tree = cKDTree(self._points)
        self.middle = np.array([0.0, 20.0, -70.0])

    def height(self, points: Floats) -> tuple[Floats, Floats]:
        """Heights over the ground (k,) and its normals there (k, 3): planes of the nearest vertices, blended."""
        away, near = self._tree.query(points, k=4)
        share = 1 / np.maximum(away, 0.5) ** 2
        share /= share.sum(axis=1, keepdims=True)
        normal = np.einsum("kn,knc->kc", share, self._normals[near])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6)
        height = np.einsum("kn,knc,knc->k", share, points[:, None] - self._points[near], self._normals[near])
        return height, normal


@dataclass(frozen=True, eq=False)
class _Roots:
    """Where strands start: triangle corners with shares, the place on the head and on the default head, the normal."""

    corners: Indices  # (k, 3)
    shares: Floats
    place: Floats
    rest: Floats
    normal: Floats


def _roots(ground: _Ground, growth: Floats, count: int, chance: np.random.Generator, grown: Any) -> _Roots:
    """``count`` places drawn by area and growth; ``grown`` says of places on the default head how much grows there."""
    triangles = ground.space.triangles
    there = triangles[(growth[triangles] > 0.01).any(axis=1)]
    a, b, c = (ground.skin[there[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    corners, shares = np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3))
    while len(corners) < count:
        more = there[chance.choice(len(there), size=3 * count, p=area / area.sum())]
        part = chance.dirichlet(np.ones(3), size=len(more))
        keep = chance.uniform(size=len(more)) < grown(np.einsum("kc,kcd->kd", part, ground.space.rest[more]))
        corners, shares = np.vstack([corners, more[keep]]), np.vstack([shares, part[keep]])
    corners, shares = corners[:count].astype(np.int32), shares[:count]
    place, rest, normal = (
        np.einsum("kc,kcd->kd", shares, field[corners]) for field in (ground.skin, ground.space.rest, ground.normals)
    )
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return _Roots(corners, shares, place, rest, normal)


def _tangent(direction: Floats, normal: Floats) -> Floats:
    flat = direction - (direction * normal).sum(axis=1, keepdims=True) * normal
    return np.asarray(flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-6))


def _combed(
    cut: Mapping[str, Any], points: Floats, normal: Floats, part: float, tie: Floats | None, front: Floats
) -> Floats:
    """Which way the comb went at these points: unit vectors along the head."""
    comb = cut["comb"]
    if comb == "out":
        return normal
    if comb == "tie" and tie is not None:
        return _tangent(tie - points, normal)
    away = points - _CROWN
    x, y, _ = points.T
    top = smoothstep(25.0, 75.0, y)[:, None]
    down = np.tile([0.0, -1.0, -0.25], (len(points), 1))
    if comb == "crown":
        return _tangent(away, normal)
    if comb == "forward":
        return _tangent(top * np.array([0.12, 0.0, 1.0]) + (1 - top) * np.array([0.0, -1.0, 0.25]), normal)
    if comb == "back":
        return _tangent(top * np.array([0.0, 0.1, -1.0]) + (1 - top) * np.array([0.0, -0.45, -1.0]), normal)
    aside = np.tanh((x - part) / 9.0)[:, None] * np.array([1.0, 0.0, 0.0]) + np.array([0.0, -0.1, -0.45])
    if comb == "fringe":
        aside = aside + front[:, None] * (np.array([0.0, 0.0, 1.9]) - aside)
    return _tangent(top * aside + (1 - top) * down, normal)


def _grow(
    ground: _Ground,
    cut: Mapping[str, Any],
    roots: _Roots,
    length: Floats,
    layer: Floats,
    thick: Floats,
    chance: np.random.Generator,
    part: float,
    tie: Floats | None,
    front: Floats,
) -> tuple[Floats, Floats]:
    """Points (k, steps + 1, 3) of strands, and the ground's normals below them."""
    count, steps = len(length), int(cut["steps"])
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


def _ribbons(
    line: Floats, normals: Floats, width: Floats, twist: Floats, lane: Indices
) -> tuple[Floats, Indices, Floats]:
    """Vertices, triangles and texture coordinates of ribbons that end in a point."""
    count, points, _ = line.shape
    heading = np.gradient(line, axis=1) if points > 2 else np.repeat(line[:, 1:] - line[:, :1], 2, axis=1)
    across = np.cross(heading, normals)
    across /= np.maximum(np.linalg.norm(across, axis=2, keepdims=True), 1e-6)
    across = across * np.cos(twist)[:, None, None] + normals * np.sin(twist)[:, None, None]
    t = np.arange(points - 1) / (points - 1)
    half = 0.5 * width[:, None] * ((0.3 + 0.7 * np.minimum(1, 4 * t)) * (1 - t**4))[None]
    sides = half[..., None] * across[:, :-1]
    body = np.stack([line[:, :-1] - sides, line[:, :-1] + sides], axis=2).reshape(count, -1, 3)
    vertices = np.concatenate([body, line[:, -1:]], axis=1)
    faces = [f for s in range(points - 2) for f in ((2 * s, 2 * s + 1, 2 * s + 2), (2 * s + 1, 2 * s + 3, 2 * s + 2))]
    faces.append((2 * points - 4, 2 * points - 3, 2 * points - 2))
    each = 2 * points - 1
    triangles = (np.array(faces)[None] + each * np.arange(count)[:, None, None]).reshape(-1, 3)
    u = (lane[:, None] + np.r_[np.tile([0.06, 0.94], points - 1), 0.5][None]) / _LANES
    v = np.r_[np.repeat(t, 2), 1.0][None] * np.ones((count, 1))
    return vertices.reshape(-1, 3), triangles, np.stack([u.ravel(), v.ravel()], axis=1)


def _streaks(seed: int) -> NDArray[np.uint8]:
    """A picture of fine hairs side by side, `_LANES` strands across, root above; multiplies a strand's colour."""
    tall, wide = 128, 32 * _LANES
    x, y = np.meshgrid(np.arange(wide), np.arange(tall))
    place = np.stack([x.ravel() * 1.0, y.ravel() * 0.045, np.zeros(x.size)], axis=1)
    fine = layered_noise(place, 3.2, seed, layers=2).reshape(tall, wide)
    broad = layered_noise(place, 13.0, seed + 5, layers=2).reshape(tall, wide)
    edge = np.abs((x % 32) / 31 * 2 - 1)
    tone = 0.84 + 0.20 * fine + 0.12 * broad - 0.18 * edge**4
    tone = tone * (0.66 + 0.34 * smoothstep(0.0, 0.30, y / tall))
    return np.repeat(np.rint(np.clip(tone, 0, 1) * 255).astype(np.uint8)[..., None], 3, axis=2)


def _strand_colours(person: Person, layer: Floats, chance: np.random.Generator) -> Floats:
    """A colour for each strand: between dark and light, some turned grey, the inner ones in the shade."""
    dark, light = (np.array(colour) for colour in person.hair_colour)
    tone = np.clip(0.5 + 0.18 * chance.normal(size=(len(layer), 1)), 0, 1)
    colour = dark + (light - dark) * tone
    silver, white = (np.array(c) for c in (looks()["hair_colours"]["grey"][1], looks()["hair_colours"]["white"][1]))
    turned = np.clip(1.25 * person.grey + 0.35 * (chance.uniform(size=(len(layer), 1)) - 0.6) * (person.grey > 0), 0, 1)
    colour = colour + (silver + (white - silver) * max(0.0, person.grey - 0.5) * 1.6 - colour) * turned
    return np.asarray(colour * (0.55 + 0.45 * smoothstep(0.0, 0.75, layer))[:, None])


def hair_parts(space: HeadSpace, face: Face, person: Person) -> tuple[Part, ...]:
    """The hair of a person, on their face (whose skin and shirt are there already)."""
    cut = looks()["cuts"][person.hair]
    if not cut["count"]:
        return ()
    ground, chance = _Ground(space, face), np.random.default_rng([person.seed, 3])
    free = 1 - smoothstep(0.05, _EAR_FREE, space.ears)
    growth = hair_growth(space.rest, cut) * free
    count = int(cut["count"])

    def grown(rest: Floats) -> Floats:
        depth = hair_depth(rest, cut)
        edge = smoothstep(-1.0, 2.5, depth + chance.normal(0, 1.4, len(rest)))
        return np.asarray(
            edge * (0.45 + 0.55 * smoothstep(18.0, 3.0, depth) + 0.25 * smoothstep(40.0, 90.0, rest[:, 1]))
        )

    roots = _roots(ground, growth, count, chance, grown)
    keep = smoothstep(0.05, _EAR_FREE, np.einsum("kc,kc->k", roots.shares, space.ears[roots.corners])) < 0.5
    roots = _Roots(*(field[keep] for field in vars(roots).values()))
    count = len(roots.place)
    top = smoothstep(10.0, 78.0, roots.rest[:, 1])
    inside = smoothstep(-2.0, 22.0, hair_depth(roots.rest, cut))
    low, high = cut["length"]
    length = (low + (high - low) * top) * (0.55 + 0.45 * inside) * chance.uniform(0.82, 1.12, count)
    thin, deep = cut["thick"]
    thick = (thin + (deep - thin) * top) * (0.35 + 0.65 * inside)
    layer = chance.uniform(size=count) ** (0.7 if "to" not in cut else 0.25)  # what is tied lies flat
    part = float(chance.choice([-24.0, 24.0, 4.0]))
    front = ((roots.rest[:, 2] > -50) & (np.abs(roots.rest[:, 0]) < 56) & (cut["comb"] == "fringe")).astype(float)
    tie = np.array([0.0, *cut["to"]]) if "to" in cut else None
    if "rows" in cut:
        length, layer = length, layer * 0.5 + 0.5 * np.abs(np.sin(np.pi * cut["rows"] * _turn(roots.rest) / 2)) ** 0.5
    if "drop" in cut:
        reach = np.maximum(roots.place[:, 1] - float(cut["drop"]), 18) * (1.0 + 0.30 * top)
        low = np.maximum(74 - roots.rest[:, 1], 0)
        reach = np.where(front > 0.5, 55.0 - low - np.minimum(roots.rest[:, 2], 12), reach)  # ends above the eyes
        length = np.minimum(length, reach * chance.uniform(0.93, 1.05, count))
    line, normals = _grow(ground, cut, roots, length, layer, thick, chance, part, tie, front)
    for key in ("curl", "wave"):
        if key in cut:
            radius, pitch = cut[key]
            line = _curled(line, normals, radius, pitch, chance, key == "wave")
    width = float(cut["width"]) * chance.uniform(0.7, 1.25, count) * (0.35 + 0.65 * inside)
    if float(cut["fall"]) >= 0.3:
        width = width * (1 + 0.9 * smoothstep(0.55, 0.1, layer))  # inner strands fill the gaps
    x, y, z = np.moveaxis(line, 2, 0)
    over = ((np.abs(x) < 60) & (y < 56) & (z > 6)).any(axis=1) & (front < 0.5) & (length > 60)
    kept = ~over  # no strand hangs into the face
    pieces = [(line[kept], normals[kept], width[kept], layer[kept])]
    if tie is not None:
        pieces.append(_tied(cut, ground, tie, person, chance))
    parts = [
        _part_of("hair" if n == 0 else "hair_tail", *piece, person, chance, 0.1 if tie is None else 0.06)
        for n, piece in enumerate(pieces)
    ]
    return (*parts, _cap(space, face, ground, cut, person)) if cut.get("cap", 1) else tuple(parts)


def _turn(rest: Floats) -> Floats:
    """Azimuth about the head's long axis, in half turns: what rows of braids are counted along."""
    return np.asarray(np.arctan2(rest[:, 0], rest[:, 1] - 20.0) / (np.pi / 2))


def _tied(
    cut: Mapping[str, Any], ground: _Ground, tie: Floats, person: Person, chance: np.random.Generator
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


def _part_of(
    name: str,
    line: Floats,
    normals: Floats,
    width: Floats,
    layer: Floats,
    person: Person,
    chance: np.random.Generator,
    twist: float = 0.1,
) -> Part:
    count = len(line)
    lane = chance.integers(_LANES, size=count)
    vertices, triangles, uv = _ribbons(line, normals, width, twist * chance.normal(size=count), lane)
    colours = np.repeat(_strand_colours(person, layer, chance), len(vertices) // count, axis=0)
    # Hair on the shoulders stays with them when the head turns.
    weight = 0.35 + 0.65 * smoothstep(-190.0, -80.0, vertices[:, 1])
    material = Material("hair", texture=_streaks(person.seed), roughness=0.55, specular=0.13)
    return Part(
        name, vertices.astype(np.float32), triangles.astype(np.int32), uv.astype(np.float32),
        np.clip(colours, 0, 1).astype(np.float32), material, weight.astype(np.float32),
    )  # fmt: skip


def _cap(space: HeadSpace, face: Face, ground: _Ground, cut: Mapping[str, Any], person: Person) -> Part:
    """A dark layer below the strands, so that no skin shows between them; sunk into the skin at the hairline."""
    triangles = space.triangles[(hair_depth(space.rest, cut)[space.triangles] > -9).any(axis=1)]
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    rest, place, normal = space.rest[used], ground.skin[used], ground.normals[used]
    ears = space.ears[used]
    for _ in range(2):
        local, ends = _split(local, len(rest))
        rest, place, normal = (np.vstack([f, f[ends].mean(axis=1)]) for f in (rest, place, normal))
        ears = np.r_[ears, ears[ends].max(axis=1)]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    depth = hair_depth(rest, cut) - 40 * smoothstep(0.0, 0.2, ears)
    thin, deep = cut["thick"]
    full = float(cut.get("cap", 0.22)) * (thin + (deep - thin) * smoothstep(10.0, 78.0, rest[:, 1]))
    full = full * (1 + 0.12 * layered_noise(rest, 16.0, person.seed + 70, layers=2)) if "cap" in cut else full
    lift = full * smoothstep(2.0, 26.0, depth) - 1.6 * smoothstep(6.0, 0.0, depth)
    weight = 0.35 + 0.65 * smoothstep(-190.0, -80.0, place[:, 1])
    dark = np.asarray(_strand_colours(person, np.full(1, 0.3), np.random.default_rng(0)))[0]
    speck = 1 + 0.25 * layered_noise(rest, 5.0, person.seed + 71, layers=2)[:, None]
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


def beard_part(space: HeadSpace, face: Face, person: Person) -> Part | None:
    """The beard, moved by the skin that it grows from; None without one."""
    if not person.beard:
        return None
    style, chance = looks()["beards"][person.beard], np.random.default_rng([person.seed, 4])
    ground = _Ground(space, face)
    red = 1 - smoothstep(0.05, 0.3, space.lips)
    growth = beard_growth(space.rest, style) * red * (space.inside_mouth < 0.5)
    roots = _roots(ground, growth, int(style["count"]), chance, lambda rest: beard_growth(rest, style))
    keep = (space.lips[roots.corners] * roots.shares).sum(axis=1) < 0.12
    keep &= (space.inside_mouth[roots.corners] * roots.shares).sum(axis=1) < 0.3
    roots = _Roots(*(field[keep] for field in vars(roots).values()))
    count, x, y = len(roots.place), roots.rest[:, 0], roots.rest[:, 1]
    upper = (y > -60) & (np.abs(x) < 30)
    aside = np.where(upper, np.sign(x) * smoothstep(0.0, 10.0, np.abs(x)) * 1.1, 0.12 * np.sign(x))
    way = np.stack([aside, np.where(upper, -0.75, -1.0), np.where(upper, 0.1, 0.15)], axis=1)
    growing = beard_growth(roots.rest, style)
    length = float(style["length"]) * chance.uniform(0.6, 1.15, count) * (0.35 + 0.65 * growing)
    length = length * np.where(upper, 0.6, 1.0) * (0.6 + 0.4 * smoothstep(-60.0, -85.0, y))
    heading = _tangent(way, roots.normal) + 0.35 * roots.normal + 0.2 * chance.normal(size=(count, 3))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    curve = np.array([0.0, -0.3, 0.0]) + 0.12 * chance.normal(size=(count, 3))
    t = np.linspace(0, 1, 3)[None, :, None]
    line = (
        roots.place[:, None]
        - 0.3 * roots.normal[:, None]
        + length[:, None, None] * (t * heading[:, None] + t**2 * curve[:, None])
    )
    normals = np.repeat(roots.normal[:, None], 3, axis=1)
    layer = chance.uniform(0.35, 1.0, count)
    part = _part_of(
        "beard", line, normals, float(style["width"]) * chance.uniform(0.8, 1.3, count), layer, person, chance
    )
    each = len(part.vertices) // count
    targets = {}
    for name, target in face.part(SKIN).targets.items():
        offsets = np.zeros((len(space.rest), 3))
        offsets[target.vertices] = target.offsets
        moved = np.einsum("kc,kcd->kd", roots.shares, offsets[roots.corners])
        chosen = np.flatnonzero(np.abs(moved).max(axis=1) > 0.02)
        if len(chosen):
            rows = (chosen[:, None] * each + np.arange(each)).ravel()
            targets[name] = Target(rows.astype(np.int32), np.repeat(moved[chosen], each, axis=0).astype(np.float32))
    return Part(**{**vars(part), "targets": targets, "head_weight": np.ones(len(part.vertices), np.float32)})
