"""What VRM's expressions ask for: overrides, gaze by shapes or bones, degrees of the eyes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.recognition import ForeignFace, foreign_face

ORDER = ("aa", "ou", "happy", "angry", "lookLeft", "lookRight", "blinkLeft")


def avatar(**facts: Any) -> ForeignFace:
    preset: dict[str, Any] = {
        n: {"morphTargetBinds": [{"node": 0, "index": p, "weight": 1.0}]} for p, n in enumerate(ORDER)
    }
    for name, more in facts.pop("more", {}).items():
        preset[name] |= more
    document = {
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"targets": [{"POSITION": 0} for _ in ORDER]}]}],
        "extensions": {"VRMC_vrm": {"expressions": {"preset": preset}, **facts}},
    }
    return foreign_face(GltfDocument(Path("x.vrm"), document))


def weights(face: ForeignFace, **channels: float) -> dict[str, float]:
    track = ChannelTrack(tuple(channels), [list(channels.values())], FrameRate.of(30))
    return dict(zip(ORDER, face.weights(face.meshes[0], track)[0], strict=True))


def test_an_expression_that_blends_takes_the_mouth_back_while_it_shows() -> None:
    face = avatar(more={"happy": {"overrideMouth": "blend", "overrideBlink": "block"}})
    got = weights(face, jawOpen=0.5, mouthSmileLeft=1.0, mouthSmileRight=1.0, eyeBlinkLeft=1.0)
    assert got["happy"] == pytest.approx(0.7)
    assert got["aa"] == pytest.approx(0.7 * 0.3)
    assert got["blinkLeft"] == 0.0
    assert weights(face, jawOpen=0.5, eyeBlinkLeft=1.0) == pytest.approx(
        dict.fromkeys(ORDER, 0.0) | {"aa": 0.7, "blinkLeft": 1.0}
    )


def test_an_expression_that_would_stop_the_mouth_is_left_alone() -> None:
    face = avatar(more={"angry": {"overrideMouth": "block"}})
    assert weights(face, browDownLeft=1.0, browDownRight=1.0)["angry"] == 0.0
    assert weights(avatar(), browDownLeft=1.0, browDownRight=1.0)["angry"] == pytest.approx(0.8)


def test_gaze_by_shapes_only_where_the_avatar_says_so() -> None:
    looking = {"eyeLookOutLeft": 1.0, "eyeLookInRight": 1.0}
    assert weights(avatar(lookAt={"type": "expression"}), **looking)["lookLeft"] == pytest.approx(1.0)
    assert weights(avatar(lookAt={"type": "bone"}), **looking)["lookLeft"] == 0.0


def test_degrees_of_the_eyes_are_the_avatars() -> None:
    face = avatar(lookAt={"type": "bone", "rangeMapVerticalUp": {"inputMaxValue": 90, "outputScale": 8.0}})
    assert face.turning.degrees["Up"] == 8.0
    assert face.turning.degrees["Down"] == 24.0


def test_binary_is_off_or_on() -> None:
    face = avatar(more={"ou": {"isBinary": True}})
    assert weights(face, mouthPucker=0.49)["ou"] == 0.0
    assert weights(face, mouthPucker=0.51)["ou"] == 1.0


@pytest.mark.parametrize("bind", [{"node": 9, "index": 0}, {"node": 0, "index": 99}, {"node": 0, "index": -1}, {}, 3])
def test_binds_that_lead_nowhere_are_one_line(bind: object) -> None:
    with pytest.raises(InputError, match=r"x\.vrm"):
        avatar(more={"aa": {"morphTargetBinds": [bind]}})


def test_weights_stay_in_bounds() -> None:
    face = avatar()
    random = np.random.default_rng(0)
    names = ("jawOpen", "mouthPucker", "mouthFunnel", "mouthSmileLeft", "browDownLeft", "eyeBlinkLeft")
    got = face.weights(face.meshes[0], ChannelTrack(names, random.uniform(0, 1, (50, 6)), FrameRate.of(30)))
    assert got.min() >= 0.0
    assert got.max() <= 1.0


def test_expressions_of_paint_are_named():
    from pathlib import Path

    from mien.face.foreign.gltf_document import GltfDocument
    from mien.face.foreign.vrm import vrm_painted

    one = {"expressions": {"preset": {"aa": {"textureTransformBinds": [{}]}, "blink": {"morphTargetBinds": []}}}}
    zero = {"blendShapeMaster": {"blendShapeGroups": [{"name": "O", "materialValues": [{}]}, {"name": "A"}]}}
    content = {"extensions": {"VRMC_vrm": one, "VRM": zero}}
    assert vrm_painted(GltfDocument(Path("a.vrm"), content)) == ("aa", "O")


@pytest.mark.parametrize(
    "extensions",
    [
        {"VRMC_springBone": {"springs": [{"joints": []}, {"joints": []}]}},
        {"VRM": {"secondaryAnimation": {"boneGroups": [{"bones": [0]}, {"bones": [1]}]}}},
    ],
)
def test_spring_bones_are_counted(extensions) -> None:
    from mien.face.foreign.vrm import vrm_springs

    assert vrm_springs(GltfDocument(Path("a.vrm"), {"extensions": extensions})) == 2
    assert vrm_springs(GltfDocument(Path("a.vrm"), {"extensions": {"VRM": {"secondaryAnimation": {}}}})) == 0
