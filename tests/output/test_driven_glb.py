"""A GLB of another maker keeps its own bytes and gains the keys."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mien
from mien.channels import ARKIT
from mien.errors import InputError
from mien.face.posing import head_rotation
from mien.output.driven_glb import drive_glb, driven_meshes, read_chunks, recipe_of_target
from mien.output.turning_nodes import turns_of_nodes
from mien.timeline import FrameRate
from mien.tracks import ChannelTrack
from tests.faces import tiny_animation


def _glb(path: Path, names: list[str]) -> Path:
    primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * len(names)}
    document = {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["MIEN_unknown"],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive], "extras": {"targetNames": names}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", 36, 0x004E4942) + bytes(range(36))
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return path


def _track() -> ChannelTrack:
    values = np.zeros((2, len(ARKIT)))
    values[1, ARKIT.index("jawOpen")] = 0.5
    return ChannelTrack(names=ARKIT, values=values, rate=FrameRate(30))


def test_a_mesh_with_arkit_names_is_not_driven_by_visemes_too(tmp_path: Path) -> None:
    source = _glb(tmp_path / "a.glb", [*ARKIT[:20], "viseme_aa", "A"])
    (mesh,) = driven_meshes(source, read_chunks(source)[0])
    assert [bool(recipe) for recipe in mesh.recipes] == [True] * 20 + [False] * 2


@pytest.mark.parametrize("version", [0, 1])
def test_names_from_the_expressions_of_vrm(version: int) -> None:
    targets = [{"POSITION": 0}] * 2
    one = {"preset": {"aa": {"morphTargetBinds": [{"node": 0, "index": 1, "weight": 1.0}]}}}
    zero = {"blendShapeMaster": {"blendShapeGroups": [{"presetName": "a", "binds": [{"mesh": 0, "index": 1}]}]}}
    document = {
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"targets": targets}]}],
        "extensions": {"VRMC_vrm": {"expressions": one}} if version else {"VRM": zero},
    }
    (mesh,) = driven_meshes("x.glb", document)
    assert mesh.targets[0] == ""
    assert mesh.recipes[1]["jawOpen"] == pytest.approx(1.4)


def test_the_head_turns_about_the_worlds_axes_whatever_its_bone(tmp_path: Path) -> None:
    tilt, rest = Rotation.from_euler("x", -90, degrees=True), Rotation.from_euler("z", 30, degrees=True)
    nodes = [
        {"name": "Armature", "rotation": tilt.as_quat().tolist(), "children": [1]},
        {"name": "J_Bip_C_Head", "rotation": rest.as_quat().tolist()},
    ]
    track = ChannelTrack(("headYaw",), [[0.0], [20.0]], FrameRate.of(30))
    turned, notes = turns_of_nodes(track, {"nodes": nodes})
    world = tilt * Rotation.from_quat(turned[1][1])
    wanted = Rotation.from_matrix(head_rotation(20.0, 0.0, 0.0)) * tilt * rest
    np.testing.assert_allclose(world.as_matrix(), wanted.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(np.abs(turned[1][0] @ rest.as_quat()), 1.0)
    assert "a left eye or a right eye" in notes[0].message


def test_our_own_glb_as_the_face_of_another(tmp_path: Path) -> None:
    animation = tiny_animation()
    mien.save(animation, tmp_path / "face.glb")
    mien.save(animation, tmp_path / "driven.glb", face=tmp_path / "face.glb")
    before, after = (read_chunks(tmp_path / name) for name in ("face.glb", "driven.glb"))
    assert after[1][0][1].startswith(before[1][0][1].rstrip(b"\0"))
    assert after[0]["meshes"] == before[0]["meshes"]
    assert len(after[0]["animations"]) == len(before[0].get("animations", [])) + 1
    assert {c["target"]["path"] for c in after[0]["animations"][-1]["channels"]} == {"weights", "rotation"}
    with pytest.raises(InputError, match="only mien's own faces are drawn"):
        mien.save(animation, tmp_path / "a.mp4", face=str(tmp_path / "face.glb"))


@pytest.mark.parametrize("document", [{"meshes": [{}]}, {"meshes": [7]}, {"meshes": [{"primitives": []}]}])
def test_json_that_does_not_hold_together_is_one_line(document: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"x\.glb: its meshes"):
        driven_meshes("x.glb", document)


def test_bytes_kept_and_weights_written(tmp_path: Path) -> None:
    source, out = _glb(tmp_path / "a.glb", ["blendShape1.jaw_open", "unknown", "viseme_aa"]), tmp_path / "b.glb"
    drive_glb(_track(), source, out)
    document, chunks = read_chunks(out)
    assert chunks[0][1][:36] == bytes(range(36))
    assert document["extensionsRequired"] == ["MIEN_unknown"]
    view = document["bufferViews"][-1]
    keys = np.frombuffer(chunks[0][1], "<f4", 6, view["byteOffset"])
    np.testing.assert_allclose(keys, [0, 0, 0, 0.5, 0, 0.7], atol=1e-6)


def test_refusals(tmp_path: Path) -> None:
    source = _glb(tmp_path / "a.glb", ["unknown"])
    with pytest.raises(InputError, match="both read and written"):
        drive_glb(_track(), source, source)
    with pytest.raises(InputError, match="known name"):
        drive_glb(_track(), source, tmp_path / "b.glb")
    (tmp_path / "cut.glb").write_bytes(source.read_bytes()[:-8])
    with pytest.raises(InputError, match="bytes"):
        read_chunks(tmp_path / "cut.glb")
    (tmp_path / "png.glb").write_bytes(b"\x89PNG" + bytes(40))
    with pytest.raises(InputError, match="not a GLB"):
        read_chunks(tmp_path / "png.glb")
    assert recipe_of_target("Fcl_MTH_U") == {"mouthPucker": 1.0}
