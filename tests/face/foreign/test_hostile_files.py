"""Damaged and hostile files end in one line, never in another error, whatever is done with them."""

from __future__ import annotations

import copy
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.cli.main import main
from mien.core.errors import InputError, MienError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.foreign_report import face_report
from mien.face.foreign.gltf_document import read_gltf
from mien.face.foreign.recognition import foreign_face
from mien.face.foreign.rig_names import own_names
from mien.formats.driven_glb import drive_glb
from tests.zoo import ZOO

TRACK = ChannelTrack(("jawOpen", "headYaw"), [[0.0, 0.0], [0.5, 9.0]], FrameRate.of(30))


def repacked(source: Path, path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """A GLB with its JSON changed."""
    document = read_gltf(source)
    content = copy.deepcopy(document.json)
    change(content)
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary = document.binary or b""
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return path


def all_of_it(path: Path, out: Path) -> None:
    face = foreign_face(path)
    face_report(face).lines()
    drive_glb(TRACK, face, out)
    drawn_face(face).track(TRACK)


def _cycle(content: dict[str, Any]) -> None:
    content["nodes"][0]["children"] = [3]


def _target(content: dict[str, Any]) -> int:
    number: int = content["meshes"][0]["primitives"][0]["targets"][0]["POSITION"]
    return number


CHANGES: dict[str, Callable[[dict[str, Any]], object]] = {
    "cyclic nodes": _cycle,
    "own child": lambda c: c["nodes"][3].update(children=[3]),
    "two parents": lambda c: c["nodes"].append({"children": [0]}),
    "child that is not there": lambda c: c["nodes"][3].update(children=[99]),
    "negative child": lambda c: c["nodes"][3].update(children=[-1]),
    "no targets": lambda c: c["meshes"][0]["primitives"][0].pop("targets"),
    "unknown names": lambda c: c["meshes"][0]["extras"].update(targetNames=["x"] * 52),
    "names that are no list": lambda c: c["meshes"][0]["extras"].update(targetNames={"a": 1}),
    "no primitives": lambda c: c["meshes"][0].update(primitives=[]),
    "mesh is a number": lambda c: c.update(meshes=[7]),
    "nodes are an object": lambda c: c.update(nodes={}),
    "scene without nodes": lambda c: c["scenes"][0].update(nodes=[77]),
    "short matrix": lambda c: c["nodes"][3].update(matrix=[1, 2]),
    "rotation of words": lambda c: c["nodes"][3].update(rotation=["a", "b", "c", "d"]),
}  # fmt: skip
DRAWN: dict[str, Callable[[dict[str, Any]], object]] = {
    "negative offset": lambda c: c["bufferViews"][0].update(byteOffset=-4),
    "view past its buffer": lambda c: c["bufferViews"][0].update(byteLength=10**9),
    "huge count": lambda c: c["accessors"][0].update(count=10**12),
    "negative count": lambda c: c["accessors"][0].update(count=-1),
    "unknown type": lambda c: c["accessors"][0].update(type="VEC9"),
    "no buffer": lambda c: c["bufferViews"][0].update(buffer=5),
    "target of another length": lambda c: c["accessors"][_target(c)].update(count=2),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(CHANGES))
def test_a_document_that_does_not_hold_together(name: str, tmp_path: Path) -> None:
    path = repacked(ZOO["arkit"](tmp_path).path, tmp_path / "bad.glb", CHANGES[name])
    if name == "names that are no list":  # then there are no names, which a mesh may lack
        with pytest.raises(InputError, match="no morph target with a known name"):
            foreign_face(path).require_motion()
        return
    with pytest.raises(InputError, match=r"bad\.glb") as caught:
        all_of_it(path, tmp_path / "out.glb")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out.glb").exists()


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_numbers_that_do_not_hold_together(name: str, tmp_path: Path) -> None:
    path = repacked(ZOO["arkit"](tmp_path).path, tmp_path / "bad.glb", DRAWN[name])
    with pytest.raises(InputError, match=r"bad\.glb"):
        drawn_face(foreign_face(path))


@pytest.mark.parametrize("animal", ["face_cap", "vrm_0", "vrm_1", "ready_player_me", "shared", "text_with_files"])
def test_random_damage_is_refused_or_survived(animal: str, tmp_path: Path) -> None:
    source = ZOO[animal](tmp_path).path
    random = np.random.default_rng(11)
    wrong = [-1, 10**15, 1e300, None, "x", [], {}, True, 2**31, 0.5, [[]], "data:,x"]
    for _ in range(10):  # `make fuzz` tries thousands

        def damage(content: dict[str, Any]) -> None:
            place: Any = content
            while True:
                keys = list(place) if isinstance(place, dict) else range(len(place))
                key = keys[int(random.integers(len(keys)))]
                inner = place[key]
                if isinstance(inner, (dict, list)) and len(inner) and random.random() < 0.9:
                    place = inner
                    continue
                if random.random() < 0.2 and isinstance(place, dict):
                    del place[key]
                else:
                    place[key] = wrong[int(random.integers(len(wrong)))]
                return

        path = repacked(source, tmp_path / "damaged.glb", damage)
        try:
            all_of_it(path, tmp_path / "out.glb")
        except MienError:
            continue  # refused: any other error fails the test


def test_every_truncation_is_refused_or_survived(tmp_path: Path) -> None:
    content = ZOO["arkit"](tmp_path).path.read_bytes()
    for end in [*range(0, 60), *range(60, len(content), len(content) // 60)]:
        (tmp_path / "cut.glb").write_bytes(content[:end])
        with pytest.raises(InputError):
            all_of_it(tmp_path / "cut.glb", tmp_path / "out.glb")


@pytest.mark.parametrize("text", ["", "[", "[1]", "[" * 100_000, '{"nodes": NaN}', "\xff"])
def test_text_that_is_no_gltf(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.gltf").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=r"x\.gltf"):
        all_of_it(tmp_path / "x.gltf", tmp_path / "out.glb")


@pytest.mark.parametrize("uri", ["../secret.bin", "/etc/passwd", "http://a.b/c.bin", "gone.bin", "data:nonsense"])
def test_buffers_elsewhere(uri: str, tmp_path: Path) -> None:
    (tmp_path / "secret.bin").write_bytes(bytes(100_000))
    folder = tmp_path / "in"
    folder.mkdir()
    path = ZOO["text_alone"](folder).path
    content = json.loads(path.read_text())
    content["buffers"][0]["uri"] = uri
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"alone\.gltf"):
        drive_glb(TRACK, path, tmp_path / "out.glb")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[targets]\nx = 'jawOpem'", "jawOpen"),
        ("[targets]\nx = 3", "a channel, a table"),
        ("[targets]\nx = { jawOpen = 'a' }", "from -10 to 10"),
        ("[nodes]\nnose = 'x'", "unknown node"),
        ("[eyes]\nUp = 400", "degrees"),
        ("faces = 'up'", r"\+z"),
        ("[target]\nx = ''", "targets"),
        ("x", "TOML"),
    ],
)
def test_a_table_of_names_with_a_fault(text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "names.toml").write_text(text)
    with pytest.raises(InputError, match=told):
        own_names(tmp_path / "names.toml")


def test_the_command_line_says_it_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    animal = ZOO["units"](tmp_path)
    assert main(["face", "inspect", str(animal.path)]) == 0
    assert "FACS action units" in capsys.readouterr().out
    bad = repacked(animal.path, tmp_path / "bad.glb", CHANGES["cyclic nodes"])
    for arguments in (["face", "inspect", str(bad)], ["say", "Hi.", "--face", str(bad), "-o", str(tmp_path / "o.glb")]):
        assert main(arguments) == 2
        told = capsys.readouterr().err
        assert told.startswith("mien: error: ")
        assert told.count("\n") == 1
    assert main(["say", "Hi.", "--names", "x.toml", "-o", str(tmp_path / "o.glb")]) == 2
    assert "--names is for a face" in capsys.readouterr().err
