"""The columns, units and signs of Live Link Face."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

import mien
from mien.api.calls import read_motion
from mien.core.channels import ALL, ARKIT, HEAD
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.livelink import COLUMNS, EYE_DEGREES, read_livelink, write_livelink
from tests.faces import tiny_animation

HEADER = (
    "Timecode,BlendShapeCount,EyeBlinkLeft,EyeLookDownLeft,EyeLookInLeft,EyeLookOutLeft,EyeLookUpLeft,EyeSquintLeft,"
    "EyeWideLeft,EyeBlinkRight,EyeLookDownRight,EyeLookInRight,EyeLookOutRight,EyeLookUpRight,EyeSquintRight,"
    "EyeWideRight,JawForward,JawRight,JawLeft,JawOpen,MouthClose,MouthFunnel,MouthPucker,MouthRight,MouthLeft,"
    "MouthSmileLeft,MouthSmileRight,MouthFrownLeft,MouthFrownRight,MouthDimpleLeft,MouthDimpleRight,MouthStretchLeft,"
    "MouthStretchRight,MouthRollLower,MouthRollUpper,MouthShrugLower,MouthShrugUpper,MouthPressLeft,MouthPressRight,"
    "MouthLowerDownLeft,MouthLowerDownRight,MouthUpperUpLeft,MouthUpperUpRight,BrowDownLeft,BrowDownRight,BrowInnerUp,"
    "BrowOuterUpLeft,BrowOuterUpRight,CheekPuff,CheekSquintLeft,CheekSquintRight,NoseSneerLeft,NoseSneerRight,"
    "TongueOut,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll"
)


def posed(rate=30, frames=1, **channels):
    values = np.zeros((frames, len(ALL)))
    for name, value in channels.items():
        values[:, ALL.index(name)] = value
    return replace(tiny_animation(), channels=ChannelTrack(ALL, values, FrameRate.of(rate)))


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def test_header():
    assert ",".join(COLUMNS) == HEADER
    assert len(COLUMNS) == 2 + 61


def test_units_and_signs(tmp_path):
    write_livelink(
        posed(headYaw=90, headPitch=30, headRoll=-45, eyeLookOutLeft=1, eyeLookInRight=0.5), tmp_path / "a.csv"
    )
    (row,) = rows_of(tmp_path / "a.csv")
    assert row["Timecode"] == "00:00:00:00.000"
    assert row["BlendShapeCount"] == "61"
    assert float(row["HeadYaw"]) == pytest.approx(np.pi / 2, abs=1e-8)  # to the speaker's left
    assert float(row["HeadPitch"]) == pytest.approx(-np.pi / 6, abs=1e-8)  # looking up
    assert float(row["HeadRoll"]) == pytest.approx(np.pi / 4, abs=1e-8)  # towards the right shoulder
    assert float(row["LeftEyeYaw"]) == pytest.approx(np.radians(EYE_DEGREES["Out"]), abs=1e-8)
    assert float(row["RightEyeYaw"]) == pytest.approx(np.radians(EYE_DEGREES["In"]) / 2, abs=1e-8)
    assert "-0.00000000" not in (tmp_path / "a.csv").read_text(encoding="utf-8")


def test_eyes_up_and_down(tmp_path):
    write_livelink(posed(eyeLookUpLeft=1, eyeLookDownRight=1), tmp_path / "a.csv")
    (row,) = rows_of(tmp_path / "a.csv")
    assert float(row["LeftEyePitch"]) < 0 < float(row["RightEyePitch"])


@pytest.mark.parametrize("fps", [25, 30, 60, 24])
def test_round_trip(tmp_path, fps):
    animation = tiny_animation(3 * fps, FrameRate.of(fps))
    evened, dropped = write_livelink(animation, tmp_path / "a.csv")
    assert "one channel for both inner brows" in evened.message
    assert "cannot hold noseFlareLeft" in dropped.message
    again, _ = read_livelink(tmp_path / "a.csv")
    expected = animation.channels.select(ARKIT + HEAD)
    assert again.names == expected.names
    assert again.rate == expected.rate
    kept = [column for column, name in enumerate(expected.names) if name != "browInnerUp"]
    assert np.abs(again.values - expected.values)[:, kept].max() < 1e-6


def test_the_inner_brows_fold_into_arkits_one(tmp_path):
    (apart,) = write_livelink(posed(browInnerUp=0.2, browInnerUpLeft=0.6), tmp_path / "a.csv")
    assert "sides up to 0.60 apart" in apart.message
    assert float(rows_of(tmp_path / "a.csv")[0]["BrowInnerUp"]) == pytest.approx(0.5, abs=1e-8)
    assert write_livelink(posed(browInnerUpLeft=1.0, browInnerUpRight=1.0), tmp_path / "b.csv") == ()
    assert float(rows_of(tmp_path / "b.csv")[0]["BrowInnerUp"]) == 1.0


@pytest.mark.parametrize("fps", [29.97, 59.94, 23.976])
def test_a_rate_of_television_comes_back_from_the_timecode_with_its_start(tmp_path, fps):
    rate = FrameRate.of(fps)
    animation = replace(tiny_animation(130, rate), timecode="11:54:00:19.804")
    assert f"has {rate} frames per second" in write_livelink(animation, tmp_path / "a.csv")[-1].message
    again = read_motion(tmp_path / "a.csv")
    assert again.rate == rate
    assert len(again.channels) == 130
    assert again.timecode == "11:54:00:19.804"
    write_livelink(again, tmp_path / "b.csv")
    assert [line[:15] for line in (tmp_path / "b.csv").read_text().splitlines()] == [
        line[:15] for line in (tmp_path / "a.csv").read_text().splitlines()
    ]


def test_a_recorded_start_goes_through_the_native_file_and_an_expression(tmp_path):
    animation = replace(tiny_animation(40), timecode="01:02:03:04.500")
    mien.save(animation, tmp_path / "a.json")
    felt = mien.express(tmp_path / "a.json", emotion="happy")
    mien.save(felt, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text().splitlines()[1].startswith("01:02:03:04.500,61,")


def test_recording_of_the_app(tmp_path):
    """Odd capitals, a start late in the day, a byte order mark, and a frame in which the face was lost."""
    lines = [HEADER.replace("BlendShapeCount", "BlendshapeCount")]
    for frame in range(65):
        numbers = ["0.5"] * 52 + ["0.1"] * 9 if frame != 10 else []
        lines.append(",".join([f"14:03:{frame // 60:02d}:{frame % 60:02d}.207", "61" if numbers else "0", *numbers]))
    (tmp_path / "a.csv").write_text("\r\n".join(lines), encoding="utf-8-sig")
    track, notes = read_livelink(tmp_path / "a.csv")
    assert [note.message for note in notes] == ["a.csv: the face was lost in 1 frames: filled"]
    assert track.rate == FrameRate.of(60)
    assert np.array_equal(track.values[10], track.values[9])
    assert track.channel("headPitch")[0] == pytest.approx(-np.degrees(0.1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("JawOpen", "JawAgape"), "lacks 1 columns, first 'JawOpen'"),
        (lambda text: "", "lacks"),
        (lambda text: text.replace("0.10000000", "x", 1), "line 2, column 20 .JawOpen.: expected numbers"),
        (lambda text: text.rsplit(",", 1)[0][:-200], "line 61: expected 63 columns"),
        (lambda text: text.replace("00:00:00:05.000", "5"), "line 7: expected a timecode"),
    ],
)
def test_bad_files(tmp_path, change, message):
    path = tmp_path / "bad.csv"
    write_livelink(posed(frames=60, jawOpen=0.1), path)
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        read_livelink(path)
    assert "bad.csv" in str(caught.value)


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_livelink(tmp_path / "none.csv")
    (tmp_path / "noise.csv").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="expected a Live Link Face CSV"):
        read_livelink(tmp_path / "noise.csv")


def test_a_take_shorter_than_a_second_is_read_with_a_note(tmp_path):
    path = tmp_path / "short.csv"
    write_livelink(tiny_animation(9), path)
    channels, notes = read_livelink(path)
    assert len(channels) == 9
    assert any("30 frames/s are assumed" in note.message for note in notes)
