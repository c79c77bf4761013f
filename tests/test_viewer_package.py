"""The npm package `viewer`: its shared files are those of this mien, its own tests pass, it holds what it should."""

from __future__ import annotations

import json
import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from tools.viewer_files import FRAMES, tables, write

from mien.formats.gltf import write_glb
from mien.formats.native import write_native
from mien.serve.live.frames import decode_frame
from tests.faces import tiny_animation, tiny_face
from tests.node import ROOT, chromium, installed, run

GOLDEN = ROOT / "viewer" / "test" / "golden"


def constants(source: str) -> dict:
    """The tables of a ``tables.ts`` by their names."""
    return {
        name: json.loads(value)
        for name, value in re.findall(r"^export const (\w+): .*? = (.*?);$", source, re.M | re.S)
    }


def test_the_players_tables_say_nothing_else_than_miens():
    """mien may know more names by now; `python tools/viewer_files.py && make page` brings them to the player."""
    theirs, ours = constants((ROOT / "viewer" / "src" / "tables.ts").read_text("utf-8")), constants(tables())
    assert theirs.keys() == ours.keys()
    for name in ("WEIGHTS", "HEAD", "EYE_DEGREES"):
        assert theirs[name] == ours[name]
    for part, names in theirs["NODES"].items():
        assert set(names) <= set(ours["NODES"][part])
    known = {table["title"]: table["targets"] for table in ours["CONVENTIONS"]}
    for table in theirs["CONVENTIONS"]:
        for target, recipe in table["targets"].items():
            assert known[table["title"]].get(target) == recipe, (table["title"], target)


def test_golden_bytes_are_those_of_this_version(tmp_path):
    (tmp_path / "src").mkdir()
    write(tmp_path)
    for name in ("greeting.txt", "end.txt", "frames.bin", "values.json", "foreign.glb", "driven.glb"):
        assert (GOLDEN / name).read_bytes() == (tmp_path / "test" / "golden" / name).read_bytes(), name


def test_golden_frames_are_read_by_mien_too():
    content, size = (
        (GOLDEN / "frames.bin").read_bytes(),
        16 + 4 * len(json.loads((GOLDEN / "values.json").read_text())["channels"]),
    )
    numbers = [decode_frame(content[at : at + size]).number for at in range(0, len(content), size)]
    assert numbers == [0, 1, 2, 4, FRAMES - 1]


def test_unit_tests_and_types():
    folder = installed("viewer")
    run("npm", "run", "types", folder=folder)
    run("npm", "test", folder=folder)


def test_what_is_packed():
    folder = installed("viewer")
    (packed,) = json.loads(run("npm", "pack", "--dry-run", "--json", "--silent", folder=folder).split("\n\n")[-1])
    names = {file["path"] for file in packed["files"]}
    assert {"package.json", "README.md", "LICENSE", "dist/index.js", "dist/index.d.ts"} <= names
    assert all(name.startswith("dist/") for name in names - {"package.json", "README.md", "LICENSE"}), names
    assert packed["size"] < 40_000
    assert "dependencies" not in json.loads((folder / "package.json").read_text())


def whole_avatar(path: Path, head: Path) -> Path:
    """A head on a body: 1.7 m tall, the face in a twelfth of its height."""
    content = head.read_bytes()
    size = int.from_bytes(content[12:16], "little")
    document, rest = json.loads(content[20 : 20 + size]), content[20 + size :]
    eye = next(number for number, mesh in enumerate(document["meshes"]) if "targets" not in mesh["primitives"][0])
    nodes, scene = document["nodes"], document["scenes"][0]
    body = {"name": "Body", "mesh": eye, "translation": [0, -0.9, 0], "scale": [14, 58, 8]}
    nodes += [body, {"name": "Armature", "translation": [0, 1.6, 0], "children": [*scene["nodes"], len(nodes)]}]
    scene["nodes"] = [len(nodes) - 1]
    told = json.dumps(document).encode()
    told += b" " * (-len(told) % 4)
    whole = b"glTF" + struct.pack("<III4s", 2, 20 + len(told) + len(rest), len(told), b"JSON") + told + rest
    path.write_bytes(whole)
    return path


def other_faces(folder: Path) -> list[Path]:
    """A whole avatar, made; and three.js's facecap.glb, where `MIEN_FACECAP` says it lies (meshopt and KTX2)."""
    given = os.environ.get("MIEN_FACECAP")
    own = [] if given is None else [Path(shutil.copy(given, folder / "facecap.glb"))]
    return [whole_avatar(folder / "avatar.glb", folder / "face.glb"), *own]


def test_example_of_the_readme_plays_a_stream_and_a_file(tmp_path):
    browser, viewer, package = chromium(), installed("viewer"), installed("studio")
    run("npm", "run", "build", folder=viewer)
    animation = tiny_animation(100)
    write_native(animation, tmp_path / "line.json")
    write_glb(tiny_animation(1), tiny_face(), tmp_path / "face.glb")
    command = [sys.executable, "-m", "mien", "serve", str(tmp_path / "line.json"), "--loop", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as server:
        try:
            assert server.stdout is not None
            address = next(found.group() for told in server.stdout if (found := re.search(r"ws://[\w.:]+", told)))
            files = (str(tmp_path / name) for name in ("face.glb", "line.json"))
            check = ROOT / "tests" / "studio_check" / "viewer.mjs"
            others = other_faces(tmp_path)
            given = (*files, *map(str, others))
            printed = run("node", str(check), str(package), str(viewer), address, browser, *given, folder=ROOT)
        finally:
            server.terminate()
    seen = json.loads(printed.splitlines()[-1])
    assert seen["lines"] < 15
    for other in others:
        picture = np.asarray(Image.open(f"{other}.png").convert("L"))
        assert 0.15 < (picture > 20).mean() < 0.8, f"{other.name} is not framed"
    assert seen["complaints"] == []
    for name in ("stream", "file", *(f"page/{number}" for number in range(len(others)))):
        assert len({round(value, 4) for value in seen[name]}) > 4, f"{name}: the jaw stands still"
