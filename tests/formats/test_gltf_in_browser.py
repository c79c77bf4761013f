"""End to end: the Khronos validator and three.js in a real browser take our GLB."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mien.animation.animation import Animation
from mien.core.channels import ALL, ARKIT, HEAD, MUSCLES, TONGUE
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.library import known_faces, load_face
from mien.face.posing import eye_rotation, head_rotation
from mien.formats.gltf import write_glb
from tests.faces import tiny_animation, tiny_face

FOLDER = Path(__file__).parent.parent / "viewer_check"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
MINUTES = 60


@pytest.fixture(scope="module")
def browser() -> str:
    """Path of a Chromium; without one, or without Node, the tests are skipped, except in CI, where they fail."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    absent = [name for name in ("node", "npm") if shutil.which(name) is None] + ([] if found else ["chromium"])
    if absent:
        reason = f"{', '.join(absent)} not installed: the browser test needs Node, npm and Chromium"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    if not (FOLDER / "node_modules" / "three").is_dir():
        made = subprocess.run(["npm", "ci"], cwd=FOLDER, capture_output=True, text=True, timeout=10 * MINUTES)
        assert made.returncode == 0, made.stderr
    return str(found)


def look(model: Path, browser: str, screenshot: Path, times: list[float]) -> dict:
    command = ["node", "check.js", str(model), browser, str(screenshot), *map(str, times)]
    ran = subprocess.run(command, cwd=FOLDER, capture_output=True, text=True, timeout=5 * MINUTES)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def check(animation, face, browser, folder: Path) -> dict:
    model, screenshot = folder / "model.glb", folder / "seen.png"
    write_glb(animation, face, model)
    frames = [0, 3, 10, len(animation.channels) - 1]
    times = animation.rate.times(len(animation.channels))
    seen = look(model, browser, screenshot, [float(times[frame]) for frame in frames])

    # Its skinned meshes stand under the root, so that whoever moves the root in a scene finds them there.
    assert {issue["code"] for issue in seen["issues"]["messages"]} <= {"NODE_SKINNED_MESH_NON_ROOT"}
    assert seen["complaints"] == []
    assert seen["facts"]["duration"] == pytest.approx(times[-1], abs=1e-6)
    assert seen["facts"]["extras"]["mien"]["audioStartSeconds"] == 0.0
    for mesh in seen["facts"]["meshes"]:
        names = ARKIT + (TONGUE if "tongue" in mesh["name"] else MUSCLES)
        assert mesh["dictionary"] == {name: number for number, name in enumerate(names)}
    for frame, moment in zip(frames, seen["moments"], strict=True):
        for mesh, influences in zip(seen["facts"]["meshes"], moment["influences"], strict=True):
            expected = animation.channels.select(list(mesh["dictionary"])).values[frame]
            assert np.allclose(influences, expected, atol=1e-4), (mesh["name"], frame)
        assert_turned(moment["turns"], animation, face, frame)
    picture = np.asarray(Image.open(screenshot).convert("RGB")).astype(float)
    covered = (np.abs(picture - picture[0, 0]).max(axis=2) > 12).mean()
    assert 0.1 < covered < 0.95, f"the face covers {covered:.0%} of the picture"
    return seen


def assert_turned(turns, animation, face, frame) -> None:
    expected = {"head": head_rotation(*animation.channels.select(HEAD).values[frame])}
    for eye in face.eyes:
        looks = animation.channels.select([f"eyeLook{way}{eye.side}" for way in ("Up", "Down", "In", "Out")])
        expected[f"eye_{eye.side.lower()}"] = eye_rotation(eye, *looks.values[frame])
    for name, matrix in expected.items():
        x, y, z, w = turns[name]
        forward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
        assert np.allclose(forward, matrix[:, 2], atol=1e-4), (name, frame)


def smiling() -> Animation:
    """Twenty frames that end in an open smile, head and eyes turned to the speaker's left."""
    pose = {"jawOpen": 0.35, "mouthSmileLeft": 0.7, "mouthSmileRight": 0.7, "eyeLookOutLeft": 0.6, "browInnerUp": 0.5}
    pose |= {"eyeLookInRight": 0.6, "headYaw": 15.0, "headPitch": 5.0, "headRoll": -6.0}
    values = np.zeros((20, len(ALL)))
    for name, value in pose.items():
        values[:, ALL.index(name)] = np.linspace(0, value, 20)
    return replace(tiny_animation(20), channels=ChannelTrack(ALL, values, FrameRate.of(30)))


def test_tiny_face_plays(browser, tmp_path):
    check(tiny_animation(), tiny_face(), browser, tmp_path)


def test_default_face_plays(browser, tmp_path):
    if "default" not in known_faces():
        pytest.fail("the default face is missing from the assets")
    check(smiling(), load_face("default"), browser, tmp_path)
