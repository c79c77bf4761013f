"""Draco meshes and KTX2 pictures, decoded by packages that are extras."""

from __future__ import annotations

import base64

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.ktx2 import is_ktx2, ktx2_pixels

# 8 x 8 pixels, four quarters: red, green, blue, near white (Basis Universal 2.1, ETC1S and UASTC).
ETC1S = (
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAkAAAAAAAAABIAQAAAAAAAAIAAAAA"
    "AAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAAAQA"
    "AgAyAAAACQAAAC0AAAAAAAAAAAAAAAAAAAACAAAAAAAAAAAAAAAaQMSAAQAAIND4wRQFMCUAAAAAAAQNsMkCMAcgAAAAAITRlSEAMQAAAAAAIBhsb4nFA6yqqqpS"
    "VVVVBQDBRAAAAAAAAPJfTQCYAAAAAAAAQBgBJgQIAAAAgCBySgHABAAAAAAAAAIIAFQH"
)
UASTC = (
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAAAAAAAaAAAACwAAACUAAAALAAAAAAAAAAAAAAAAAAAAAAAAADAAAAAAAAAAEAAAAAA"
    "AAAAQAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAAAQA"
    "AAB/fwAA15zC4z/igwAAAAAAAAAAAJeCG+U/GrsAAAAAAAAAAADXA0X6fxwkAwAAAAAAAAAAFx4e/h90zgEAAAAAAAAAAA=="
)
QUARTERS = np.array([[[230, 20, 30], [20, 220, 40]], [[30, 40, 210], [240, 240, 240]]])


@pytest.mark.parametrize(("data", "off"), [(ETC1S, 4), (UASTC, 1)])
def test_ktx2(data, off):
    raw = base64.b64decode(data)
    assert is_ktx2(raw)
    pixels = ktx2_pixels(raw, "a", 2048)
    wanted = np.repeat(np.repeat(QUARTERS, 4, axis=0), 4, axis=1)
    assert np.abs(pixels[:, :, :3].astype(int) - wanted).max() <= off
    for cut in (10, 60, 150, len(raw) - 20):
        with pytest.raises(InputError):
            ktx2_pixels(raw[:cut], "a", 2048)


def _packed(count: int = 4) -> GltfDocument:
    import DracoPy

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    data = DracoPy.encode(points, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), preserve_order=True)
    extension = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "extensions": extension}
    accessors = [
        {"componentType": 5126, "count": count, "type": "VEC3"}, {"componentType": 5125, "count": 6, "type": "SCALAR"}
    ]  # fmt: skip
    content = {
        "meshes": [{"primitives": [primitive]}], "accessors": accessors, "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
    }  # fmt: skip
    from pathlib import Path

    return GltfDocument(Path("a.glb"), content, data)


def test_draco():
    reader = AccessorReader(_packed())
    corners = reader.read(0, 3)[reader.indices(1, 4).reshape(-1, 3)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    np.testing.assert_allclose(area, 1.0, atol=1e-3)


def test_draco_that_does_not_hold_together():
    document = _packed()
    broken = GltfDocument(document.path, document.json, bytes(40) + document.binary[40:])
    with pytest.raises(InputError, match="cannot be decoded as Draco"):
        AccessorReader(broken).read(0, 3)
    with pytest.raises(InputError, match="claims"):
        AccessorReader(_packed(10_000_000)).read(0, 3)
