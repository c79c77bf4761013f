"""The extension in Blender itself: mien's face and a made head are performed, edited, performed again, undone."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mien.core.channels import TONGUE
from mien.core.timeline import FrameRate
from mien.face.posing import head_rotation
from mien.formats.livelink import write_livelink
from mien.formats.native import read_native, write_native
from tests.faces import tiny_animation
from tests.programs import blender_python

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def facts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blender")
    animation = tiny_animation(40, FrameRate.of(30))
    write_native(animation, folder / "line.json")
    write_livelink(animation, folder / "line.csv")
    program = ROOT / ".venv" / "bin" / "mien"
    ran = subprocess.run(
        [blender_python(), str(Path(__file__).with_name("in_blender.py")), str(folder)],
        env={**os.environ, "MIEN": str(program)}, capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    found = folder / "facts.json"
    assert found.is_file(), ran.stdout + ran.stderr
    found = json.loads(found.read_text(encoding="utf-8"))
    assert "traceback" not in found, found["traceback"] + ran.stdout
    return found | {"line": read_native(folder / "line.json")}


def keys_equal(points, values, start, step=1.0):
    frames, weights = np.array(points).T
    np.testing.assert_allclose(frames, start + np.arange(len(values)) * step)
    np.testing.assert_allclose(weights, values, atol=1e-4)


def test_every_channel_of_the_animation_is_keyframed_on_miens_own_face(facts):
    channels, curves = facts["line"].channels, facts["default"]["curves"]
    shapes = [name for name in channels.names if not name.startswith("head")]
    assert len(shapes) > 60
    for name in shapes:
        part = "tongue" if name in TONGUE or name == "tongueOut" else "face"
        keys_equal(curves[f"{part} {name}"], channels.channel(name), 11)
    assert facts["result"] == ["FINISHED"]


def test_the_bone_turns_as_the_head_of_the_animation(facts):
    angles = facts["line"].channels.select(("headYaw", "headPitch", "headRoll")).values[20]
    assert np.abs(angles).max() > 1
    np.testing.assert_allclose(facts["turned"]["head"], head_rotation(*angles), atol=1e-4)


def test_a_performance_is_undone(facts):
    assert facts["undone"] == [0, 0]


def test_sound_emotion_and_markers_lie_on_the_timeline(facts):
    sound, emotion = facts["sequencer"]
    assert sound[0] == "sound"
    assert sound[3] == 11
    assert emotion[:3] == ["emotion", "happy", "COLOR"]
    assert emotion[5], "an emotion strip that is not muted would be rendered"
    names = [name for name, _ in facts["markers"]]
    assert names[:4] == ["i", "never", "said", "that"]
    assert "/EH/" in names


def test_an_edit_by_hand_moves_along_with_its_word(facts):
    again = facts["again"]
    assert again["words"] == ["but", "i", "never", "said", "that"]
    assert again["edited"][0] == pytest.approx(again["said"], abs=2 / 30)
    assert again["most"] == pytest.approx(0.4, abs=0.01)
    assert again["emotions"][0]["intensity"] == pytest.approx(0.2), "the strip's opacity is the emotion's strength"


def test_a_moved_marker_moves_the_phone(facts):
    before, after = facts["shift"]
    assert after - before == pytest.approx(2 / 30, abs=0.5 / 30)


def test_a_made_head_of_another_convention_is_driven(facts):
    channels, curves = facts["line"].channels, facts["made"]["curves"]
    keys_equal(curves["Ball AU26"], channels.channel("jawOpen"), 11)
    assert {f"Head {k}" for k in range(4)} <= set(curves)


def test_a_live_link_recording_is_laid_on_it(facts):
    assert facts["import_result"] == ["FINISHED"]
    keys_equal(facts["imported"]["curves"]["Ball AU26"], facts["line"].channels.channel("jawOpen"), 11)


def test_it_is_switched_off_and_stops_when_asked(facts):
    assert facts["unregistered"]
    assert facts["cancelled"] == [None, True]
