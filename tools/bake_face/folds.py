"""Draw the folds that muscles make in the default face's skin, as shade on its texture.

::

    python tools/bake_face/folds.py src/mien/assets/render/folds.npz

The skin's mesh is too coarse for most folds (4 mm between vertices on the forehead); the furrows it can hold (between
the brows, on the nose, in a smile) are in its shapes (`muscles`, `strength`). All hand-made: which muscle makes which
fold follows Hjortsjö 1969 (Man's Face and Mimic Language) and the FACS manual (Ekman, Friesen & Hager 2002); places,
widths and depths were chosen by looking. Run it again whenever the skin's texture coordinates change.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
from makehuman import Floats
from raster import rasterise

from mien.face.folds import layout_digest
from mien.face.library import load_face

SIZE = 1024  # texels to a side
_BANK = 0.30  # how light the banks of a fold are, for a groove of 1

# name: lines as (x, y) mm on the speaker's left, width mm, depth 0..1, drivers (channel: share; {side} for a side)
Line = tuple[tuple[float, float], ...]
_FOREHEAD = (33.5, 40.5, 48.0)  # heights of its folds
FOLDS: dict[str, tuple[list[Line], float, float, dict[str, float]]] = {
    "forehead-middle": (
        [((-3.0, y - 0.3), (4.0, y), (12.0, y + 1.0), (22.0, y + 1.8)) for y in _FOREHEAD],
        1.3,
        0.8,
        {"browInnerUp": 1.0, "browInnerUp{side}": 1.0},
    ),
    "forehead-side": (
        [((13.0, y + 1.1), (22.0, y + 1.8), (31.0, y + 0.4), (38.0, y - 3.5)) for y in _FOREHEAD],
        1.3,
        0.8,
        {"browOuterUp{side}": 1.0},
    ),
    "between-brows": (
        [((4.6, 9.0), (5.4, 17.0), (6.6, 26.0)), ((10.5, 20.0), (11.5, 26.0))],
        1.5,
        0.9,
        {"browDown{side}": 1.0, "noseSneer{side}": 0.35},
    ),
    "root-of-nose": (
        [((-8.0, 3.0), (0.0, 4.2), (8.0, 3.0))],
        1.0,
        0.7,
        {"noseSneer{side}": 0.4, "browDown{side}": 0.2},
    ),
    "nose": (
        [((4.0, -5.0), (9.0, -9.5), (13.0, -16.0)), ((5.0, -11.0), (10.0, -15.0), (14.0, -21.0))],
        0.9,
        0.8,
        {"noseSneer{side}": 1.0},
    ),
    "crows-feet": (
        [((50.0, 3.0), (57.0, 8.0)), ((51.0, 0.0), (60.0, 0.5)), ((50.0, -3.5), (58.0, -8.0))],
        0.9,
        0.7,
        {"cheekSquint{side}": 0.9, "eyeSquint{side}": 0.2},
    ),
    "below-eye": (
        [((17.0, -9.0), (26.0, -13.0), (36.0, -13.5), (45.0, -9.5))],
        1.1,
        0.7,
        {"cheekSquint{side}": 0.7, "eyeSquint{side}": 0.5},
    ),
    "smile": (
        [((15.5, -40.5), (20.5, -47.5), (26.5, -55.5), (32.0, -63.0), (36.5, -70.0), (38.5, -77.0))],
        1.6,
        0.6,
        {"mouthSmile{side}": 1.0, "mouthSharpPull{side}": 0.8},
    ),
    "sneer": (
        [((16.0, -38.0), (22.0, -46.5), (29.0, -56.0))],
        1.4,
        0.9,
        {"noseSneer{side}": 0.8, "mouthUpperUp{side}": 0.6, "nasolabialDeepen{side}": 1.0},
    ),
    "beside-mouth": (
        [((29.0, -58.0), (31.0, -64.0), (30.0, -70.0))],
        1.1,
        0.7,
        {"mouthDimple{side}": 1.0, "mouthStretch{side}": 0.6, "mouthSmile{side}": 0.3},
    ),
    "below-corner": ([((26.5, -67.5), (29.0, -74.0), (29.5, -82.0))], 1.3, 0.8, {"mouthFrown{side}": 1.0}),
    "chin": (
        [((-13.0, -85.5), (-6.0, -82.5), (0.0, -82.0), (6.0, -82.5), (13.0, -85.5))],
        1.6,
        0.9,
        {"mouthShrugLower": 1.0},
    ),
}
MIDDLE = ("root-of-nose", "chin")  # folds that run across the middle; the others have two sides


def texels_of_skin() -> tuple[Floats, np.ndarray]:
    """Place in mm of each texel that the skin's front covers (k, 3), and its number (k,)."""
    skin = load_face("default").part("skin")
    _, index, shares = rasterise(
        skin.uv.astype(float) * SIZE, np.zeros(len(skin.vertices)), skin.triangles.astype(np.int64), SIZE, SIZE
    )
    covered = index >= 0
    corners = skin.vertices[skin.triangles[index[covered]]].astype(float)
    places = np.einsum("kc,kcf->kf", shares[covered], corners)
    front = places[:, 2] > -15
    return places[front], np.flatnonzero(covered)[front]


