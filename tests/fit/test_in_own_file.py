"""Shapes of a fitted head on the vertices of the file it came from."""

from __future__ import annotations

import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.gltf_document import read_gltf
from mien.face.model import Target
from mien.fit.in_own_file import shapes_of_file
from mien.fit.mesh_files import read_mesh
from mien.formats.shaped_glb import PrimitiveShapes, write_shapes
from tests.fit.heads import mesh_of


@pytest.fixture
def square(tmp_path):
    """Two triangles under a node that doubles and turns them, with a target and a clip of their own."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    moved = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0]], "<f4")
    corners = np.array([0, 1, 2, 0, 2, 3], "<u2")
    keys, weights = np.array([0, 1], "<f4"), np.array([0, 1], "<f4")
    blocks = [points, moved, corners, keys, weights]
    starts = np.cumsum([0, *(-(-b.nbytes // 4) * 4 for b in blocks)])
    kinds = [(5126, 4, "VEC3"), (5126, 4, "VEC3"), (5123, 6, "SCALAR"), (5126, 2, "SCALAR"), (5126, 2, "SCALAR")]
    clip = {"name": "own", "samplers": [{"input": 3, "output": 4}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]}  # fmt: skip
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "animations": [clip],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 0.70710678, 0.70710678]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "targets": [{"POSITION": 1}]}],
                    "extras": {"targetNames": ["wink"]}, "weights": [0]}],
        "accessors": [{"bufferView": i, "componentType": k, "count": n, "type": t}
                      for i, (k, n, t) in enumerate(kinds)],
        "bufferViews": [{"buffer": 0, "byteOffset": int(a), "byteLength": b.nbytes}
                        for a, b in zip(starts, blocks, strict=False)],
        "buffers": [{"byteLength": int(starts[-1])}],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(b.tobytes() + bytes(-b.nbytes % 4) for b in blocks)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    (tmp_path / "a.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return tmp_path / "a.glb"


def _fitted(mesh, copied: bool):
    """A head of which vertex 3 moves up by 4 in its own axes; cut open at vertex 2 if ``copied``."""
    kept = np.array([0, 1, 2, 3, 2] if copied else [0, 1, 2, 3])
    triangles = np.array([[0, 1, 2], [0, 4 if copied else 2, 3]])
    moving = [3, 4] if copied else [3]
    target = Target(np.array(moving, np.int32), np.tile(np.array([[0, 4, 0]], np.float32), (len(moving), 1)))
    part = SimpleNamespace(targets={"jawOpen": target}, triangles=triangles)
    face = SimpleNamespace(part=lambda name: part)
    to_face = SimpleNamespace(turn=np.eye(3), scale=2.0)
    return SimpleNamespace(
        face=face, kept=kept, copied=int(copied), loose=(), alignment=SimpleNamespace(to_face=to_face)
    )


def test_offsets_come_back_in_the_meshs_own_axes(square, tmp_path):
    mesh = read_mesh(square)
    np.testing.assert_allclose(mesh.vertices[1], [0, 2, 0], atol=1e-6)
    shapes = shapes_of_file(_fitted(mesh, False), mesh)
    assert write_shapes(read_gltf(square), shapes, tmp_path / "b.glb") == ()
    file = read_gltf(tmp_path / "b.glb")
    primitive = file.json["meshes"][0]["primitives"][0]
    assert file.json["meshes"][0]["extras"]["targetNames"] == ["wink", "jawOpen"]
    offsets = AccessorReader(file).read(primitive["targets"][1]["POSITION"], 3)
    np.testing.assert_allclose(offsets, [[0, 0, 0]] * 3 + [[1, 0, 0]], atol=1e-6)  # 4 up, halved twice, turned back
    weights = AccessorReader(file).read(file.json["animations"][0]["samplers"][0]["output"], 1)
    assert weights.ravel().tolist() == [0, 0, 1, 0]  # the clip moves its own target as before
    assert file.json["meshes"][0]["weights"] == [0, 0]
    assert file.binary[: len(read_gltf(square).binary)] == read_gltf(square).binary


def test_lips_are_cut_apart_in_the_file(square, tmp_path):
    mesh = read_mesh(square)
    write_shapes(read_gltf(square), shapes_of_file(_fitted(mesh, True), mesh), tmp_path / "b.glb")
    file = read_gltf(tmp_path / "b.glb")
    primitive, reader = file.json["meshes"][0]["primitives"][0], AccessorReader(file)
    points = reader.read(primitive["attributes"]["POSITION"], 3)
    np.testing.assert_allclose(points[4], points[2])
    assert reader.indices(primitive["indices"], 5).reshape(-1, 3).tolist() == [[0, 1, 2], [0, 4, 3]]
    assert reader.read(primitive["targets"][0]["POSITION"], 3)[[2, 4], 2].tolist() == [1, 1]
    assert np.abs(reader.read(primitive["targets"][1]["POSITION"], 3)[[2, 4]]).max(axis=1).tolist() == [0, 1]


def test_what_is_refused(square):
    mesh = mesh_of(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))
    with pytest.raises(InputError, match="write a new"):
        shapes_of_file(_fitted(mesh, False), mesh)
    with pytest.raises(InputError, match="both read and written"):
        write_shapes(read_gltf(square), [PrimitiveShapes(0, 0, {})], square)
