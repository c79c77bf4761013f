"""Where hair, brows and beard grow, as functions of the place on the default head (mm). Hand-made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.cast.noise import smoothstep

__all__ = ["beard_growth", "brow_growth", "hair_depth", "hair_growth"]

_AXIS_Z = -75.0  # the hairline is described by the azimuth about this upright line
# Azimuth in degrees from the front, and the height of the hairline there, over the eyes.
_HAIRLINE = np.array([
    (0, 66), (12, 66), (24, 68), (34, 67), (43, 60), (52, 47), (61, 34), (69, 18), (75, 2), (78, -8), (83, -10),
    (86, 10), (92, 15), (101, 14), (105, 0), (108, -28), (114, -46), (128, -55), (150, -60), (180, -63),
], dtype=float)  # fmt: skip
_BALD = np.array([0.0, 104.0, -70.0])

Floats = NDArray[np.floating]


def hair_depth(place: Floats, cut: Mapping[str, Any]) -> Floats:
    """How far inside the hair a point of the head is, mm (negative: outside)."""
    azimuth = np.degrees(np.arctan2(np.abs(place[:, 0]), place[:, 2] - _AXIS_Z))
    at, height = _HAIRLINE.T
    front = smoothstep(75, 45, at)
    height = height + float(cut.get("line", 0)) * front
    height = height + float(cut.get("recede", 0)) * np.exp(-(((at - 38) / 14) ** 2))
    line = np.interp(azimuth, at, height)
    slope = np.abs(np.interp(azimuth + 1, at, height) - np.interp(azimuth - 1, at, height)) / 2.6
    above = place[:, 1] - line
    # Beside a steep stretch of the line the way to it is shorter than the height over it; far above, no longer.
    steep = 1 / np.hypot(1, slope)
    depth = above * (steep + (1 - steep) * smoothstep(3.0, 30.0, above))
    bald = float(cut.get("bald", 0))
    if bald:
        away = np.linalg.norm((place - _BALD) * np.array([1.0, 1.0, 0.72]), axis=1)
        depth = np.minimum(depth, away - bald)
    return np.asarray(depth)


def hair_growth(place: Floats, cut: Mapping[str, Any]) -> Floats:
    """How much hair grows, 0..1 (ears not left out)."""
    return smoothstep(-4.0, 6.0, hair_depth(place, cut))


def brow_growth(place: Floats) -> Floats:
    """How thick the brows grow, 0..1."""
    side = np.abs(place[:, 0])
    share = np.clip((side - 11.0) / 37.0, 0, 1)
    # The inner end lowest: brows that start high look worried before anything is felt.
    middle = 14.0 + 5.0 * np.sin(np.pi * share**1.10 * 0.86) - 1.0 * share
    half = 3.2 * (1 - 0.62 * smoothstep(0.45, 1.0, share)) * (0.6 + 0.4 * smoothstep(-0.02, 0.2, share))
    inside = 1 - smoothstep(0.75, 1.25, np.abs(place[:, 1] - middle) / half)
    ends = smoothstep(9.5, 14.0, side) * smoothstep(49.5, 45.0, side)
    return np.asarray(inside * ends * (place[:, 2] > -5))


def beard_growth(place: Floats, style: Mapping[str, Any]) -> Floats:
    """How much beard grows, 0..1."""
    x, y, z = np.abs(place[:, 0]), place[:, 1], place[:, 2]
    # Moustache: between nose and lip, to just past the corners.
    lower = np.interp(x, [0, 8, 20, 28, 34], [-55, -56, -62, -69, -76])
    upper = np.interp(x, [0, 7, 15, 26, 34], [-47, -46, -49, -58, -66])
    moustache = smoothstep(lower - 1.5, lower + 1.5, y) * smoothstep(upper + 2.0, upper - 2.5, y)
    moustache = moustache * smoothstep(33, 28, x) * (z > 5) * (0.55 + 0.45 * smoothstep(1.0, 4.0, x))
    # Chin: below the lower lip, round the mouth.
    top = np.interp(x, [0, 5, 12, 22, 27, 31], [-79, -80, -83, -80, -70, -60])
    chin = smoothstep(top + 2, top - 2.5, y) * smoothstep(30, 23, x) * smoothstep(-112, -100, y) * (z > -20)
    chin = np.maximum(chin, smoothstep(-78, -81, y) * smoothstep(4.5, 2.5, x) * (y > -90) * (z > 10))
    where = style.get("where", "all")
    if where == "moustache":
        return np.asarray(moustache)
    if where == "goatee":
        return np.asarray(np.maximum(moustache, chin))
    # Cheeks: below a line from the sideburn to the corner of the mouth, over the jaw, a little down the neck.
    line = np.interp(z, [-75, -60, -30, -5, 14, 22], [0, -22, -46, -56, -62, -76])
    edge = smoothstep(line + 4, line - 5, y) * smoothstep(24, 31, x) * smoothstep(-78, -66, z)
    under = np.interp(z, [-70, -30, 0, 25], [-92, -112, -116, -118])
    return np.asarray(np.maximum.reduce([moustache, chin, edge]) * smoothstep(under - 8, under + 6, y))
