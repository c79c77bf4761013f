"""Guided components: hidden motions come back in the order in which the stages ask for them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mien.capture.layouts import load_layout
from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.face.deformers import with_tree
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.tree_posing import TreePoser
from mien.motion.mouth.articulatory import STAGES, ArticulatoryModel, articulatory_tree
from tests.another_face import another_face

LAYOUT = load_layout("mediapipe-218")
MOUTH = LAYOUT.groups["mouth"]
PLACES = LAYOUT.places[[LAYOUT.markers.index(name) for name in MOUTH]]


def hidden() -> np.ndarray:
    """Jaw, width, protrusion and two more over the mouth's markers, (5, markers, 3), mm."""
    x, y, _ = PLACES.T
    below = np.clip((-64 - y) / 30, 0, 1)
    lips = np.exp(-(((y + 66) / 9) ** 2))
    nothing = np.zeros_like(x)
    jaw = np.stack([nothing, -4 * below, -1.5 * below], axis=1)
    width = np.stack([x / 25 * lips * 1.5, nothing, nothing], axis=1)
    forward = np.stack([nothing, nothing, 1.0 * lips], axis=1)
    lift = np.stack([nothing, 0.8 * lips * (y > -66), nothing], axis=1)
    slant = np.stack([nothing, 0.4 * lips * x / 25, nothing], axis=1)
    return np.array([jaw, width, forward, lift, slant])


@pytest.fixture(scope="module")
def learned() -> SimpleNamespace:
    scores = np.random.default_rng(0).normal(size=(800, 5))
    frames = PLACES + np.einsum("tk,kmd->tmd", scores, hidden())
    return SimpleNamespace(model=ArticulatoryModel().fit(frames, MOUTH, "mediapipe-218"), frames=frames, scores=scores)


def test_stages_find_what_they_are_asked_for(learned: SimpleNamespace) -> None:
    found = learned.model.scores(learned.frames - learned.model.mean_)
    for number in range(3):
        assert np.corrcoef(found[:, number], learned.scores[:, number])[0, 1] > 0.97, STAGES[number].name
    np.testing.assert_allclose(found.std(axis=0), 1, atol=0.02)
    assert learned.model.explained_.sum() == pytest.approx(1, abs=0.01)
    assert (learned.model.explained_ >= 0).all()


def test_each_stage_takes_out_what_it_explains(learned: SimpleNamespace) -> None:
    """Scores of different stages do not go together: what one explains is regressed out before the next."""
    found = learned.model.scores(learned.frames - learned.model.mean_)
    together = np.corrcoef(found.T) - np.eye(5)
    assert np.abs(together).max() < 0.02
    np.testing.assert_allclose(learned.model.positions(found), learned.frames, atol=0.35)


def test_on_another_face_the_lips_part_and_channels_are_met(learned: SimpleNamespace) -> None:
    face, numbers = another_face(load_face())
    tree = articulatory_tree(learned.model, face)
    names = [*ALL, "articulation_jaw_opening"]
    moved, skin = TreePoser(replace(face, tree=tree), names), [part.name for part in face.parts].index("skin")
    row = np.array([2.0 * (name == "articulation_jaw_opening") for name in names])
    offsets = moved.pose(row).parts[skin].vertices - face.parts[skin].vertices
    lower, upper = (numbers[load_face().sites[f"lip_{lip}_outer"][1]] for lip in ("lower", "upper"))
    assert offsets[lower, 1] < offsets[upper, 1] - 1
    smile = np.array([float(name == "mouthSmileRight") for name in names])
    asked = Poser(face, names[:-1]).pose(smile[:-1]).parts[skin].vertices
    assert np.linalg.norm(moved.pose(smile).parts[skin].vertices - asked, axis=1).max() < 1.0


def test_frames_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="expected frames of 48 markers"):
        ArticulatoryModel().fit(np.zeros((4, 3, 3)), MOUTH, "mediapipe-218")
    with pytest.raises(InputError, match="does not move"):
        ArticulatoryModel().fit(np.zeros((4, 48, 3)), MOUTH, "mediapipe-218")


def test_the_parameters_move_the_default_face(learned: SimpleNamespace) -> None:
    face = load_face()
    moved = with_tree(face, articulatory_tree(learned.model, face))
    names = [*ALL, *(f"articulation_{stage.name}" for stage in STAGES)]
    poser, skin = TreePoser(moved, names), [part.name for part in face.parts].index("skin")

    def offsets(**values: float) -> np.ndarray:
        row = np.array([values.get(name, 0.0) for name in names])
        return poser.pose(row).parts[skin].vertices - face.parts[skin].vertices

    lower = face.sites["lip_lower_inner"][1]
    corner = face.sites["lip_corner_left"][1]
    jaw = offsets(articulation_jaw_opening=2.0)
    assert jaw[face.sites["chin"][1], 1] < -3
    outer = [face.sites[f"lip_{lip}_outer"][1] for lip in ("lower", "upper")]
    assert jaw[outer[0], 1] < jaw[outer[1], 1] - 1
    teeth = [part.name for part in face.parts].index("teeth_lower")
    row = np.array([2.0 * (name == "articulation_jaw_opening") for name in names])
    dropped = poser.pose(row).parts[teeth].vertices[:, 1] - face.parts[teeth].vertices[:, 1]
    assert dropped.mean() < -1
    assert offsets(articulation_mouth_width=2.0)[corner, 0] > 1
    assert offsets(articulation_lip_protrusion=2.0)[lower, 2] > 1
    assert np.linalg.norm(offsets(articulation_jaw_opening=2.0)[face.sites["brow_inner_left"][1]]) < 0.2
    # What five parameters of speech cannot say, such as a smile, leaves say: channels do what the targets do.
    plain = Poser(face, ALL)
    for channel, weight in (("mouthSmileLeft", 1.0), ("mouthPucker", 1.0), ("jawOpen", 1.0), ("mouthFunnel", 0.5)):
        asked = plain.pose(np.array([weight * (name == channel) for name in ALL])).parts[skin].vertices
        missed = np.linalg.norm(offsets(**{channel: weight}) + face.parts[skin].vertices - asked, axis=1)
        assert missed.max() < (1.0 if channel != "jawOpen" else 2.0), channel
    # Channels drive the parameters too, and the upper face keeps its own leaves.
    assert offsets(jawOpen=0.3)[face.sites["chin"][1], 1] < -3
    assert offsets(browInnerUp=1.0)[face.sites["brow_inner_left"][1], 1] > 2
