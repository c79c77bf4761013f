"""A lighter GLB shows the same face: what moves, moves as far."""

from __future__ import annotations

import gzip
import json

import numpy as np

from mien.serve.studio.light_glb import light_glb
from mien.serve.studio.studio_faces import _resting_glb


def document(content: bytes) -> tuple[dict, bytes]:
    length = int.from_bytes(content[12:16], "little")
    return json.loads(content[20 : 20 + length]), content[28 + length :]


def moved(content: bytes, mesh: str, primitive: int, target: int) -> np.ndarray:
    told, data = document(content)
    part = next(one for one in told["meshes"] if one["name"] == mesh)["primitives"][primitive]
    accessor = told["accessors"][part["targets"][target]["POSITION"]]
    values = np.zeros((accessor["count"], 3))
    sparse = accessor["sparse"]
    kinds = {5122: ("<i2", 32767), 5123: ("<u2", 1), 5125: ("<u4", 1), 5126: ("<f4", 1)}

    def read(view: int, kind: str, count: int) -> np.ndarray:
        return np.frombuffer(data, kind, count, told["bufferViews"][view].get("byteOffset", 0))

    kind, share = kinds[accessor["componentType"]]
    places = read(sparse["indices"]["bufferView"], kinds[sparse["indices"]["componentType"]][0], sparse["count"])
    values[places] = read(sparse["values"]["bufferView"], kind, 3 * sparse["count"]).reshape(-1, 3) / share
    return values


def test_targets_move_as_far_with_half_the_bytes() -> None:
    whole = _resting_glb("default")
    light = light_glb(whole)
    assert len(light) < 0.6 * len(whole)
    assert len(gzip.compress(light, 6)) < 3_700_000, "with 0.3 MB of page a first visit is to take less than 4 MB"
    before, after = moved(whole, "face", 0, 20), moved(light, "face", 0, 20)
    assert np.abs(before).max() > 1e-3
    assert np.abs(after - before).max() < 2e-5, "metres"
    (old, old_data), (told, data) = document(whole), document(light)
    places = [one["accessors"][one["meshes"][0]["primitives"][0]["attributes"]["POSITION"]] for one in (old, told)]
    exact = np.frombuffer(old_data, "<f4", 30, old["bufferViews"][places[0]["bufferView"]].get("byteOffset", 0))
    first = told["bufferViews"][places[1]["bufferView"]]
    steps = np.frombuffer(data, "<i2", 40, first["byteOffset"]).reshape(-1, first["byteStride"] // 2)[:, :3]
    assert np.abs(steps.ravel() / 32767 - exact).max() < 2e-5, "metres"
    assert told["extensionsRequired"] == ["KHR_mesh_quantization"]
    assert all(one["byteOffset"] % 4 == 0 for one in told["bufferViews"])
