"""A GLB of another maker keeps its own bytes and gains the keys."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mien
from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import GltfDocument, read_gltf
from mien.face.foreign.recognition import foreign_face
from mien.face.posing import head_rotation
from mien.formats.driven_glb import drive_glb
from mien.formats.gltf_buffer import pack_glb
from mien.formats.turning_nodes import turns_of_nodes
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
    values[1, ARKIT.index("mouthSmileLeft")] = 0.25
    return ChannelTrack(names=ARKIT, values=values, rate=FrameRate(30))


def test_a_mesh_with_arkit_names_is_not_driven_by_visemes_too(tmp_path: Path) -> None:
    source = _glb(tmp_path / "a.glb", [*ARKIT[:30], "viseme_aa", "A"])
    (mesh,) = foreign_face(source).meshes
    assert [bool(target.drives) for target in mesh.targets] == [True] * 30 + [False] * 2


@pytest.mark.parametrize("version", [0, 1])
def test_names_from_the_expressions_of_vrm(version: int) -> None:
    targets = [{"POSITION": 0}] * 2
    one = {
        "preset": {
            name: {"morphTargetBinds": [{"node": 0, "index": place, "weight": 1.0}]}
            for place, name in ((1, "aa"), (0, "ou"))
        }
    }
    groups = [{"presetName": name, "binds": [{"mesh": 0, "index": place}]} for place, name in ((1, "a"), (0, "u"))]
    zero = {"blendShapeMaster": {"blendShapeGroups": groups}}
    document = {
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"targets": targets}]}],
        "extensions": {"VRMC_vrm": {"expressions": one}} if version else {"VRM": zero},
    }
    (mesh,) = foreign_face(GltfDocument(Path("x.vrm"), document)).meshes
    assert mesh.targets[0].name == ""
    assert mesh.targets[1].drives[0].match.recipe["jawOpen"] == pytest.approx(1.4)


def test_the_head_turns_about_the_worlds_axes_whatever_its_bone(tmp_path: Path) -> None:
    tilt, rest = Rotation.from_euler("x", -90, degrees=True), Rotation.from_euler("z", 30, degrees=True)
    nodes = [
        {"name": "Armature", "rotation": tilt.as_quat().tolist(), "children": [1]},
        {"name": "J_Bip_C_Head", "rotation": rest.as_quat().tolist()},
    ]
    track = ChannelTrack(("headYaw",), [[0.0], [20.0]], FrameRate.of(30))
    turned, notes = turns_of_nodes(track, foreign_face(GltfDocument(Path("x.glb"), {"nodes": nodes})))
    world = tilt * Rotation.from_quat(turned[1][1])
    wanted = Rotation.from_matrix(head_rotation(20.0, 0.0, 0.0)) * tilt * rest
    np.testing.assert_allclose(world.as_matrix(), wanted.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(np.abs(turned[1][0] @ rest.as_quat()), 1.0)
    assert "a left eye or a right eye" in notes[0].message


def test_our_own_glb_as_the_face_of_another(tmp_path: Path) -> None:
    animation = tiny_animation()
    mien.save(animation, tmp_path / "face.glb")
    mien.save(animation, tmp_path / "driven.glb", face=tmp_path / "face.glb")
    before, after = (read_gltf(tmp_path / name) for name in ("face.glb", "driven.glb"))
    assert after.json["meshes"] == before.json["meshes"]
    assert [one["name"] for one in after.json["animations"]] == ["mien"], "its own earlier one is replaced"
    assert {c["target"]["path"] for c in after.json["animations"][0]["channels"]} == {"weights", "rotation"}
    mien.save(animation, tmp_path / "again.glb", face=tmp_path / "driven.glb")
    assert (tmp_path / "again.glb").read_bytes() == (tmp_path / "driven.glb").read_bytes()


def test_comes_before_the_animations_of_others(tmp_path: Path) -> None:
    source = _glb(tmp_path / "a.glb", ["jawOpen"])
    document = read_gltf(source)
    document.json["animations"] = [{"name": "idle", "channels": [], "samplers": []}]
    Path(source).write_bytes(pack_glb(document.json, document.binary))
    notes = drive_glb(_track(), source, tmp_path / "b.glb")
    drive_glb(_track(), tmp_path / "b.glb", tmp_path / "c.glb")
    for name in ("b.glb", "c.glb"):
        assert [one["name"] for one in read_gltf(tmp_path / name).json["animations"]] == ["mien", "idle"]
    assert any("performance is first" in note.message for note in notes)


def test_bytes_kept_and_weights_written(tmp_path: Path) -> None:
    source, out = _glb(tmp_path / "a.glb", ["blendShape1.jaw_open", "unknown", "AU12_L"]), tmp_path / "b.glb"
    drive_glb(_track(), source, out)
    document, binary = read_gltf(out).json, read_gltf(out).binary
    assert binary[:36] == bytes(range(36))
    assert document["extensionsRequired"] == ["MIEN_unknown"]
    view = document["bufferViews"][-1]
    keys = np.frombuffer(binary, "<f4", 6, view["byteOffset"])
    np.testing.assert_allclose(keys, [0, 0, 0, 0.5, 0, 0.25], atol=1e-6)


def test_refusals(tmp_path: Path) -> None:
    source = _glb(tmp_path / "a.glb", ["unknown"])
    with pytest.raises(InputError, match="both read and written"):
        drive_glb(_track(), source, source)
    with pytest.raises(InputError, match="known name"):
        drive_glb(_track(), source, tmp_path / "b.glb")
    (tmp_path / "cut.glb").write_bytes(source.read_bytes()[:-8])
    with pytest.raises(InputError, match="bytes"):
        read_gltf(tmp_path / "cut.glb")
    (tmp_path / "png.glb").write_bytes(b"\x89PNG" + bytes(40))
    with pytest.raises(InputError, match="not a GLB"):
        read_gltf(tmp_path / "png.glb")
