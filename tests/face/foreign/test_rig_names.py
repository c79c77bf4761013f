"""Names as real exporters write them, what they must mean, and what must not be taken for a face's shape."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import mien
from mien.core.channels import ARKIT, WEIGHTS
from mien.face.foreign.foreign_report import inspect_face
from mien.face.foreign.rig_names import conventions, recognised, spelling
from tests.zoo import Builder

NAMES: dict[str, dict[str, dict[str, float]]] = {
    "Face Cap": {"browDown_L": {"browDownLeft": 1}, "mouthSmile_R": {"mouthSmileRight": 1}, "jawOpen": {"jawOpen": 1}},
    "Apple": {"EyeBlinkLeft": {"eyeBlinkLeft": 1}, "TongueOut": {"tongueOut": 1}, "JawLeft": {"jawLeft": 1}},
    "Blender": {
        "Left_eyeBlink": {"eyeBlinkLeft": 1},
        "eye-look-up.R": {"eyeLookUpRight": 1},
        "jawOpen.001": {"jawOpen": 1},
    },
    "Unity": {"Wolf3D_Head.mouthFunnel": {"mouthFunnel": 1}, "blendShape2.cheekPuff": {"cheekPuff": 1}},
    "Daz": {
        "head__eCTRLMouthOpen": {"jawOpen": 1},
        "Genesis8Female__eCTRLBrowInnerUp_L": {"browInnerUp": 1, "browInnerUpLeft": 1},
        "facs_bs_MouthSmile_L_div2": {"mouthSmileLeft": 1},
        "head.eCTRLLipTopUp-DownR": {"mouthUpperUpRight": 1},
        "head.eCTRLJawOut-In": {"jawForward": 1},
        "facs_bs_MouthPurseUpperLeft_div2": {"mouthPucker": 1},
        "facs_bs_MouthPressLowerRight": {"mouthPressRight": 1},
    },
    "Character Creator 3 and 4": {
        "Mouth_Top_Lip_Under": {"mouthRollUpper": 1},
        "Mouth_Bottom_Lip_Under": {"mouthRollLower": 1},
        "Nose_Flank_Raise_L": {"noseSneerLeft": 0.8},
        "Mouth_Roll_Out_Upper_R": {"mouthFunnel": 0.5},
    },
    "Daz 9": {"facs_bs_MouthFunnelUpper_L": {"mouthFunnel": 1}, "facs_bs_EyesSquint_R": {"eyeSquintRight": 1}},
    "Daz 8 visemes": {
        "eCTRLvAA": {"jawOpen": 1.4, "mouthFunnel": -0.7, "mouthPucker": -0.7},
        "eCTRLvER": {"mouthFunnel": 0.5, "tongueTipUp": 0.4},
        "eCTRLvIY": {"mouthStretchLeft": 0.7, "mouthStretchRight": 0.7},
    },
    "Autodesk visemes": {
        "h_expressions.KG_h": {"tongueBackUp": 0.8},
        "h_expressions.UW_U_h": {"mouthPucker": 1},
        "h_expressions.UH_OO_h": {"mouthFunnel": 1},
    },
    "Meta": {
        "Brow_Lowerer_L": {"browDownLeft": 1},
        "Eyes_Look_Left_R": {"eyeLookInRight": 1},
        "Lip_Suck_LB": {"mouthRollLower": 1},
        "Jaw_Sideways_Right": {"jawRight": 1},
        "Lid_Tightener_R": {"eyeSquintRight": 1},
        "Upper_Lid_Raiser_L": {"eyeWideLeft": 1},
    },
    "SRanipal": {
        "Eye_Left_Blink": {"eyeBlinkLeft": 1},
        "Mouth_Sad_Right": {"mouthFrownRight": 1},
        "Mouth_Pout": {"mouthPucker": 1},
    },
    "MakeHuman": {
        "left-inner-brow-up": {"browInnerUp": 1, "browInnerUpLeft": 1},
        "mouth-open": {"jawOpen": 1},
        "right-upper-lid-closed": {"eyeBlinkRight": 1},
    },
    "MetaHuman": {
        "head_lod0_mesh__mouth_cornerPull_L": {"mouthSmileLeft": 1},
        "head_lod0_mesh__jaw_open": {"jawOpen": 1},
        "head_lod0_mesh__brow_raiseIn_R": {"browInnerUp": 1, "browInnerUpRight": 1},
        "head_lod0_mesh__mouth_lipsPurse_UL": {"mouthPucker": 1},
    },
    "units with words": {"AU01_Inner_Brow_Raiser_L": {"browInnerUp": 1, "browInnerUpLeft": 1}, "AU_26": {"jawOpen": 1}},
    "VRChat": {"vrc.v_oh": {"mouthFunnel": 1}, "vrc.v_ou": {"mouthPucker": 1}, "vrc.v_ff": {"mouthRollLower": 1.1}},
    "Mixamo": {
        "Facial_Blends_Smile_Left": {"mouthSmileLeft": 1},
        "Facial_Blends_BrowsUp_Right": {"browInnerUp": 0.6, "browOuterUpRight": 0.5},
        "Facial_Blends_MouthOpen": {"jawOpen": 1},
        "Facial_Blends_UpperLipUp_Left": {"mouthUpperUpLeft": 1},
    },
    "CharMorph": {
        "Expressions_mouthOpen_max": {"jawOpen": 1},
        "Expressions_eyeClosedL_max": {"eyeBlinkLeft": 1},
        "Expressions_browSqueezeR_max": {"browDownRight": 1},
    },
    "Azure": {
        "viseme_1": {"jawOpen": 1.0, "mouthFunnel": -0.7, "mouthPucker": -0.7},
        "viseme_7": {"mouthPucker": 1},
        "viseme_8": {"mouthFunnel": 0.5},
        "viseme_17": {"tongueOut": 1.4},
        "viseme_18": {"mouthRollLower": 1.1},
        "viseme_20": {"tongueBackUp": 0.8},
    },
    "Preston Blair": {
        "AI": {"jawOpen": 1.4, "mouthFunnel": -0.7, "mouthPucker": -0.7},
        "O": {"mouthFunnel": 1},
        "FV": {"mouthRollLower": 1.1},
        "WQ": {"mouthPucker": 0.6},
    },
}
STRANGERS = (
    "Basis",
    "Key 1",
    "thin",
    "angle",
    "Breast_L",
    "BodyHeight",
    "jawOpen_mouthClose",
    "mouthSmileLeft_eyeBlinkLeft_corrective",
    "Target_7",
    "A",
    "o",
    "neutral",
    "upper_mouth_leftover",
    "AU99",
    "Hand_Fist_R",
    "left",
    "0",
    "",
)


@pytest.mark.parametrize("maker", sorted(NAMES))
def test_names_as_they_are_written(maker: str) -> None:
    found = recognised(list(NAMES[maker]))
    for (name, expected), match in zip(NAMES[maker].items(), found, strict=True):
        assert match is not None, name
        assert dict(match.recipe) == pytest.approx(expected), name


@pytest.mark.parametrize("name", STRANGERS)
def test_strangers_keep_still(name: str) -> None:
    assert recognised([name]) == [None]


def test_all_of_arkit_under_every_prefix() -> None:
    for form in ("{}", "blendShape1.{}", "Anna_{}_geo", "ns:{}", "BS_{}", "Head|{}", "A07_{}", "{}_mesh", "ARKit_{}"):
        for name, match in zip(ARKIT, recognised([form.format(name) for name in ARKIT]), strict=True):
            assert match is not None, form.format(name)
            assert dict(match.recipe) == {name: 1.0}, form.format(name)


def test_nodes_under_a_makers_prefix(tmp_path: Path) -> None:
    for number, names in enumerate((("Bob:Head", "Bob:LeftEye", "Bob:RightEye"), ("head.x", "c_eye.l", "c_eye.r"))):
        made = Builder()
        made.bust(made.mesh(["jawOpen"]), names)
        nodes = inspect_face(made.glb(tmp_path / f"{number}.glb")).nodes
        assert (nodes["head"], nodes["eyeLeft"], nodes["eyeRight"]) == names


def test_the_tables_hold_together() -> None:
    folder = Path(mien.__file__).parent / "assets" / "rigs"
    assert len(conventions()) == len(list((folder / "conventions").glob("*.toml")))
    for table in conventions():
        for match in table.targets.values():
            assert set(match.recipe) <= set(WEIGHTS)
            assert max(match.recipe.values()) > 0
    costs = tomllib.loads((folder / "costs.toml").read_text(encoding="utf-8"))["cost"]
    named = [channel for cost in costs for channel in cost["channels"]]
    assert set(named) <= set(WEIGHTS)
    assert len(named) == len(set(named))
    assert {cost["weight"] for cost in costs} == {"speech", "expression", "detail"}
    assert set(ARKIT) - set(named) <= {f"eyeLook{way}{side}" for way in ("In", "Out") for side in ("Left", "Right")}


def test_spelling() -> None:
    assert spelling("AU01_L") == spelling("au-1.left") == "au1left"
    assert spelling("mouthFunnelUL") != spelling("mouthFunnelL")


def test_what_is_missing_comes_by_weight(tmp_path: Path) -> None:
    made = Builder()
    made.bust(made.mesh([name for name in ARKIT if name not in ("jawOpen", "browInnerUp", "cheekPuff")]))
    report = inspect_face(made.glb(tmp_path / "some.glb"))
    assert [lost.weight for lost in report.missing] == sorted(
        [lost.weight for lost in report.missing], key=("speech", "expression", "detail").index
    )
    told = {channel: lost.words for lost in report.missing for channel in lost.channels}
    assert "cannot open" in told["jawOpen"]
    assert "sadness" in told["browInnerUp"]
    assert "air" in told["cheekPuff"]
    assert "mouthSmileLeft" not in told
