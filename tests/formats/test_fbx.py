"""FBX out and in by way of Blender: names, shapes, motion and sizes come back."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

from mien.core.channels import ARKIT
from mien.core.errors import MissingPartError
from mien.core.timeline import FrameRate
from mien.face.foreign import blender_bridge
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.known_face import known_face
from mien.formats import check_output, save
from tests.faces import tiny_animation, tiny_face
from tests.programs import blender_python

pytestmark = pytest.mark.slow

SAMPLED = """
import bpy, json, os, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_enable(module="io_scene_fbx")
bpy.context.scene.render.fps = 25
bpy.ops.import_scene.fbx(filepath=sys.argv[1], anim_offset=0.0)
faces = [o for o in bpy.data.objects if o.type == "MESH" and o.data.shape_keys]
face = next(o for o in faces if "jawOpen" in o.data.shape_keys.key_blocks)
found = []
for frame in range(5):
    bpy.context.scene.frame_set(frame)
    found.append(face.data.shape_keys.key_blocks["jawOpen"].value)
print(json.dumps(found), flush=True)
os._exit(0)
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    monkeypatch.setenv("MIEN_BLENDER", blender_python())
    animation = tiny_animation(5, FrameRate.of(25))
    save(animation, tmp_path / "face.fbx", face=tiny_face())
    return animation, tmp_path / "face.fbx"


def test_motion_and_shapes_come_back(written):
    animation, path = written
    ran = subprocess.run([blender_python(), "-c", SAMPLED, str(path)], capture_output=True, text=True, check=False)
    lines = [line for line in ran.stdout.splitlines() if line.startswith("[")]
    assert lines, ran.stdout + ran.stderr
    np.testing.assert_allclose(json.loads(lines[-1]), animation.channels.channel("jawOpen"), atol=2e-3)

    face = known_face(path)
    names = {target.name for mesh in face.meshes for target in mesh.targets}
    moving = {name for part in tiny_face().parts for name in part.targets} & set(ARKIT)
    assert moving <= names
    assert face.moves


def test_the_face_has_its_size(written):
    _, path = written
    drawn = drawn_face(known_face(path)).face
    height = np.ptp(np.concatenate([part.vertices for part in drawn.parts])[:, 1])
    wanted = np.ptp(np.concatenate([part.vertices for part in tiny_face().parts])[:, 1])
    assert height == pytest.approx(wanted, rel=0.02)


def test_without_blender_it_is_refused_before_any_work(tmp_path, monkeypatch):
    monkeypatch.delenv("MIEN_BLENDER", raising=False)
    monkeypatch.setattr(blender_bridge, "find_spec", lambda name: None)
    monkeypatch.setattr(blender_bridge.shutil, "which", lambda name: None)
    with pytest.raises(MissingPartError, match=r"pip install 'mien\[fbx\]'"):
        check_output(tmp_path / "a.fbx")
