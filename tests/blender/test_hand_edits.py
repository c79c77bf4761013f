"""What was edited by hand moves with its words; the head's file comes back as it was written. Without Blender."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np

from mien.face.foreign.gltf_document import read_gltf
from mien.face.foreign.known_face import known_face
from mien.formats.driven_glb import drive_glb
from tests.faces import tiny_animation


def part(name: str):
    path = Path(__file__).parents[2] / "blender" / "mien_blender" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"blender_{name}", path)
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def line(*words: tuple[str, float]) -> dict:
    """Words one after another, each of one phone."""
    ends = np.cumsum([seconds for _, seconds in words])
    tier = [[float(end - seconds), float(end), label] for (label, seconds), end in zip(words, ends, strict=True)]
    return {"words": tier, "phones": tier}


def test_an_edit_is_carried_to_its_word_and_stretched_with_it():
    edits = part("hand_edits")
    old, new = line(("a", 1.0), ("b", 1.0)), line(("x", 0.5), ("a", 1.0), ("b", 2.0))
    edit = np.zeros(20)
    edit[10:] = 1.0  # on b, at 10 frames a second
    seconds = np.arange(35) / 10
    carried = edits.Moved(old, new).carried(edit, 10.0, seconds)
    assert not carried[:14].any()
    assert (carried[16:] == 1).all()


def test_an_edit_on_a_word_that_is_gone_is_reported():
    edits = part("hand_edits")
    edit = np.zeros(20)
    edit[12] = 0.5
    moved = edits.Moved(line(("a", 1.0), ("b", 1.0)), line(("a", 1.0), ("c", 1.0)))
    assert moved.lost({"shape x": edit}, 10.0) == ["b"]
    assert not moved.carried(edit, 10.0, np.arange(20) / 10).any()


def test_only_what_differs_is_an_edit():
    edits = part("hand_edits")
    written = {"shape a": np.array([0.1, 0.2]), "shape b": np.array([0.0, 0.0])}
    now = {"shape a": np.array([0.1, 0.2]), "shape b": np.array([0.0, 0.3]), "shape c": np.array([0.5, 0.5])}
    found = edits.edits_of(now, written)
    assert set(found) == {"shape b", "shape c"}
    np.testing.assert_allclose(found["shape c"], 0.5)


def test_moved_phones_become_border_edits():
    edits = part("hand_edits")
    words, phones = (
        [[0.0, 1.0, "no"], [1.0, 2.0, "no"]],
        [[0.0, 0.4, "N"], [0.4, 1.0, "OW"], [1.0, 1.5, "N"], [1.5, 2.0, "OW"]],
    )
    (moved,) = edits.moved_borders(phones, words, {3: 1.6}, 0.01)
    assert moved == {
        "kind": "border", "phone": {"word": "no", "occurrence": 2, "phone": 1}, "edge": "start", "shift": 0.1,
    }  # fmt: skip


def test_a_head_goes_out_and_its_motion_comes_back(tmp_path):
    heads = part("head_file")
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (40, 3))
    opened = np.where(points[:, 1:2] < 0, [0.0, -0.02, 0.0], 0.0)
    shapes = heads.Shapes(
        points, np.arange(39).reshape(-1, 3), [("jawOpen", opened, 0.0), ("nothing", 0 * opened, 0.0)]
    )
    nodes = [heads.Node("skin", shapes=shapes), heads.Node("head", (0, -0.1, 0), (0, 0.6, 0, 0.8), joint=True)]
    heads.write_head(tmp_path / "head.glb", nodes)
    assert read_gltf(tmp_path / "head.glb").json["meshes"][0]["extras"]["targetNames"] == ["jawOpen", "nothing"]
    track = tiny_animation().channels
    drive_glb(track, known_face(tmp_path / "head.glb"), tmp_path / "driven.glb")
    motion = heads.read_motion(tmp_path / "driven.glb")
    np.testing.assert_allclose(motion.seconds, track.rate.times(len(track)), atol=1e-6)
    np.testing.assert_allclose(motion.weights[0][:, 0], track.channel("jawOpen"), atol=1e-6)
    assert not motion.weights[0][:, 1].any()
    assert motion.turns[1].shape == (len(track), 4)
