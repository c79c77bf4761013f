"""Targets that move nothing are none, whatever they are called."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.recognition import EMPTY, ForeignFace, foreign_face

NAMES = (
    "jawOpen", "mouthFunnel", "mouthPucker", "mouthClose", "mouthRollLower", "mouthRollUpper", "mouthLeft",
    "mouthRight",
    "mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight", "viseme_aa", "viseme_O", "viseme_PP",
)  # fmt: skip


def face(empty: set[str]) -> ForeignFace:
    accessors = [
        {"bufferView": 0, "count": 3, "type": "VEC3", "componentType": 5126, "min": [0, 0, 0], "max": [0, 0, 0]},
        {"bufferView": 0, "count": 3, "type": "VEC3", "componentType": 5126, "min": [0, -0.01, 0], "max": [0, 0, 0]},
    ]
    targets = [{"POSITION": 0 if name in empty else 1} for name in NAMES]
    mesh = {"primitives": [{"targets": targets}], "extras": {"targetNames": list(NAMES)}}
    return foreign_face(GltfDocument(Path("x.glb"), {"accessors": accessors, "meshes": [mesh], "nodes": [{"mesh": 0}]}))


def weights(shown: ForeignFace, **channels: float) -> dict[str, float]:
    track = ChannelTrack(tuple(channels), [list(channels.values())], FrameRate.of(30))
    return dict(zip(NAMES, shown.weights(shown.meshes[0], track)[0], strict=True))


def test_an_empty_jaw_lets_the_visemes_open_the_mouth() -> None:
    shown = face({"jawOpen"})
    assert {target.name for target in shown.meshes[0].targets if target.still == EMPTY} == {"jawOpen"}
    moved = weights(shown, jawOpen=0.5)
    assert moved["jawOpen"] == 0
    assert moved["viseme_aa"] > 0.3
    rounded = weights(shown, mouthFunnel=1.0)
    assert np.isclose(rounded["mouthFunnel"] + rounded["viseme_O"], 1.0)  # once, by the one or by the other


def test_where_the_jaw_moves_visemes_keep_still() -> None:
    moved = weights(face(set()), jawOpen=0.5)
    assert moved["jawOpen"] == 0.5
    assert moved["viseme_aa"] == 0


def test_a_face_of_empty_targets_is_refused() -> None:
    shown = face(set(NAMES))
    assert not shown.moves
    with pytest.raises(InputError, match="all its morph targets are empty"):
        shown.require_motion()
