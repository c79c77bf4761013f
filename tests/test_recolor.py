from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mien
from mien import channels
from mien.animation import Animation
from mien.audio import Audio
from mien.cli import main
from mien.errors import InputError
from mien.models.performers import load_performer
from mien.output.native import read_native, write_native
from mien.pipeline import perform
from mien.recolor import recolor
from mien.script.score import EmotionSpan, Score
from mien.timeline import FrameRate
from mien.tracks import ChannelTrack

from .utterances import utterance


@pytest.fixture(scope="module")
def sad() -> Animation:
    return spoken("sad")


def spoken(emotion: str) -> Animation:
    score = Score((EmotionSpan.parse(emotion),))
    return perform(
        utterance(("SIL", 0.3), ("M", 0.15), ("AA", 0.4), ("M", 0.15), ("SIL", 0.4)),
        score,
        load_performer("authored"),
        FrameRate.of(25),
        seed=3,
    )


def test_it_is_what_the_performer_would_have_done(sad: Animation) -> None:
    other, wanted = recolor(sad, "happy:0.7"), spoken("happy:0.7")
    assert np.allclose(other.channels.values, wanted.channels.values, atol=1e-9)
    assert other.score == wanted.score
    assert any("authored" in note.message for note in other.notes)


def test_there_and_back_again(sad: Animation) -> None:
    assert np.allclose(recolor(recolor(sad, "angry"), "sad").channels.values, sad.channels.values, atol=1e-9)


def test_edits_stay(sad: Animation) -> None:
    values = sad.channels.values.copy()
    wink = channels.ALL.index("cheekPuff")
    values[5, wink] += 0.3
    edited = replace(sad, channels=ChannelTrack(channels.ALL, values, sad.rate))
    other = recolor(edited, "happy")
    assert other.channels.values[5, wink] - spoken("happy").channels.values[5, wink] == pytest.approx(0.3, abs=1e-9)
    assert any("1 of" in note.message for note in other.notes)


@pytest.mark.parametrize("emotion", ["hapy", "happy:3"])
def test_slips_are_refused(sad: Animation, emotion: str) -> None:
    with pytest.raises(InputError):
        recolor(sad, emotion)


def test_a_performer_that_is_not_at_hand(sad: Animation) -> None:
    stray = replace(sad, provenance=replace(sad.provenance, performer="someone"))
    with pytest.raises(InputError, match="name one with --performer"):
        recolor(stray, "happy")
    assert recolor(stray, "happy", "authored").score.emotions[0].name == "happy"


def test_the_command(sad: Animation, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, target = tmp_path / "sad.json", tmp_path / "happy.json"
    write_native(sad, source)
    assert main(["recolor", str(source), "--to", "happy", "-o", str(target), "--also", str(tmp_path / "h.csv")]) == 0
    assert read_native(target).score.emotions[0].name == "happy"
    assert (tmp_path / "h.csv").is_file()
    assert main(["recolor", str(tmp_path / "none.json"), "--to", "happy", "-o", str(target)]) == 2
    assert mien.animate(Audio.silence(0.5, 16_000)).score.emotions == ()
