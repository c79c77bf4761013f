"""What makes an eye somebody's: the iris, a white that years make duller, and the wet line on the lower lid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.face.cast.made_person import Person
from mien.face.cast.noise import smoothstep
from mien.face.contact import split_loop
from mien.face.head_space import SKIN, HeadSpace
from mien.face.model import Eye, Face, Material, Part, Target

__all__ = ["iris_picture", "wet_line"]

_IRIS = 0.395  # radians from the optical axis to the rim of the iris, as the default eye is painted
_POWER = 0.6  # bends the eye's texture so that the iris gets more of it
_FAIR, _DARK = np.array([0.76, 0.56, 0.52]), np.array([0.44, 0.29, 0.26])  # of the lid's margin under the film
_HIGH, _OVER = 0.75, 0.10  # mm: how far the wet line climbs up the eyeball, and how far over it it stands

Floats = NDArray[np.float64]


def iris_picture(picture: NDArray[np.uint8] | None, person: Person) -> NDArray[np.uint8]:
    """The default eye's picture with another iris and an older or younger white."""
    assert picture is not None
    size = len(picture)
    grid = (np.arange(size) + 0.5) / size - 0.5
    x, y = np.meshgrid(grid, grid)
    theta = np.pi * np.minimum(np.hypot(x, y) / 0.5, 1) ** (1 / _POWER)
    radius = theta / _IRIS
    colour = picture / 255.0
    light = colour.mean(axis=2)
    ring = np.minimum((radius * 60).astype(int), 80)
    inside = radius < 1.35
    mean = np.bincount(ring[inside], light[inside], 81) / np.maximum(np.bincount(ring[inside], minlength=81), 1)
    fibre = 1 + 1.25 * (light / np.maximum(mean[ring], 1e-3) - 1)
    inner, outer = (np.array(c) for c in person.eyes)
    share = smoothstep(0.40, 0.85, radius)[..., None]
    iris = (inner + (outer - inner) * share) * np.clip(fibre, 0.55, 1.6)[..., None]
    iris = iris * (1 - 0.66 * smoothstep(0.80, 1.0, radius))[..., None]
    there = (smoothstep(1.07, 0.96, radius) * smoothstep(0.34, 0.39, radius))[..., None]
    white = smoothstep(1.0, 1.1, radius)[..., None]
    dull = np.array([0.02, 0.045, 0.10]) * (0.35 + person.ageing) + np.array([0.03, 0.045, 0.06]) * person.tone
    red = smoothstep(1.6, 3.0, radius)[..., None] * np.array([0.02, 0.10, 0.11])
    colour = colour * (1 - white * (dull + red))
    colour = colour + (iris - colour) * there
    return np.asarray(np.rint(np.clip(colour, 0, 1) * 255), dtype=np.uint8)


def wet_line(space: HeadSpace, face: Face, person: Person) -> Part:
    """The film of tears between the lower lids and the eyeballs: a narrow shiny strip that goes with the lid."""
    skin = face.part(SKIN)
    rest = skin.vertices.astype(np.float64)
    pieces: list[Floats] = []
    triangles: list[NDArray[np.int64]] = []
    owners: list[NDArray[np.int64]] = []
    for eye in face.eyes:
        loop = (space.lid_loop_left if eye.side == "Left" else space.lid_loop_right).astype(np.int64)
        _, lower, corners = split_loop(space.rest, loop)
        row = np.array([corners[0], *lower, corners[1]])
        row = row[np.argsort(space.rest[row, 0])]
        owners.append(row)
        start = sum(len(piece) for piece in pieces)
        pieces.append(_strip(rest[row], eye, _radius(face, eye)))
        a = start + np.arange(len(row) - 1)
        b = a + len(row)
        triangles += [np.stack([a, a + 1, b], axis=1), np.stack([b, a + 1, b + 1], axis=1)]
    vertices = np.vstack(pieces)
    targets = {}
    for name, target in skin.targets.items():
        offsets = np.zeros_like(rest)
        offsets[target.vertices] = target.offsets
        if max(np.abs(offsets[row]).max() for row in owners) <= 0.02:
            continue
        posed = [
            _strip((rest + offsets)[row], eye, _radius(face, eye)) for eye, row in zip(face.eyes, owners, strict=True)
        ]
        moved = np.vstack(posed) - vertices
        rows = np.flatnonzero(np.abs(moved).max(axis=1) > 0.02).astype(np.int32)
        targets[name] = Target(rows, moved[rows].astype(np.float32))
    count = len(vertices)
    red, green, blue = (_FAIR + (_DARK - _FAIR) * person.tone).tolist()
    material = Material("tears", (red, green, blue), roughness=0.10, specular=0.75)
    return Part(
        "tears", vertices.astype(np.float32), np.vstack(triangles).astype(np.int32), np.zeros((count, 2), np.float32),
        np.ones((count, 3), np.float32), material, np.ones(count, np.float32), targets,
    )  # fmt: skip


def _radius(face: Face, eye: Eye) -> float:
    return float(np.median(np.linalg.norm(face.part(eye.part).vertices - np.array(eye.centre), axis=1)))


def _strip(margin: Floats, eye: Eye, radius: float) -> Floats:
    """The lid's margin, and the same points climbed up the eyeball; low where the lids meet."""
    centre = np.array(eye.centre)
    high = _HIGH * np.sin(np.pi * np.linspace(0.04, 0.96, len(margin)))[:, None] * np.array([0.0, 1.0, 0.0])
    arm = margin + high - centre
    upper = centre + arm / np.linalg.norm(arm, axis=1, keepdims=True) * (radius + _OVER)
    return np.vstack([margin, upper])
