from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mien
from mien.animation.animation import Animation
from mien.api.recoloring import recolor, recolor_markers, recolor_take
from mien.capture.layouts import load_layout
from mien.cli import main
from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.recordings import Corpus
from mien.formats.native import read_native, write_native
from mien.motion.performer import Performer
from mien.motion.performer_file import save_learned
from mien.motion.performers import load_learned_performer, load_performer
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score
from tests.motion.expressive_takes import emotion_maps, take
from tests.utterances import utterance


@pytest.fixture(scope="module")
def sad() -> Animation:
    return spoken("sad")


def spoken(emotion: str) -> Animation:
    score = Score((EmotionSpan.parse(emotion),))
    return perform(
        utterance(("SIL", 0.3), ("M", 0.15), ("AA", 0.4), ("M", 0.15), ("SIL", 0.4)),
        score,
        load_performer("hand-made"),
        FrameRate.of(25),
        seed=3,
    )


def test_it_is_what_the_performer_would_have_done(sad: Animation) -> None:
    other, wanted = recolor(sad, "happy:0.7"), spoken("happy:0.7")
    assert np.allclose(other.channels.values, wanted.channels.values, atol=1e-9)
    assert other.score == wanted.score
    assert any("hand-made" in note.message for note in other.notes)


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


def test_motion_from_elsewhere_is_not_called_edited(sad: Animation, tmp_path: Path) -> None:
    mien.save(sad, tmp_path / "sad.csv")
    other = recolor(mien.load(tmp_path / "sad.csv"), "happy", "default")  # type: ignore[arg-type]
    assert not any("edited" in note.message for note in other.notes)


@pytest.mark.parametrize("emotion", ["hapy", "happy:3"])
def test_slips_are_refused(sad: Animation, emotion: str) -> None:
    with pytest.raises(InputError):
        recolor(sad, emotion)


def test_a_performer_that_is_not_at_hand(sad: Animation) -> None:
    stray = replace(sad, provenance=replace(sad.provenance, performer="someone"))
    with pytest.raises(InputError, match="name one with --performer"):
        recolor(stray, "happy")
    assert recolor(stray, "happy", "hand-made").score.emotions[0].name == "happy"


