"""Streams that meshoptimizer's own encoder wrote (npm ``meshoptimizer``, ``encodeGltfBuffer`` version 0), decoded."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest

from mien.face.foreign.meshopt import decoded
from tests.zoo import encoded

CASES = json.loads((Path(__file__).parent / "meshopt_cases.json").read_text(encoding="utf-8"))


def _turned(triangles: bytes) -> np.ndarray:
    """Triangles with their smallest index first: the codec may turn them."""
    rows = np.frombuffer(triangles, "<u4").reshape(-1, 3)
    return np.array([np.roll(row, -int(row.argmin())) for row in rows])


@pytest.mark.parametrize("case", CASES, ids=[f"{case['mode']}-{case['n']}" for case in CASES])
def test_what_meshoptimizer_encodes(case: dict) -> None:
    stream, raw = base64.b64decode(case["enc"]), base64.b64decode(case["raw"])
    if case["mode"] == "EXP":
        got = np.frombuffer(decoded(stream, "ATTRIBUTES", case["n"], case["stride"], "EXPONENTIAL"), "<f4")
        np.testing.assert_allclose(got, np.frombuffer(raw, "<f4"), atol=1e-3)
        return
    got = decoded(stream, case["mode"], case["n"], case["stride"])
    if case["mode"] == "TRIANGLES":
        np.testing.assert_array_equal(_turned(got), _turned(raw))
    else:
        assert got == raw


@pytest.mark.parametrize("case", CASES, ids=[f"{case['mode']}-{case['n']}" for case in CASES])
def test_damaged_streams_are_refused_or_decode_to_something(case: dict) -> None:
    stream, random = base64.b64decode(case["enc"]), np.random.default_rng(1)
    mode = "ATTRIBUTES" if case["mode"] == "EXP" else case["mode"]
    for _ in range(60):
        damaged = bytearray(stream[: int(random.integers(1, len(stream) + 1))])
        damaged[int(random.integers(len(damaged)))] ^= int(random.integers(1, 256))
        try:
            got = decoded(bytes(damaged), mode, case["n"], case["stride"])
        except ValueError:
            continue
        assert len(got) == case["n"] * case["stride"]


def test_literal_streams_of_the_zoo() -> None:
    rows = np.random.default_rng(0).integers(0, 256, (700, 8)).astype(np.uint8)
    assert decoded(encoded(rows.tobytes(), 8), "ATTRIBUTES", 700, 8) == rows.tobytes()


@pytest.mark.parametrize(
    ("mode", "count", "stride", "kind"),
    [
        ("ATTRIBUTES", -1, 4, "NONE"),
        ("ATTRIBUTES", 10**9, 200, "NONE"),
        ("ATTRIBUTES", 3, 6, "NONE"),
        ("X", 3, 4, "NONE"),
        ("TRIANGLES", 3, 8, "NONE"),
        ("TRIANGLES", 4, 4, "NONE"),
        ("ATTRIBUTES", 1, 4, "OCTAHEDRAL"),
    ],
)
def test_what_is_not_known_is_refused(mode: str, count: int, stride: int, kind: str) -> None:
    stream = bytes([{"ATTRIBUTES": 0xA0, "TRIANGLES": 0xE1}.get(mode, 0)]) + bytes(80)
    with pytest.raises(ValueError, match=r"."):
        decoded(stream, mode, count, stride, kind)
