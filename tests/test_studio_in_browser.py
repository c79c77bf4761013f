"""The whole job in the studio as a person does it: Chromium, a real server, real voices."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mien.face.tree_config import read_tree
from mien.face.tree_data import config_data
from tests.node import ROOT, chromium, installed, run

TREE = """mien-tree 1
parameter jaw
  rotation axis 1 0 0 pivot 0 -20 -60
  group skeletal
  sphere 0 -70 0 radius 20 soft 40
parameter trunk
  fixed
  group skeletal
  side 0 -1 0 of 0 -80 0 soft 20
parameter smile
  translation 3 4 -1
  parent jaw
  sphere 25 -64 16 radius 6 soft 18
"""
CHECK = ROOT / "tests" / "studio_check" / "check.mjs"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A studio of its own on a free port."""
    folder = str(tmp_path_factory.mktemp("kept"))
    command = [sys.executable, "-m", "mien", "studio", "--no-browser", "--port", "0", "--folder", folder]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as studio:
        assert studio.stdout is not None
        told = studio.stdout.readline()
        found = re.search(r"http://\S+", told)
        assert found, told
        yield found.group()
        studio.terminate()
        studio.wait(timeout=30)


@pytest.fixture(scope="module")
def seen(address: str, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the browser saw; everything is done once."""
    import mien

    browser, package, folder = chromium(), installed("studio"), tmp_path_factory.mktemp("studio")
    mien.save(mien.say("I never said that."), folder / "line.wav")
    (folder / "small.tree").write_text(TREE, "utf-8")
    given = (str(folder), str(folder / "line.wav"), str(folder / "small.tree"))
    printed = run("node", str(CHECK), str(package), address, browser, *given, folder=ROOT)
    return json.loads(printed.splitlines()[-1]) | {"folder": folder}


def test_nothing_complains_and_nothing_leaves_the_machine(seen):
    assert seen["complaints"] == [
        "Failed to load resource: the server responded with a status of 400 (Bad Request)"  # the empty text, on purpose
    ]
    assert seen["elsewhere"] == []
    assert seen["requests"] > 10


def test_a_line_is_performed_played_and_scrubbed(seen):
    assert seen["take"]["frames"] > 60
    assert seen["playing"] == "Pause"
    assert seen["speed"] == "0.25"
    seconds = float(seen["take"]["text"].split("/")[1].split()[0])
    assert seen["scrubbed"] == pytest.approx(0.4 * seconds, abs=0.06 * seconds)
    assert seen["times"]["pictures"] > 0


def test_a_dragged_intensity_moves_the_face_at_once_and_for_good(seen):
    intensity = seen["intensity"]
    assert intensity["during"] < 0.97 * intensity["before"], "the face did not follow the mouse"
    assert intensity["after"] < 0.97 * intensity["before"]
    assert intensity["during"] == pytest.approx(intensity["after"], rel=0.15)


def test_a_dragged_border_stays(seen):
    assert 0.005 < seen["border"]["after"] - seen["border"]["before"] < 0.2


def test_the_page_shows_what_the_server_performs(seen):
    assert 0 <= seen["apart"] < 1e-5


def test_a_key_has_its_own_tangent(seen):
    assert seen["tangents"] == ["step", "flat"]


def test_effort_and_eyes_show_before_they_are_performed(seen):
    before, overdone, aside, back = seen["hovered"]
    assert overdone > 1.1 * before
    assert aside > 0.3
    assert back == before


def test_the_voice_follows_a_slider_under_the_finger(seen):
    assert seen["slid"] == {"promise": "You hear it as you slide.", "other": seen["slid"]["other"], "back": 0}
    assert abs(seen["slid"]["other"]) > 51, "the line is as long without emotion in its voice"


def test_what_is_shown_is_sent_live_and_a_textgrid_is_taken(seen):
    assert (seen["live"]["sending"], seen["live"]["to"], seen["live"]["kind"]) == (True, "127.0.0.1:9", "livelink")
    assert seen["grid"]


def test_edits_are_listed_undone_and_kept_in_another_emotion(seen):
    assert [line.split(":")[0].split(" ")[0] for line in seen["edits"]] == ["happy", "end", "jawOpen"]
    assert len(seen["undone"]) == 1  # a tangent, two keys and the border are taken back
    assert len(seen["redone"]) == 2
    assert [line.split(":")[0] for line in seen["kept"]] == [seen["redone"][1].split(":")[0]]  # happy's curve gives way
    assert seen["atOnce"] > 1, "the face waits for the server"


def test_the_exported_glb_performs_and_is_a_face_itself(seen):
    assert seen["exported"].endswith(".glb")
    content = (seen["folder"] / "exported.glb").read_bytes()
    document = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])
    assert document["animations"]
    assert document["asset"]["extras"]["mien"]["text"] == "I never said that."
    assert "targets move" in seen["face"]


def test_a_fault_stands_at_its_field_and_a_recording_is_taken(seen):
    assert "empty" in seen["fault"]
    assert seen["recorded"] == "the recording of this take"
    assert seen["back"], "a reload does not bring the take back"


def test_the_keyboard_alone_does_it(seen):
    keys = seen["keys"]
    assert all(0 < keys[name] < 40 for name in ("text", "play", "border")), keys
    assert keys["outline"] == "solid"
    assert keys["next"] == "border-1"
    assert keys["still"] == "border-1", "the focus is lost when the line is performed anew"
    assert (keys["help"], keys["closed"]) == (1, 0)


def test_a_tree_is_moved_painted_and_saved(seen):
    assert 0 <= seen["rig"]["apart"] < 1e-3, "mm"
    smile = config_data(read_tree(seen["folder"] / "saved.tree"))["parameters"][2]
    assert smile["translation"] == [7.0, 4.0, -1.0]
    assert {region["shape"] for region in smile["regions"]} == {"weights"}
    assert 0 <= seen["rig"]["saved"] < 1e-3, "mm"


@pytest.mark.parametrize("name", ["desk.png", "phone-line.png", "phone-timeline.png"])
def test_the_face_is_in_the_picture(seen, name):
    picture = np.asarray(Image.open(Path(seen["folder"]) / name).convert("RGB")).astype(int)
    wide = 475 if name == "desk.png" else 195  # of a picture at half its size
    stage = picture[25:170, :wide]
    skin = (stage[..., 0] > 110) & (stage[..., 0] > stage[..., 1] + 15) & (stage[..., 1] > stage[..., 2] + 5)
    assert 0.06 < skin.mean() < 0.7, f"skin covers {skin.mean():.0%}"


def test_all_controls_fit_a_phones_screen(seen):
    assert seen["phone"] == {"wide": 390, "outside": []}
