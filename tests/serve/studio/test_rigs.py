"""The deformation editor's part of the interface."""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mien.face.library import load_face
from mien.face.tree_config import parse_tree
from mien.face.tree_of_face import tree_of_face
from mien.formats.gltf import write_glb
from tests.faces import tiny_animation, tiny_face
from tests.serve.studio.client import Client, studio

SMALL = """mien-tree 1
parameter head
  rotation axis 0 1 0 pivot 0 -90 -40
  drive headYaw 1
  all 1
parameter brow
  translation 0 4 0
  parent head
  drive browInnerUp 1
  sphere 25 -64 60 radius 15 soft 30
"""


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with studio() as running:
        yield running


@pytest.fixture(scope="module")
def rig(client: Client) -> str:
    answer = client.ask("POST", "/api/rigs", SMALL.encode())
    assert answer.status == 200, answer.body
    return str(answer.json["rig"])


def test_the_default_rig_is_the_tree_of_the_default_face(client: Client) -> None:
    told = client.ask("GET", "/api/rigs/default").json
    assert told["config"]["format"] == "mien-tree"
    tree = tree_of_face(load_face("default"))
    assert [parameter["name"] for parameter in told["config"]["parameters"]] == [p.name for p in tree.parameters]
    assert told["face"] == "default"


def shapes(client: Client, rig: str) -> dict[str, np.ndarray]:
    parts = client.ask("GET", f"/api/rigs/{rig}/mesh").json["parts"]
    return {part["name"]: np.frombuffer(b64decode(part["vertices"]), "<f4").reshape(-1, 3) for part in parts}


def test_any_face_has_a_tree(client: Client, tmp_path: Path) -> None:
    write_glb(tiny_animation(1), tiny_face(), tmp_path / "own.glb")
    own = client.ask("POST", "/api/faces", (tmp_path / "own.glb").read_bytes()).json["face"]
    told = client.ask("GET", f"/api/rigs/{own}").json
    names = [parameter["name"] for parameter in told["config"]["parameters"]]
    assert told["face"] == own
    assert {"trunk", "headYaw", "0_eye_left_left_yaw"} <= set(names)
    rest = np.concatenate(list(shapes(client, own).values()))
    assert 50 < np.ptp(rest[:, 1]) < 1000, "mm"
    drive = next(p for p in told["config"]["parameters"] if "jawOpen" in p["drives"])
    asked = {"values": {drive["name"]: 10 if drive["kind"] == "rotation" else 1}}
    posed = np.frombuffer(client.ask("POST", f"/api/rigs/{own}/pose", asked).body, "<f4").reshape(-1, 3)
    assert np.linalg.norm(posed - rest, axis=1).max() > 1
    saved = client.ask("PUT", f"/api/rigs/{own}", {"config": told["config"]}).json["rig"]
    assert client.ask("GET", f"/api/rigs/{saved}").json["face"] == own
    assert client.ask("GET", "/api/rigs/nowhere").status == 404


def test_a_file_opened_is_data_and_a_file_again(client: Client, rig: str) -> None:
    told = client.ask("GET", f"/api/rigs/{rig}").json
    assert [parameter["name"] for parameter in told["config"]["parameters"]] == ["head", "brow"]
    assert client.ask("GET", f"/api/rigs/{rig}.txt").body.decode() == SMALL


def test_a_changed_one_is_kept_and_a_faulty_one_is_not(client: Client, rig: str) -> None:
    config = client.ask("GET", f"/api/rigs/{rig}").json["config"]
    config["parameters"][1]["translation"] = [0, 6, 0]
    assert client.ask("POST", "/api/rigs/check", {"config": config}).json == {"ok": True, "faults": []}
    saved = client.ask("PUT", f"/api/rigs/{rig}", {"config": config}).json
    assert saved["rig"] == rig
    assert "translation 0 6 0" in client.ask("GET", saved["file"]).body.decode()
    config["parameters"][1]["parent"] = "neck"
    faults = client.ask("POST", "/api/rigs/check", {"config": config}).json["faults"]
    assert faults[0]["parameter"] == "brow"
    assert "neck" in faults[0]["text"]
    answer = client.ask("PUT", f"/api/rigs/{rig}", {"config": config})
    assert answer.status == 400
    assert "neck" in answer.json["error"]


def test_a_copy_of_the_default_gets_an_id_of_its_own(client: Client, rig: str) -> None:
    config = client.ask("GET", f"/api/rigs/{rig}").json["config"]
    saved = client.ask("PUT", "/api/rigs/default", {"config": config}).json
    assert saved["rig"] not in ("default", rig)


def test_influences_and_poses_are_those_of_the_tree(client: Client) -> None:
    rig = client.ask("POST", "/api/rigs", SMALL.encode()).json["rig"]
    face = load_face("default")
    tree = parse_tree(SMALL).on({part.name: part.vertices for part in face.parts})
    told = client.ask("GET", f"/api/rigs/{rig}/influence").json
    assert told["brow"]["skin"]["vertices"] == tree.parameters[1].influences["skin"].vertices.tolist()
    body = client.ask("POST", f"/api/rigs/{rig}/pose", {"values": {"head": 20, "brow": 0.5}}).body
    posed = np.frombuffer(body, "<f4").reshape(-1, 3)
    expected = np.concatenate([tree.deform(part.name, part.vertices, [20, 0.5]) for part in face.parts])
    assert np.allclose(posed, expected, atol=1e-3)
    assert client.ask("POST", f"/api/rigs/{rig}/pose", {"values": {"chin": 1}}).json["field"] == "values"


def test_other_files_are_refused_with_their_lines(client: Client) -> None:
    answer = client.ask("POST", "/api/rigs", b"mien-tree 1\nparameter head\n  rotation axis 0 1\n")
    assert answer.status == 400
    assert "rig.tree:3" in answer.json["error"]
    assert client.ask("POST", "/api/rigs", b"\xff\x00").status == 400


def test_a_take_is_exported_on_a_rig(client: Client) -> None:
    rig = client.ask("POST", "/api/rigs", SMALL.encode()).json["rig"]
    take = client.take(text="Hi.", performer="hand-made", voice="espeak", fps=10)
    told = client.finished(client.ask("POST", f"/api/takes/{take}/export", {"formats": [".glb"], "rig": rig}))
    assert client.ask("GET", told["file"]).body[:4] == b"glTF"
    assert client.ask("POST", f"/api/takes/{take}/export", {"formats": [".glb"], "rig": "x"}).status == 404


def test_the_mesh_is_the_face_at_rest(client: Client) -> None:
    from base64 import b64decode

    told = client.ask("GET", "/api/rigs/default/mesh").json
    for one, part in zip(told["parts"], load_face("default").parts, strict=True):
        assert np.array_equal(np.frombuffer(b64decode(one["vertices"]), "<f4").reshape(-1, 3), part.vertices)
        assert np.array_equal(np.frombuffer(b64decode(one["triangles"]), "<u4").reshape(-1, 3), part.triangles)
