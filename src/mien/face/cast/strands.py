"""Strands: where they grow out of the skin, ribbons along them, and how they are coloured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.cast.made_person import Person, looks
from mien.face.cast.noise import layered_noise, smoothstep
from mien.face.cast.scalp import hair_depth
from mien.face.head_space import SKIN, HeadSpace
from mien.face.model import Face, Material, Part
from mien.face.surface import vertex_normals

__all__ = ["Ground", "Roots", "along", "roots_drawn", "strand_colours", "strands_part"]

_LANES = 12

Floats = NDArray[np.float64]
Indices = NDArray[np.integer[Any]]


class Ground:
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
        self._skin = cKDTree(self.skin)
        self.middle = np.array([0.0, 20.0, -70.0])

    def depth(self, lines: Floats, cut: Mapping[str, Any]) -> Floats:
        """How far inside the hair the skin nearest to each point of ``lines`` (k, points, 3) is, mm (k, points)."""
        _, near = self._skin.query(lines.reshape(-1, 3))
        return np.asarray(hair_depth(self.space.rest[near], cut).reshape(lines.shape[:2]), dtype=np.float64)

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
class Roots:
    """Where strands start: triangle corners with shares, the place on the head and on the default head, the normal."""

    corners: Indices  # (k, 3)
    shares: Floats
    place: Floats
    rest: Floats
    normal: Floats


def roots_drawn(ground: Ground, growth: Floats, count: int, chance: np.random.Generator, grown: Any) -> Roots:
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
    return Roots(corners, shares, place, rest, normal)


def along(direction: Floats, normal: Floats) -> Floats:
    """Directions (k, 3) laid flat onto the surface with these normals, of unit length."""
    flat = direction - (direction * normal).sum(axis=1, keepdims=True) * normal
    return np.asarray(flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-6))


def _ribbons(
    line: Floats, normals: Floats, width: Floats, twist: Floats, lane: Indices, slant: Floats
) -> tuple[Floats, Indices, Floats]:
    """Vertices, triangles and texture coordinates of ribbons that end in a point, or, where ``slant``, are cut off."""
    count, points, _ = line.shape
    heading = np.gradient(line, axis=1) if points > 2 else np.repeat(line[:, 1:] - line[:, :1], 2, axis=1)
    across = np.cross(heading, normals)
    across /= np.maximum(np.linalg.norm(across, axis=2, keepdims=True), 1e-6)
    across = across * np.cos(twist)[:, None, None] + normals * np.sin(twist)[:, None, None]
    t = np.arange(points - 1) / (points - 1)
    taper = np.where(slant[:, None] != 0, 1 - 0.5 * t**4, 1 - t**4)
    half = 0.5 * width[:, None] * (0.3 + 0.7 * np.minimum(1, 4 * t)) * taper
    sides = half[..., None] * across[:, :-1]
    body = np.stack([line[:, :-1] - sides, line[:, :-1] + sides], axis=2).reshape(count, -1, 3)
    tip = line[:, -1] + slant[:, None] * sides[:, -1]
    vertices = np.concatenate([body, tip[:, None]], axis=1)
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


def strand_colours(person: Person, layer: Floats, chance: np.random.Generator) -> Floats:
    """A colour for each strand: between dark and light, some turned grey, the inner ones in the shade."""
    dark, light = (np.array(colour) for colour in person.hair_colour)
    tone = np.clip(0.5 + 0.18 * chance.normal(size=(len(layer), 1)), 0, 1)
    colour = dark + (light - dark) * tone
    silver, white = (np.array(c) for c in (looks()["hair_colours"]["grey"][1], looks()["hair_colours"]["white"][1]))
    turned = np.clip(1.25 * person.grey + 0.35 * (chance.uniform(size=(len(layer), 1)) - 0.6) * (person.grey > 0), 0, 1)
    colour = colour + (silver + (white - silver) * max(0.0, person.grey - 0.5) * 1.6 - colour) * turned
    return np.asarray(colour * (0.55 + 0.45 * smoothstep(0.0, 0.75, layer))[:, None])


def strands_part(
    name: str,
    line: Floats,
    normals: Floats,
    width: Floats,
    layer: Floats,
    person: Person,
    chance: np.random.Generator,
    twist: float = 0.1,
    blunt: bool = False,
) -> Part:
    """Ribbons along lines (k, points, 3), ``width`` mm wide and turned by about ``twist`` radians, as a part.

    They end in points, or ``blunt``: as if cut off.

    ``layer`` (k,) is 0 for the innermost strands, which lie in the shade, and 1 for the outermost.
    """
    count = len(line)
    lane = chance.integers(_LANES, size=count)
    slant = chance.choice([-0.8, -0.3, 0.3, 0.8], size=count) if blunt else np.zeros(count)
    vertices, triangles, uv = _ribbons(line, normals, width, twist * chance.normal(size=count), lane, slant)
    colours = np.repeat(strand_colours(person, layer, chance), len(vertices) // count, axis=0)
    # Hair on the shoulders stays with them when the head turns.
    weight = 0.35 + 0.65 * smoothstep(-190.0, -80.0, vertices[:, 1])
    material = Material("hair", texture=_streaks(person.seed), roughness=0.55, specular=0.13)
    return Part(
        name, vertices.astype(np.float32), triangles.astype(np.int32), uv.astype(np.float32),
        np.clip(colours, 0, 1).astype(np.float32), material, weight.astype(np.float32),
    )  # fmt: skip
