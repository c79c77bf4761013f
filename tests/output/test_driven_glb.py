"""A GLB of another maker keeps its own bytes and gains the keys."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from mien.channels import ARKIT
from mien.errors import InputError
from mien.output.driven_glb import drive_glb, read_chunks, recipe_of_target
from mien.timeline import FrameRate
from mien.tracks import ChannelTrack


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