def test_the_command(sad: Animation, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, target = tmp_path / "sad.json", tmp_path / "happy.json"
    write_native(sad, source)
    assert main(["recolor", str(source), "--to", "happy", "-o", str(target), "--also", str(tmp_path / "h.csv")]) == 0
    assert read_native(target).score.emotions[0].name == "happy"
    assert (tmp_path / "h.csv").is_file()
    assert main(["recolor", str(tmp_path / "none.json"), "--to", "happy", "-o", str(target)]) == 2
    assert mien.animate(Audio.silence(0.5, 16_000)).score.emotions == ()


BROW = load_layout("mediapipe-218").landmarks[55]


@cache
def performer() -> Performer:
    return replace(load_performer("hand-made"), name="someone", emotion_maps=emotion_maps())


def column(animation: Animation, name: str) -> NDArray[np.float64]:
    return animation.channels.select((name,)).values[:, 0]


def test_a_learned_map_changes_an_animation() -> None:
    plain = spoken("neutral")
    happy = recolor(plain, "happy", performer())
    half = recolor(plain, "happy:0.5", performer())
    rise = column(happy, "mouthSmileLeft").mean() - column(plain, "mouthSmileLeft").mean()
    assert 0.3 < rise < 0.7  # the recordings held it at 0.5
    assert 0.3 < (column(half, "mouthSmileLeft") - column(plain, "mouthSmileLeft")).mean() / rise < 0.7
    assert abs(column(happy, "browInnerUp") - column(plain, "browInnerUp")).mean() < 0.1
    assert any("learned from recordings: neutral to happy (4 sentences)" in note.message for note in happy.notes)
    hand_made = recolor(plain, "happy", performer(), "hand-made")
    assert any("is hand-made" in note.message for note in hand_made.notes)
    assert np.array_equal(happy.channels.values, recolor(plain, "happy", performer()).channels.values)


def test_an_emotion_of_the_animation_goes_before_the_learned_one_comes(sad: Animation) -> None:
    other, wanted = recolor(sad, "happy", performer()), recolor(spoken("neutral"), "happy", performer())
    assert other.score.emotions == (EmotionSpan("happy"),)
    assert np.allclose(other.channels.values, wanted.channels.values, atol=1e-6)


def test_a_take_comes_near_to_what_was_recorded() -> None:
    neutral, happy = (take(9, emotion, 0.0) for emotion in ("neutral", "happy"))
    made = recolor_take(neutral, "happy", performer())
    assert made.markers is not None
    real = happy.markers.positions
    apart = [np.sqrt(((m - real) ** 2).sum(axis=2).mean()) for m in (neutral.markers.positions, made.markers.positions)]
    assert apart[1] < 0.5 * apart[0]
    assert 0.3 < column(made, "mouthSmileLeft").mean() < 0.7
    assert column(made, "jawOpen").max() > 0.2
    with pytest.raises(InputError, match="no map from 'neutral' to 'angry'"):
        recolor_take(neutral, "angry", performer(), "learned")
    laid = recolor_take(neutral, "angry", "hand-made")
    assert any("'angry' is hand-made" in note.message for note in laid.notes)
    assert laid.markers is not None
    lowered = (laid.markers.positions - neutral.markers.positions)[:, neutral.markers.names.index(BROW), 1]
    assert lowered.mean() < -1.0
    assert any("stays in it" in note.message for note in recolor_take(happy, "angry", "hand-made").notes)


def test_bare_markers_change_wherever_the_head_is() -> None:
    track = take(9, "neutral", 0.0).markers
    made = recolor_markers(track, "happy", performer())
    angle = np.linspace(0, 0.5, len(track))
    turns = np.stack([[[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in angle])
    moved = MarkerTrack(track.names, 1.1 * np.einsum("tij,tmj->tmi", turns, track.positions) + 30.0, track.rate)
    other = recolor_markers(moved, "happy", performer())
    back = np.einsum("tji,tmj->tmi", turns, (other.positions - 30.0) / 1.1)
    assert np.abs(back - made.positions).max() < 0.05
    with pytest.raises(InputError, match="lacks 2 of the 218 markers"):
        recolor_markers(MarkerTrack(track.names[2:], track.positions[:, 2:], track.rate), "happy", performer())
    with pytest.raises(InputError, match="it has: none"):
        recolor_markers(track, "happy", "hand-made")


def test_the_command_on_takes_and_markers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    learned = replace(load_learned_performer("default"), emotion_maps=performer().emotion_maps)
    save_learned(learned, tmp_path / "someone.mien")
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218"})
    corpus.add(take(9, "neutral", 0.0))
    by = ["--to", "happy:0.8", "--performer", str(tmp_path / "someone.mien")]
    made = [str(tmp_path / name) for name in ("take.json", "take.npz", "again.markers.csv")]
    assert (
        main(["recolor", str(tmp_path / "corpus"), "--take", "s9-neutral", *by, "-o", made[0], "--also", made[1]]) == 0
    )
    assert main(["recolor", made[1], "--from", "happy", "--to", "neutral", *by[2:], "-o", made[2]]) == 0
    with np.load(made[1]) as file:
        assert np.allclose(file["markers"], read_native(made[0]).markers.positions)
    assert main(["recolor", str(tmp_path / "corpus"), *by, "-o", made[0]]) == 2
    assert "which take" in capsys.readouterr().err
    assert main(["recolor", made[2], *by, "-o", made[2]]) == 2
    assert (
        main(["recolor", made[0], "--way", "learned", "--to", "angry", "--performer", "hand-made", "-o", "x.json"]) == 2
    )
    assert "has no map from 'neutral' to 'angry'" in capsys.readouterr().err
