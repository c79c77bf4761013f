"""MPEG-4 parameter files: round trip, units by hand, high-level parameters, faults with their lines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.formats.fap import COUNT, FapTrack, fap_table, fap_track, fap_units, read_fap, write_fap, write_fap_track
from mien.formats.registry import save
from tests.faces import tiny_animation, tiny_face


def same(one: FapTrack, other: FapTrack) -> bool:
    fields = ("values", "masks", "visemes", "expressions")
    return one.rate == other.rate and all(np.array_equal(getattr(one, f), getattr(other, f)) for f in fields)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 5), st.sampled_from(["25", "30", "30000/1001", "12.5"]))
def test_any_track_comes_back(tmp_path_factory: pytest.TempPathFactory, seed: int, frames: int, fps: str) -> None:
    rng = np.random.default_rng(seed)
    masks = rng.random((frames, COUNT)) < 0.5
    values = rng.integers(-2000, 2000, (frames, COUNT)) * masks
    values[:, :2] = 0
    visemes = rng.integers(0, 15, (frames, 4)) * masks[:, :1]
    expressions = rng.integers(0, 7, (frames, 6)) * masks[:, 1:2]
    track = FapTrack(values, masks, visemes, expressions, FrameRate.of(fps), "a b")
    path = tmp_path_factory.mktemp("fap") / "a.fap"
    write_fap_track(track, path)
    again = read_fap(path)
    assert again.name == "a_b"
    assert again.rate.fps == pytest.approx(track.rate.fps, rel=1e-8)
    assert same(replace(again, rate=track.rate), track)


def posed(**weights: float):
    values = np.zeros((2, len(ALL)))
    for name, weight in weights.items():
        values[1, ALL.index(name)] = weight
    animation = tiny_animation(2)
    return replace(animation, channels=ChannelTrack(ALL, values, animation.rate))


def column(name: str) -> int:
    return next(int(number) - 1 for number, facts in fap_table()["fap"].items() if facts["name"] == name)


def test_a_jaw_and_a_head_by_hand() -> None:
    face = load_face()
    track = fap_track(posed(jawOpen=0.5, headYaw=10.0, headPitch=5.0, headRoll=-2.0), face)
    part, chin = face.sites["chin"]
    target = face.part(part).targets["jawOpen"]
    drop = -0.5 * target.offsets[target.vertices == chin][0, 1]
    lip, nose = face.part("skin").vertices[face.sites["lip_upper_inner"][1]], -45.36
    unit = (nose - lip[1]) / 1024
    assert track.values[1, column("open_jaw")] == pytest.approx(drop / unit, rel=0.02)
    assert track.values[0, column("open_jaw")] == 0
    assert track.values[1, column("head_yaw")] == round(np.radians(10) * 1e5)
    assert track.values[1, column("head_pitch")] == round(np.radians(-5) * 1e5)  # up is negative
    assert track.values[1, column("head_roll")] == round(np.radians(2) * 1e5)
    assert not track.masks[:, :2].any()


def test_signs_of_smile_brow_and_eyes() -> None:
    track = fap_track(
        posed(mouthSmileLeft=1, mouthSmileRight=1, browInnerUp=1, eyeBlinkLeft=1, eyeLookInLeft=1, eyeLookOutRight=1),
        load_face(),
    )
    row = track.values[1]
    for name in ("stretch_l_cornerlip", "stretch_r_cornerlip", "raise_l_cornerlip", "raise_r_i_eyebrow"):
        assert row[column(name)] > 50, name
    assert row[column("close_t_l_eyelid")] > 600
    assert abs(row[column("close_t_r_eyelid")]) < 60
    assert row[column("yaw_l_eyeball")] < 0  # both look to the speaker's right
    assert row[column("yaw_r_eyeball")] < 0


def test_high_level_parameters_follow_score_and_phones(tmp_path: Path) -> None:
    animation = tiny_animation(30)
    assert write_fap(animation, load_face(), tmp_path / "a.fap", high_level=True) == ()
    track = read_fap(tmp_path / "a.fap")
    assert track.masks[:, :2].all()
    assert not track.masks[:, 2:].any()
    intensity = track.emotions()
    assert intensity[0, 0] == pytest.approx(0.6, abs=0.01)  # happy until half the sound
    assert not intensity[-1].any()
    assert track.visemes[-1, 0] == 1  # P
    assert {10, 1} <= set(track.visemes[:, 0].tolist())  # AH, then P


def test_saved_by_suffix_and_says_what_it_masks(tmp_path: Path) -> None:
    (note,) = save(tiny_animation(3), tmp_path / "a.fap", face=load_face())
    assert "raise_l_ear" in note.message
    assert len(read_fap(tmp_path / "a.fap")) == 3
    assert fap_units(load_face())["AU"] == 1e-5
    with pytest.raises(InputError, match="lacks feature points"):
        fap_units(tiny_face())
    told = save(tiny_animation(3), tmp_path / "b.fap", face=tiny_face())
    assert "measured on the default face" in told[0].message
    assert (tmp_path / "b.fap").read_bytes() == (tmp_path / "a.fap").read_bytes()


MASKS = " ".join(["1"] * COUNT)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "expected '2.1 NAME FPS FRAMES'"),
        ("2.1 x 25", "expected '2.1 NAME FPS FRAMES'"),
        ("2.1 x fast 1", "a.fap:1: expected '2.1 NAME FPS FRAMES'"),
        ("2.1 x 25 1\n" + "0 " * 68 + "\n0\n0 0\n", "a.fap:4: more follows after the 1 frames"),
        ("2.1 x 25 1\n0 1", "a.fap:2: expected 68 masks of 0 or 1, got 2"),
        ("# r\n2.1 x 25 1\n" + MASKS + "\n0 1 2", "a.fap:4: the masks ask for a frame number and 76 values, got 3"),
        ("2.1 x 25 2\n" + "0 " * 68 + "\n0\n", "ends before the masks of frame 1 of 2"),
        ("2.1 x 25 1\n" + "0 " * 67 + "a\n0\n", "a.fap:2: expected whole numbers"),
    ],
)
def test_damaged_files_name_the_line(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "a.fap").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_fap(tmp_path / "a.fap")
    assert told in str(caught.value)


def test_as_other_programs_write_it(tmp_path: Path) -> None:
    path = tmp_path / "a.fap"
    path.write_bytes(f"# f\u00fcr\r\n2.0\tmy take 29.97 1 # fps\r\n{MASKS} \r\n\r\n1".encode("cp1252") + b" 7.0" * 76)
    track = read_fap(path)
    assert (track.name, round(track.rate.fps, 2), len(track)) == ("my take", 29.97, 1)
    assert (track.values[0, 2:] == 7).all()
    assert (track.expressions[0] == 7).all()


# ISO/IEC 14496-2, Annex C: number, name, unit, positive direction.
STANDARD = """
3 open_jaw MNS down; 4 lower_t_midlip MNS down; 5 raise_b_midlip MNS up; 6 stretch_l_cornerlip MW left
7 stretch_r_cornerlip MW right; 8 lower_t_lip_lm MNS down; 9 lower_t_lip_rm MNS down; 10 raise_b_lip_lm MNS up
11 raise_b_lip_rm MNS up; 12 raise_l_cornerlip MNS up; 13 raise_r_cornerlip MNS up; 14 thrust_jaw MNS forward
15 shift_jaw MW right; 16 push_b_lip MNS forward; 17 push_t_lip MNS forward; 18 depress_chin MNS up
19 close_t_l_eyelid IRISD down; 20 close_t_r_eyelid IRISD down; 21 close_b_l_eyelid IRISD up
22 close_b_r_eyelid IRISD up; 23 yaw_l_eyeball AU left; 24 yaw_r_eyeball AU left; 25 pitch_l_eyeball AU down
26 pitch_r_eyeball AU down; 27 thrust_l_eyeball ES forward; 28 thrust_r_eyeball ES forward
31 raise_l_i_eyebrow ENS up; 32 raise_r_i_eyebrow ENS up
33 raise_l_m_eyebrow ENS up; 34 raise_r_m_eyebrow ENS up; 35 raise_l_o_eyebrow ENS up; 36 raise_r_o_eyebrow ENS up
37 squeeze_l_eyebrow ES right; 38 squeeze_r_eyebrow ES left; 39 puff_l_cheek ES left; 40 puff_r_cheek ES right
41 lift_l_cheek ENS up; 42 lift_r_cheek ENS up; 43 shift_tongue_tip MW right; 44 raise_tongue_tip MNS up
45 thrust_tongue_tip MW forward; 46 raise_tongue MNS up; 48 head_pitch AU down; 49 head_yaw AU left
50 head_roll AU right; 51 lower_t_midlip_o MNS down; 52 raise_b_midlip_o MNS up; 53 stretch_l_cornerlip_o MW left
54 stretch_r_cornerlip_o MW right; 55 lower_t_lip_lm_o MNS down; 56 lower_t_lip_rm_o MNS down
57 raise_b_lip_lm_o MNS up; 58 raise_b_lip_rm_o MNS up; 59 raise_l_cornerlip_o MNS up; 60 raise_r_cornerlip_o MNS up
61 stretch_l_nose ENS left; 62 stretch_r_nose ENS right; 63 raise_nose ENS up; 64 bend_nose ENS right
65 raise_l_ear ENS up; 66 raise_r_ear ENS up; 67 pull_l_ear ENS left; 68 pull_r_ear ENS right
"""


def test_names_units_and_directions_are_the_standards() -> None:
    ways = {"up": "+y", "down": "-y", "left": "+x", "right": "-x", "forward": "+z"}
    table = fap_table()["fap"]
    rows = [row.split() for row in STANDARD.replace("\n", ";").split(";") if row.strip()]
    assert len(rows) == 63
    for number, name, unit, way in rows:
        facts = table[number]
        assert (facts["name"], facts["unit"]) == (name, unit)
        assert facts["positive"] in (way, ways[way]), name