def _away(points: Floats, line: Line) -> tuple[Floats, Floats]:
    """Distance from a broken line, and how far along it (0..1)."""
    best, along = np.full(len(points), np.inf), np.zeros(len(points))
    lengths = [float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in pairwise(line)]
    gone = 0.0
    for (a, b), length in zip(pairwise(line), lengths, strict=True):
        step = np.subtract(b, a)
        share = np.clip((points - a) @ step / (step @ step), 0, 1)
        distance = np.linalg.norm(points - a - share[:, None] * step, axis=1)
        nearer = distance < best
        best = np.where(nearer, distance, best)
        along = np.where(nearer, (gone + share * length) / sum(lengths), along)
        gone += length
    return best, along


def shade(points: Floats, lines: list[Line], width: float, depth: float) -> Floats:
    """How much darker (above 0) or lighter each point is where the fold is full."""
    total = np.zeros(len(points))
    for line in lines:
        away, along = _away(points, line)
        fade = np.sin(np.pi * np.clip(0.06 + 0.88 * along, 0, 1))
        groove = np.exp(-((away / width) ** 2))
        bank = np.exp(-(((away - 2.4 * width) / (1.2 * width)) ** 2))
        total = np.maximum(total, depth * fade * groove) - _BANK * depth * fade * bank * (groove < 0.3)
    return total


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="where the file goes")
    given = parser.parse_args()
    places, numbers = texels_of_skin()
    arrays: dict[str, np.ndarray] = {
        "size": np.array(SIZE),
        "layout": np.frombuffer(layout_digest(load_face("default").part("skin").uv).encode(), dtype=np.uint8),
    }
    for name, (lines, width, depth, drivers) in FOLDS.items():
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            if name in MIDDLE and side == "Right":
                continue
            points = places[:, :2] * [sign, 1.0]
            dark = np.rint(127 * np.clip(shade(points, lines, width, depth), -1, 1)).astype(np.int8)
            kept = np.flatnonzero(np.abs(dark) > 2)
            key = name if name in MIDDLE else f"{name}-{side.lower()}"
            sides = ("Left", "Right") if name in MIDDLE else (side,)
            driven = {c.format(side=s): share for c, share in drivers.items() for s in sides}
            arrays[f"{key}.texels"], arrays[f"{key}.shade"] = numbers[kept].astype(np.int32), dark[kept]
            arrays[f"{key}.drivers"] = np.frombuffer(
                " ".join(f"{c}={share}" for c, share in driven.items()).encode(), dtype=np.uint8
            )
            print(key, len(kept))
    with given.out.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    print(given.out, given.out.stat().st_size)


if __name__ == "__main__":
    main()
