"""Eyes, lids and head go with what is felt, by as much as it is felt, and no head turns too fast."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.motion.alive.gaze import HandMadeGaze
from mien.motion.alive.idle import HandMadeIdle
from mien.motion.alive.manner import HEAD_SPEED, Manner, steady_head
from mien.motion.performer import Performer
from mien.pipeline.perform import perform
from mien.text.intensity import IntensityCurve
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import UNDIRECTED, EmotionSpan, Score
from tests.utterances import utterance

LINE = utterance(("AA", 400.0))
HEAD = [channels.ALL.index(name) for name in channels.HEAD]
LID = channels.ALL.index("eyeBlinkLeft")


def felt(name: str, intensity: float = 1.0) -> Score:
    return Score((EmotionSpan(name, intensity),))


def heights(score: Score) -> np.ndarray:
    found = HandMadeGaze().saccades(LINE, 400.0, np.random.default_rng(1), score)
    return np.array([s.height for s in found])


def test_sad_eyes_look_down_by_as_much_as_they_are_sad() -> None:
    usual, half, full = (heights(s).mean() for s in (UNDIRECTED, felt("sad", 0.5), felt("sad")))
    assert usual - full > 5
    assert full < half - 1 < usual - 2


def test_angry_eyes_hold_and_afraid_ones_dart() -> None:
    counts = {name: len(heights(felt(name))) for name in ("neutral", "angry", "afraid")}
    assert counts["angry"] < 0.7 * counts["neutral"] < counts["neutral"] < 0.6 * counts["afraid"]


def test_only_while_it_is_felt() -> None:
    score = Score((EmotionSpan("sad", IntensityCurve((0.0, 199.0, 200.0), (0.0, 0.0, 1.0))),))
    found = HandMadeGaze().saccades(LINE, 400.0, np.random.default_rng(1), score)
    before, after = (np.mean([s.height for s in found if (s.start < 199) == early]) for early in (True, False))
    assert after < before - 5


def test_sad_lids_are_slower_and_angry_ones_rarer() -> None:
    rate, idle = FrameRate.of(100), HandMadeIdle.of("blinks")
    closed = {}
    for name in ("neutral", "sad", "angry"):
        lids = idle.perform(LINE, rate, np.random.default_rng(3), felt(name))[:, LID]
        count = int(((lids[1:] >= 0.99) & (lids[:-1] < 0.99)).sum())
        closed[name] = count, (lids > 0.05).sum() / rate.fps / count
    assert closed["sad"][1] > 1.5 * closed["neutral"][1]
    assert closed["angry"][0] < 0.7 * closed["neutral"][0]


def test_an_angry_head_moves_more_a_sad_one_less_and_contempt_tilts() -> None:
    rate, idle = FrameRate.of(25), HandMadeIdle.of("sway")
    moved = {
        name: idle.perform(LINE, rate, np.random.default_rng(3), felt(name))[:, HEAD]
        for name in ("neutral", "sad", "angry", "contempt")
    }
    speed = {name: np.abs(np.diff(curve, axis=0)).mean(axis=0) * 25 for name, curve in moved.items()}
    assert (speed["angry"] / speed["neutral"])[[0, 2]] == pytest.approx([1.75, 2.7], rel=0.01)
    assert (speed["sad"] < 0.75 * speed["neutral"]).all()
    roll = channels.HEAD.index("headRoll")
    assert (moved["contempt"] - moved["neutral"])[:, roll].mean() == pytest.approx(4.0, abs=0.3)


def test_without_emotion_and_for_one_without_figures_it_is_the_usual_manner() -> None:
    for score in (UNDIRECTED, felt("neutral"), felt("bored")):
        manner = Manner(score, 3.0)
        assert manner.is_usual
        assert manner.at("blinks", 1.0) == 1.0
        assert manner.over("down", np.array([0.0, 1.0])).tolist() == [0.0, 0.0]


def test_signs_that_are_switched_off_stay_off_whatever_is_felt() -> None:
    nothing = HandMadeIdle.of("off").perform(LINE, FrameRate.of(25), np.random.default_rng(1), felt("contempt"))
    assert not nothing.any()


def test_a_fast_head_is_slowed_without_lag_and_a_slow_one_left_alone() -> None:
    times = np.arange(0, 4, 0.02)
    fast = np.stack([20 * np.sin(8 * times), 0 * times, 3 * np.sin(times)], axis=1)
    slow = fast / 10
    assert np.array_equal(steady_head(slow, 50), slow)
    steady = steady_head(fast, 50)
    assert (np.linalg.norm(np.diff(steady, axis=0), axis=1) * 50).max() <= HEAD_SPEED + 1e-9
    lags = [np.sum(np.roll(fast[:, 0], k) * steady[:, 0]) for k in range(-15, 16)]
    assert abs(int(np.argmax(lags)) - 15) <= 1


@pytest.mark.parametrize("emotion", ["angry", "happy", "afraid"])
def test_no_step_of_the_head_in_a_performance(emotion: str, spoken_line: Utterance) -> None:
    moved = perform(spoken_line, felt(emotion), Performer.hand_made(), FrameRate.of(30), seed=4)
    turns = np.linalg.norm(np.diff(moved.channels.values[:, HEAD], axis=0), axis=1) * 30
    assert 1 < turns.max() <= 50


def test_a_head_that_is_commanded_may_turn_as_fast_as_it_is_told() -> None:
    turn = ParameterCurve("HeadTurn", ((500.0, 0.0), (700.0, 0.7)), "linear", "set")
    line = utterance(("AA", 2.0))
    moved = perform(line, Score((), (turn,)), Performer.hand_made(), FrameRate.of(30))
    yaw = moved.channels.values[:, channels.ALL.index("headYaw")]
    assert np.abs(np.diff(yaw)).max() * 30 > 100


@pytest.fixture(scope="module")
def spoken_line() -> Utterance:
    """A voice whose pitch and level go up and down a good deal."""
    from dataclasses import replace

    from mien.core.audio import Audio

    line = utterance(("AA", 1.0), ("M", 0.5), ("IY", 1.0), ("SIL", 0.5), ("AA", 1.0))
    times = np.arange(round(line.duration * 16_000)) / 16_000
    pitch = 160 + 60 * np.sin(2 * np.pi * 1.7 * times)
    level = 0.05 + 0.3 * (np.sin(2 * np.pi * 3 * times) > 0)
    wave = np.sign(np.sin(2 * np.pi * np.cumsum(pitch) / 16_000)) * level
    return replace(line, audio=Audio(wave, 16_000))
