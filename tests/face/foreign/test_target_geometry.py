"""Targets told by what they move: on our own face, squeezed and moved, and on a head that others made."""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.face.foreign.target_geometry import likenesses
from mien.face.library import load_face
from mien.face.model import Face, Material, Part, Target

FAMILY = {"mouthDimple": "mouthSmile", "mouthFunnel": "mouthPucker", "mouthShrugLower": "mouthClose"}


@pytest.fixture(scope="module")
def squeezed() -> Face:
    """The skin of the default face, wider and lower, its targets without their names."""
    skin = max(load_face("default").parts, key=lambda part: len(part.targets))
    size = np.array([1.12, 0.9, 1.0], dtype=np.float32)
    targets = {f"t_{name}": Target(t.vertices, t.offsets * size) for name, t in skin.targets.items()}
    part = replace(skin, vertices=skin.vertices * size + np.float32(6.0), targets=targets)
    return Face("squeezed", (part,), (), (0.0, 0.0, 0.0), {}, "")


def test_a_squeezed_face_of_ours_is_laid_over_itself_and_its_shapes_are_known(squeezed: Face) -> None:
    found, registration = likenesses(squeezed)
    assert registration.trusted
    wanted = ("jawOpen", "mouthSmileLeft", "mouthPucker", "eyeBlinkLeft", "eyeBlinkRight", "browDownLeft",
              "browInnerUp", "noseSneerRight",
              "mouthFrownRight", "mouthUpperUpLeft", "cheekPuff", "jawForward")  # fmt: skip
    right = [name for name in wanted if list(found[f"t_{name}"].recipe) == [name]]
    assert len(right) >= len(wanted) - 1
    assert found["t_jawOpen"].sure
    back = registration.back(np.zeros((1, 3)))[0]
    assert np.abs(back[:2] - 6.0).max() < 8.0


def test_channels_that_are_not_looked_for_are_compared_all_the_same(squeezed: Face) -> None:
    """So that a lid that follows the eye is no lie, though it moves as one that closes."""
    found, _ = likenesses(squeezed)
    for name in ("eyeLookDownLeft", "eyeLookUpRight", "browInnerUpLeft", "mouthSharpPullLeft"):
        assert list(found[f"t_{name}"].recipe) != [name]
        assert found[f"t_{name}"].others[name] > 0.9
        assert found["t_jawOpen"].others[name] < 0.25


def test_a_face_whose_targets_move_at_random_is_not_trusted() -> None:
    random = np.random.default_rng(3)
    skin = max(load_face("default").parts, key=lambda part: len(part.targets))
    targets: Mapping[str, Target] = {
        f"{n}": Target(
            np.sort(random.choice(len(skin.vertices), 400, replace=False)).astype(np.int32),
            random.normal(0, 4, (400, 3)).astype(np.float32),
        )
        for n in range(12)
    }
    found, registration = likenesses(Face("x", (replace(skin, targets=targets),), (), (0, 0, 0), {}, ""))
    assert not registration.trusted
    assert not any(likeness.sure for likeness in found.values())


@pytest.mark.data
def test_a_production_head_is_known_without_a_name(shared_data: Path) -> None:
    with gzip.open(shared_data / "ict-head" / "neutral.obj.gz", "rt") as handle:
        lines = handle.read().split("\n")
    points = np.array([[float(x) for x in line.split()[1:4]] for line in lines if line.startswith("v ")]) * 10
    corners = [[int(x.split("/")[0]) - 1 for x in line.split()[1:]] for line in lines if line.startswith("f ")]
    triangles = np.array([(c[0], c[k], c[k + 1]) for c in corners for k in range(1, len(c) - 1)], dtype=np.int32)
    with np.load(shared_data / "ict-head" / "shapes.npz") as shapes:
        names = sorted({key.split(".")[0] for key in shapes.files})
        targets = {
            name: Target(shapes[f"{name}.vertices"].astype(np.int32), shapes[f"{name}.offsets"].astype(np.float32) * 10)
            for name in names
            if "eyeLook" not in name
        }
    count = len(points)
    plain = (np.zeros((count, 2), np.float32), np.ones((count, 3), np.float32), Material("m", (1, 1, 1)))
    part = Part("head", points.astype(np.float32), triangles, *plain, np.ones(count, np.float32), targets)
    found, _ = likenesses(Face("ict", (part,), (), (0, 0, 0), {}, ""))
    right = wrong = 0
    for name, likeness in found.items():
        wanted = name.replace("_L", "Left").replace("_R", "Right").replace("cheekRaiser", "cheekSquint")
        wanted = next((whole for whole in ("browInnerUp", "cheekPuff") if whole in wanted), wanted)
        same = list(likeness.recipe) == [wanted]
        right += same
        stem = wanted.removesuffix("Left").removesuffix("Right")
        kin = FAMILY.get(stem, stem)
        wrong += likeness.sure and not same and not next(iter(likeness.recipe)).startswith(kin)
    assert right >= 0.8 * len(found)
    assert wrong == 0
