"""Bones where shapes are missing: a jaw that opens the mouth, arms that come down."""

from __future__ import annotations

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core.channels import WEIGHTS
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.foreign_report import face_report
from mien.face.foreign.gltf_document import GltfDocument, read_gltf
from mien.face.foreign.known_face import known_face
from mien.face.foreign.recognition import foreign_face
from mien.face.foreign.rig_nodes import world_matrices
from mien.face.posing import head_rotation
from mien.formats.driven_glb import drive_glb
from mien.formats.turning_nodes import turns_of_nodes


@pytest.fixture
def avatar(tmp_path):
    """A body without shapes: head, jaw (its first vertex still, its second on the jaw), arms out to the sides."""
    nodes = [
        {"name": "Hips", "children": [1, 4, 6], "translation": [0, 1, 0]},
        {"name": "Head", "children": [2], "translation": [0, 0.6, 0]},
        {"name": "Jaw", "translation": [0, 0.05, 0.01]},
        {"name": "Face", "mesh": 0, "skin": 0},
        {"name": "LeftArm", "children": [5], "translation": [0.2, 0.4, 0]},
        {"name": "LeftForeArm", "translation": [0.3, 0, 0]},
        {"name": "RightArm", "children": [7], "translation": [-0.2, 0.4, 0]},
        {"name": "RightForeArm", "translation": [-0.3, 0, 0]},
    ]
    points = np.array([[0, 1.75, 0.1], [0, 1.6, 0.1], [0.03, 1.6, 0.1]], "<f4")
    inverse = [np.eye(4), np.eye(4)]
    inverse[0][:3, 3], inverse[1][:3, 3] = (0, -1.6, 0), (0, -1.65, -0.01)
    joints = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]], "<u2")
    weights = np.tile(np.array([[1, 0, 0, 0]], "<f4"), (3, 1))
    blocks = [points.tobytes(), joints.tobytes(), weights.tobytes(), np.array([m.T for m in inverse], "<f4").tobytes()]
    starts = np.cumsum([0, *map(len, blocks)])
    accessors = [
        {"bufferView": i, "componentType": kind, "count": count, "type": name}
        for i, (kind, count, name) in enumerate(
            ((5126, 3, "VEC3"), (5123, 3, "VEC4"), (5126, 3, "VEC4"), (5126, 2, "MAT4"))
        )
    ]
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 3]}], "scene": 0, "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}], "accessors": accessors,
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(a), "byteLength": len(b)} for a, b in zip(starts, blocks, strict=False)
        ],
        "buffers": [{"byteLength": int(starts[-1])}],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(blocks)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    (tmp_path / "a.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return tmp_path / "a.glb"


def _jaw(value: float) -> ChannelTrack:
    values = np.zeros((2, len(WEIGHTS) + 3))
    values[1, WEIGHTS.index("jawOpen")] = value
    return ChannelTrack((*WEIGHTS, "headYaw", "headPitch", "headRoll"), values, FrameRate.of(30))


def test_the_jaw_turns_down_in_the_file(avatar, tmp_path):
    drive_glb(_jaw(1.0), known_face(avatar), tmp_path / "b.glb")
    file = read_gltf(tmp_path / "b.glb")
    channels = file.json["animations"][0]["channels"]
    turned = {file.list_of("nodes")[c["target"]["node"]]["name"] for c in channels}
    assert turned == {"Head", "Jaw", "LeftArm", "RightArm"}
    from mien.face.foreign.accessors import AccessorReader

    by_name = {file.list_of("nodes")[c["target"]["node"]]["name"]: c["sampler"] for c in channels}
    samplers = file.json["animations"][0]["samplers"]
    x, _, _, w = AccessorReader(file).read(samplers[by_name["Jaw"]]["output"], 4)[1]
    assert 2 * np.degrees(np.arctan2(x, w)) == pytest.approx(20.0, abs=0.1)  # about +x: what is in front goes down


def test_the_jaw_is_drawn_and_counted(avatar):
    foreign = known_face(avatar)
    drawn = drawn_face(foreign)
    target = next(t for part in drawn.face.parts for name, t in part.targets.items() if name == "jaw/jawOpen")
    assert target.vertices.tolist() == [1, 2]
    assert (target.offsets[:, 1] < -10).all()
    assert drawn.track(_jaw(0.5)).select(["jaw/jawOpen"]).values[1, 0] == 0.5
    report = face_report(foreign)
    assert report.nodes["jaw"] == "Jaw"
    assert report.mouth >= 0.4


def test_arms_come_down_unless_kept(avatar):
    foreign = known_face(avatar)
    assert face_report(foreign).nodes["armLeft"] == "LeftArm"
    assert "armLeft" not in face_report(replace(foreign, arms=False)).nodes
    from mien.face.foreign.rig_nodes import lowered_arms

    world = world_matrices(foreign.document, lowered_arms(foreign.document, foreign.turning.nodes))
    assert world[5][1, 3] < world[4][1, 3] - 0.25
    assert world[7][1, 3] < world[6][1, 3] - 0.25


def test_the_neck_takes_a_share_of_the_heads_turn(avatar):
    document = json.loads(avatar.read_bytes()[20 : 20 + struct.unpack_from("<I", avatar.read_bytes(), 12)[0]])
    document["nodes"][0]["children"] = [8, 4, 6]
    document["nodes"].append({"name": "mixamorig:Neck", "children": [1], "rotation": [0, 0.7071068, 0, 0.7071068]})
    document["nodes"][1]["rotation"] = [0, -0.7071068, 0, 0.7071068]
    path = avatar.with_suffix(".gltf")
    path.write_text(json.dumps(document | {"buffers": []}))
    face = foreign_face(GltfDocument(path, document))
    track = ChannelTrack(("headYaw", "headPitch"), [[20.0, 10.0]], FrameRate.of(30))
    turned, _ = turns_of_nodes(track, face)
    neck, head = (Rotation.from_quat(turned[number][0]) for number in (8, 1))
    whole = (neck * head).as_matrix()
    np.testing.assert_allclose(whole, head_rotation(20.0, 10.0, 0.0), atol=1e-6)
    assert 0.3 * 22 < np.degrees((neck * Rotation.from_euler("y", -90, degrees=True)).magnitude()) < 0.4 * 23
