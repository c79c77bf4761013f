"""Folds come with the muscles that make them, on the default face's texture and on no other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.channels import ALL
from mien.face.folds import _box, _resized, drawn_folds, folds_of
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    face = load_face("default")
    return Renderer(face, 64, 64, Camera.head_shot(face, 1.0))


def _row(**weights: float) -> np.ndarray:
    row = np.zeros(len(ALL))
    for name, weight in weights.items():
        row[ALL.index(name)] = weight
    return row


def test_every_driver_is_a_channel_and_every_fold_is_seen() -> None:
    for fold in drawn_folds()[1]:
        assert set(fold.drivers) <= set(ALL), fold.name
        assert fold.shade.max() > 0.4, fold.name


def test_a_face_at_rest_has_its_own_texture(renderer: Renderer) -> None:
    poser = Poser(renderer.face, ALL)
    renderer.folded(poser.pose(_row(browInnerUp=1.0)))
    assert np.array_equal(renderer.folded(poser.pose(_row())), renderer.scene.texels)


def test_raised_brows_darken_the_forehead_and_nothing_else(renderer: Renderer) -> None:
    poser = Poser(renderer.face, ALL)
    folded = renderer.folded(poser.pose(_row(browInnerUp=1.0))).astype(int)
    change = folded - renderer.scene.texels.astype(int)
    assert change.min() < -15
    forehead = np.concatenate(
        [np.flatnonzero(f.shade) for f in drawn_folds()[1] if f.name.startswith("forehead-middle")]
    )
    first, wide, _ = next(level for level in renderer.scene.texture_level[0].tolist() if level[1] == 1024)
    rows = np.flatnonzero((change != 0).any(axis=1))
    rows = rows[(rows >= first) & (rows < first + wide * wide)] - first
    assert set(rows.tolist()) <= set(forehead.tolist())


def test_a_fold_grows_with_its_muscle() -> None:
    chin = next(fold for fold in drawn_folds()[1] if fold.name == "chin")
    weights = [chin.weight({"mouthShrugLower": w}) for w in (0.0, 0.25, 0.5, 1.0, 3.0)]
    assert weights[0] == 0
    assert weights == sorted(weights)
    assert weights[-1] == 1


def test_other_texture_coordinates_have_no_folds(renderer: Renderer) -> None:
    levels = renderer.scene.texture_level
    skin = renderer.face.part("skin")
    assert folds_of(skin, levels[0][levels[0][:, 1] > 0]) is not None
    assert all(folds_of(part, levels[0]) is None for part in renderer.face.parts if part.name != "skin")


def test_a_skin_without_folds_has_none() -> None:
    part = next(p for p in load_face("default").parts if p.name == "skin")
    smooth = replace(part, material=replace(part.material, folds=0.0))
    assert folds_of(smooth, np.array([[0, 8, 8]], np.int32)) is None


def test_a_fold_has_the_same_size_in_every_level() -> None:
    shade = next(fold for fold in drawn_folds()[1] if fold.name == "chin").shade
    total = float(shade[np.abs(shade) > 0.015].sum()) / shade.size
    for size in (2048, 1024, 512, 256):
        _, _, values = _resized(shade, _box(shade), size, size)
        assert float(values.sum()) / size**2 == pytest.approx(total, rel=0.1)
