"""Shapes that a file holds as few rows are read as few rows."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.gltf_document import read_gltf

COUNT, SHAPES = 50, 20


def file_of(folder, accessors, views, content):
    """A .gltf of some accessors."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    document = {
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": len(content), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": b} for a, b in views], "accessors": accessors,
    }  # fmt: skip
    (folder / "face.gltf").write_text(json.dumps(document))
    return read_gltf(folder / "face.gltf")


def test_many_shapes_on_many_vertices_do_not_count_what_they_leave_alone(tmp_path, monkeypatch):
    """A million vertices times 52 shapes are more numbers than are taken; a tenth of them move."""
    content = np.zeros(3 * COUNT, "<f4").tobytes()
    views, accessors = [(0, len(content))], [{"componentType": 5126, "type": "VEC3", "count": COUNT, "bufferView": 0}]
    for k in range(SHAPES):
        rows, values = np.array([k, k + 3], "<u4"), np.array([[k, 1, 2], [0, 0, 0]], "<f4")
        views += [(len(content), 8), (len(content) + 8, 24)]
        content += rows.tobytes() + values.tobytes()
        sparse = {
            "count": 2, "indices": {"bufferView": 1 + 2 * k, "componentType": 5125},
            "values": {"bufferView": 2 + 2 * k},
        }  # fmt: skip
        accessors.append({"componentType": 5126, "type": "VEC3", "count": COUNT, "sparse": sparse})
    monkeypatch.setenv("MIEN_MOST_NUMBERS", "200")
    reader = AccessorReader(file_of(tmp_path, accessors, views, content))
    reader.read(0, 3)
    for k in range(SHAPES):
        rows, values = reader.offsets(k + 1, COUNT)
        assert rows.tolist() == [k]
        assert values.tolist() == [[k, 1, 2]]
    with pytest.raises(InputError, match="another number of vertices"):
        reader.offsets(1, COUNT + 1)


def test_the_same_bytes_over_and_over_are_refused(tmp_path, monkeypatch):
    content = np.ones(3 * COUNT, "<f4").tobytes()
    accessors = [{"componentType": 5126, "type": "VEC3", "count": COUNT, "bufferView": 0} for _ in range(9)]
    monkeypatch.setenv("MIEN_MOST_NUMBERS", "200")
    reader = AccessorReader(file_of(tmp_path, accessors, [(0, len(content))], content))
    reader.offsets(0, COUNT)
    with pytest.raises(InputError, match="accessors together"):
        [reader.offsets(k, COUNT) for k in range(1, 9)]
