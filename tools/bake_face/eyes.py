"""Eyeballs: a sphere with a cornea, and a painted iris."""

from __future__ import annotations

import numpy as np
from makehuman import Floats
from noise import layered_noise, value_noise
from sculpt import Sculpt, smoothstep

from mien.face.model import Eye

IRIS_ANGLE = 0.395  # radians from the optical axis to the rim of the iris
_PUPIL_SHARE = 0.36  # of the iris's radius
_CORNEA_RISE = 0.035  # of the eyeball's radius
_TEXTURE_POWER = 0.6  # bends the texture's radius so that the iris gets more of it
_RINGS, _SPOKES = 44, 56
_CARUNCLE = (1.5, 0.1, -1.7)  # mm outward, up and forward from the lids' inner corner
_CARUNCLE_SIZE = np.array([2.0, 1.5, 1.5])  # mm
_TURN = {"look_up": 18.0, "look_down": 24.0, "look_in": 28.0, "look_out": 30.0}  # degrees at weight 1


def build_eye(name: str, centre: Floats, radius: float) -> Sculpt:
    """One eyeball looking straight ahead."""
    angle = np.r_[np.linspace(0, 0.6, 22), np.linspace(0.66, np.pi * 0.72, _RINGS - 22)]
    around = np.linspace(0, 2 * np.pi, _SPOKES, endpoint=False)
    theta, phi = (grid.ravel() for grid in np.meshgrid(angle, around, indexing="ij"))
    reach = radius * (1 + _CORNEA_RISE * (1 - smoothstep(0.0, IRIS_ANGLE * 1.25, theta)))
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    corner = np.arange(_SPOKES)
    triangles = []
    for ring in range(_RINGS - 1):
        a, b = ring * _SPOKES + corner, ring * _SPOKES + np.roll(corner, -1)
        triangles += [np.stack([a, a + _SPOKES, b], axis=1), np.stack([b, a + _SPOKES, b + _SPOKES], axis=1)]
    eye = Sculpt(name, centre + reach[:, None] * points, np.vstack(triangles))
    out = 0.5 * (theta / np.pi) ** _TEXTURE_POWER
    eye.uv = 0.5 + out[:, None] * np.stack([np.cos(phi), -np.sin(phi)], axis=1)
    return eye


def eye_entry(part: str, side: str, centre: Floats) -> Eye:
    """How the eyeball turns."""
    x, y, z = (round(float(c), 3) for c in centre)
    return Eye(part=part, side=side, centre=(x, y, z), **_TURN)


def paint_eye(size: int, seed: int) -> Floats:
    """Picture of an eyeball, shape (size, size, 3), sRGB 0..1."""
    grid = (np.arange(size) + 0.5) / size - 0.5
    x, y = (a.ravel() for a in np.meshgrid(grid, grid))
    theta = np.pi * np.minimum(np.hypot(x, y) / 0.5, 1) ** (1 / _TEXTURE_POWER)
    phi = np.arctan2(-y, x)
    colour = _sclera(theta, phi, seed)
    iris = _iris(theta / IRIS_ANGLE, phi, seed)
    inside = 1 - smoothstep(IRIS_ANGLE * 0.95, IRIS_ANGLE * 1.07, theta)
    colour = colour + (iris - colour) * inside[:, None]
    pupil = 1 - smoothstep(_PUPIL_SHARE * 0.94, _PUPIL_SHARE * 1.06, theta / IRIS_ANGLE)
    colour = colour * (1 - pupil[:, None]) + np.array([0.012, 0.010, 0.012]) * pupil[:, None]
    return np.clip(colour, 0, 1).reshape(size, size, 3)


def build_caruncles(corners: Floats) -> Sculpt:
    """The small pink flesh in the inner corner of each eye; ``corners`` (2, 3) are the lids' inner corners."""
    turn, rise = np.meshgrid(np.linspace(0, 2 * np.pi, 13)[:-1], np.linspace(0, np.pi, 9), indexing="ij")
    ball = np.stack([np.sin(rise) * np.cos(turn), np.cos(rise), np.sin(rise) * np.sin(turn)], axis=2).reshape(-1, 3)
    column, row = (grid.ravel() for grid in np.meshgrid(np.arange(12), np.arange(8), indexing="ij"))
    a, b = column * 9 + row, (column + 1) % 12 * 9 + row
    faces = np.vstack([np.stack([a, b, a + 1], axis=1), np.stack([b, b + 1, a + 1], axis=1)])
    pieces = [
        corner + np.array([np.sign(corner[0]) * _CARUNCLE[0], *_CARUNCLE[1:]]) + ball * _CARUNCLE_SIZE
        for corner in corners
    ]
    both = Sculpt("caruncles", np.vstack(pieces), np.vstack([faces, faces + len(ball)]))
    both.colours = np.tile([0.80, 0.50, 0.46], (len(both.vertices), 1))
    return both


def _sclera(theta: Floats, phi: Floats, seed: int) -> Floats:
    white = np.array([0.70, 0.68, 0.66])  # in an eye, under brow and lashes: about as light as the skin around
    warm = np.array([0.68, 0.55, 0.50])
    share = 0.55 * smoothstep(0.75, 1.5, theta)
    cloud = 0.012 * layered_noise(np.stack([theta * np.cos(phi), theta * np.sin(phi)], axis=1), 0.25, seed)
    return np.asarray(white + (warm - white) * share[:, None] + cloud[:, None])


def _iris(radius: Floats, phi: Floats, seed: int) -> Floats:
    """Brown-hazel iris; ``radius`` is 1 at its rim."""
    turn = np.stack([np.cos(phi), np.sin(phi)], axis=1)
    fibres = value_noise(np.c_[turn * 9, radius * 1.2], 0.35, seed + 7) * 0.6
    fibres = fibres + value_noise(np.c_[turn * 22, radius * 2.0], 0.5, seed + 8) * 0.4
    inner, outer = np.array([0.45, 0.29, 0.13]), np.array([0.27, 0.19, 0.115])
    base = inner + (outer - inner) * smoothstep(0.42, 0.85, radius + 0.1 * fibres)[:, None]
    base = base * (1 + 0.30 * fibres)[:, None]
    collar = np.exp(-(((radius - 0.52 - 0.03 * fibres) / 0.05) ** 2))
    base = base * (1 + 0.22 * collar)[:, None]
    limbal = smoothstep(0.80, 1.0, radius)
    return np.asarray(base * (1 - 0.72 * limbal)[:, None])
