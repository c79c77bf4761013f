"""Eyeballs: a sphere with a cornea, and a painted iris."""

from __future__ import annotations

import numpy as np
from makehuman import Floats
from noise import layered_noise, value_noise
from sculpt import Sculpt, smoothstep

from mien.face.face import Eye

IRIS_ANGLE = 0.395  # radians from the optical axis to the rim of the iris
_PUPIL_SHARE = 0.36  # of the iris's radius
_CORNEA_RISE = 0.035  # of the eyeball's radius
_TEXTURE_POWER = 0.6  # bends the texture's radius so that the iris gets more of it
_RINGS, _SPOKES = 44, 56
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


def _sclera(theta: Floats, phi: Floats, seed: int) -> Floats:
    white = np.array([0.915, 0.895, 0.875])
    warm = np.array([0.86, 0.70, 0.64])
    share = 0.55 * smoothstep(0.75, 1.5, theta)
    cloud = 0.012 * layered_noise(np.stack([theta * np.cos(phi), theta * np.sin(phi)], axis=1), 0.25, seed)
    return white + (warm - white) * share[:, None] + cloud[:, None]


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
    return base * (1 - 0.72 * limbal)[:, None]
