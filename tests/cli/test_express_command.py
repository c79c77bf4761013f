"""``mien express``: expressions over motion that exists already."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mien
from mien.animation.animation import imported
from mien.cli import main
from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.livelink import read_livelink
from mien.formats.native import read_native
from mien.motion.performer import Performer
from mien.pipeline.perform import perform
from mien.text.score import Score
from tests.cli.test_main import refused
from tests.utterances import utterance

LINE = utterance(("SIL", 0.3), ("M", 0.15), ("AA", 0.3), ("P", 0.15), ("IY", 0.3), ("SIL", 1.0))


@pytest.fixture
def line(tmp_path: Path) -> Path:
    animation = perform(LINE, Score(), Performer.hand_made(), FrameRate.of(50))
    mien.save(animation, tmp_path / "line.json", tmp_path / "line.csv")
    return tmp_path / "line.json"


def test_a_smile_over_a_native_animation(line: Path) -> None:
    assert main(["express", str(line), "--emotion", "happy", "-o", str(line.with_name("happy.json")), "--quiet"]) == 0
    plain, happy = read_native(line), read_native(line.with_name("happy.json"))
    assert len(happy.channels) == len(plain.channels)
    assert happy.utterance == plain.utterance
    assert [span.name for span in happy.score.emotions] == ["happy"]
    assert (happy.channels.channel("mouthSmileLeft") - plain.channels.channel("mouthSmileLeft")).mean() > 0.3


def test_the_lips_stay_shut_and_blinks_stay_blinks(line: Path) -> None:
    plain = read_native(line)
    felt = mien.express(plain, emotion="surprised")
    shut = plain.rate.nearest_frame(0.825)
    for name in ("jawOpen", "mouthUpperUpLeft", "mouthFunnel"):
        assert felt.channels.channel(name)[shut] <= plain.channels.channel(name)[shut] + 1e-9
    assert felt.channels.channel("jawOpen").mean() > plain.channels.channel("jawOpen").mean() + 0.05
    assert (felt.channels.channel("eyeBlinkLeft") >= plain.channels.channel("eyeBlinkLeft") - 1e-9).all()


def test_an_intensity_of_zero_changes_nothing(line: Path) -> None:
    plain = read_native(line)
    np.testing.assert_allclose(mien.express(plain, emotion="sad:0").channels.values, plain.channels.values, atol=1e-12)


def test_over_a_live_link_recording_with_mpeg4_parameters(line: Path, tmp_path: Path) -> None:
    (tmp_path / "parameters.csv").write_text(
        "seconds,expression1,intensity1,expression2,intensity2\n0,joy,0,,\n1,joy,63,,\n"
    )
    recording, parameters, output = line.with_suffix(".csv"), tmp_path / "parameters.csv", tmp_path / "felt.csv"
    assert main(["express", str(recording), "--emotion", str(parameters), "-o", str(output)]) == 0
    felt, plain = (read_livelink(path)[0].channel("mouthSmileLeft") for path in (output, recording))
    assert felt[0] == pytest.approx(plain[0], abs=1e-6)
    assert felt[-1] > plain[-1] + 0.4


def test_without_an_emotion_the_motion_is_written_in_another_format(line: Path) -> None:
    assert main(["express", str(line), "-o", str(line.with_name("same.json"))]) == 0
    was, now = read_native(line), read_native(line.with_name("same.json"))
    np.testing.assert_array_equal(now.channels.values, was.channels.values)


def test_a_native_animation_is_brought_to_another_frame_rate(line: Path) -> None:
    assert main(["express", str(line), "--fps", "100", "-o", str(line.with_name("fast.json"))]) == 0
    was, now = read_native(line), read_native(line.with_name("fast.json"))
    assert now.rate == FrameRate.of(100)
    every = round(100 / was.rate.fps)
    assert len(now.channels) == every * len(was.channels)
    np.testing.assert_allclose(now.channels.values[::every], was.channels.values, atol=1e-9)


def test_imported_motion_keeps_its_frames() -> None:
    track = ChannelTrack(("jawOpen",), np.linspace(0, 1, 7)[:, None], FrameRate.of(25))
    animation = imported(track, "elsewhere")
    np.testing.assert_array_equal(animation.channels.channel("jawOpen"), track.values[:, 0])
    assert animation.channels.names == channels.ALL
    assert mien.express(animation, emotion="happy").channels.channel("jawOpen").shape == (7,)


@pytest.mark.parametrize(
    ("motion", "emotion", "said"),
    [
        ("{line}", "hapy", "did you mean 'happy'"),
        ("{line}", "nowhere.csv", "nowhere.csv: no such file"),
        ("song.wav", "happy", "expected a native animation"),
        ("nowhere.json", "happy", "nowhere.json: no such file"),
    ],
)
def test_refusals(motion: str, emotion: str, said: str, line: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(line.with_name("out.csv"))
    assert said in refused(capsys, "express", motion.format(line=line), "--emotion", emotion, "-o", output)
    assert not Path(output).exists()
