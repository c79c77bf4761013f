from __future__ import annotations

import numpy as np
import pytest

import mien
from mien.core import channels
from mien.core.emotions import emotion_table
from mien.core.timeline import FrameRate
from mien.motion.performer import Performer
from mien.pipeline.perform import blend, perform
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan, Score
from tests.utterances import utterance

LINE = utterance(("SIL", 0.3), ("M", 0.1), ("AA", 0.2), ("P", 0.08), ("IY", 0.2), ("F", 0.1), ("AO", 0.2), ("SIL", 2.0))
PERFORMER = Performer.hand_made()
EMOTIONS = PERFORMER.expression.names  # type: ignore[attr-defined]


def test_the_animation_covers_the_sound_with_every_channel() -> None:
    animation = perform(LINE, Score(), PERFORMER, FrameRate.of(25))
    assert animation.channels.names == channels.ALL
    assert len(animation.channels) == FrameRate.of(25).frames_covering(LINE.duration)


def test_the_same_seed_gives_the_same_bits_and_another_seed_does_not() -> None:
    score = Score((EmotionSpan("sad", 0.5),))
    one, again, other = (perform(LINE, score, PERFORMER, FrameRate.of(30), seed) for seed in (1, 1, 2))
    assert one == again
    assert one.channels != other.channels


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_weights_stay_in_range_under_every_emotion(emotion: str) -> None:
    values = perform(LINE, Score((EmotionSpan(emotion),)), PERFORMER, FrameRate.of(30)).channels
    weights = values.select(channels.WEIGHTS).values
    assert weights.min() >= 0
    assert weights.max() <= 1


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_the_jaw_is_as_closed_on_p_under_every_emotion_as_without(emotion: str) -> None:
    rate = FrameRate.of(50)
    plain = perform(LINE, Score(), PERFORMER, rate).channels
    felt = perform(LINE, Score((EmotionSpan(emotion),)), PERFORMER, rate).channels
    middle_of_p = rate.nearest_frame(0.64)
    for name in ("jawOpen", "mouthUpperUpLeft", "mouthLowerDownRight", "mouthFunnel"):
        assert felt.channel(name)[middle_of_p] <= plain.channel(name)[middle_of_p] + 1e-9


def test_a_blink_shuts_the_lids_whatever_the_expression_says() -> None:
    count = len(channels.ALL)
    mouth, expression, idle = np.zeros((1, count)), np.zeros((1, count)), np.zeros((1, count))
    expression[0, [channels.ALL.index("eyeWideLeft"), channels.ALL.index("eyeSquintLeft")]] = 0.7
    expression[0, channels.ALL.index("eyeBlinkLeft")] = 0.2
    idle[0, [channels.ALL.index("eyeBlinkLeft"), channels.ALL.index("eyeBlinkRight")]] = 1.0
    values = blend(mouth, expression, idle)[0]
    assert values[channels.ALL.index("eyeBlinkLeft")] == 1.0
    assert values[channels.ALL.index("eyeWideLeft")] == 0.0
    assert values[channels.ALL.index("eyeSquintLeft")] == 0.0


def test_silence_is_alive() -> None:
    animation = perform(utterance(("SIL", 12.0)), Score(), PERFORMER, FrameRate.of(25))
    assert animation.channels.channel("eyeBlinkLeft").max() > 0.99
    assert animation.channels.channel("headYaw").std() > 0.3
    assert not animation.channels.channel("jawOpen").any()


def test_a_curve_is_laid_over_the_motion() -> None:
    rate = FrameRate.of(50)
    plain = perform(LINE, Score(), PERFORMER, rate).channels
    curve = ParameterCurve("HeadNod", ((500, 0), (700, 0.1), (900, 0)))
    nodding = perform(LINE, Score(curves=(curve,)), PERFORMER, rate).channels
    difference = nodding.values - plain.values
    assert difference[rate.nearest_frame(0.7), channels.ALL.index("headPitch")] == pytest.approx(-6)
    moved = np.flatnonzero(np.abs(difference).max(axis=0) > 1e-12)
    assert [channels.ALL[column] for column in moved] == ["headPitch"]


def test_an_added_curve_leaves_closures_shut_and_a_set_one_is_exact() -> None:
    rate, middle_of_p = FrameRate.of(50), FrameRate.of(50).nearest_frame(0.64)
    plain = perform(LINE, Score(), PERFORMER, rate).channels.channel("jawOpen")
    keys = ((0.0, 0.6), (1000.0, 0.6))
    added = perform(LINE, Score(curves=(ParameterCurve("jawOpen", keys),)), PERFORMER, rate).channels.channel("jawOpen")
    assert added[middle_of_p] <= plain[middle_of_p] + 1e-9
    assert added.max() > plain.max() + 0.2
    exact = perform(LINE, Score(curves=(ParameterCurve("jawOpen", keys, mode="set"),)), PERFORMER, rate)
    assert (exact.channels.channel("jawOpen")[:51] == 0.6).all()


def test_an_emotion_after_the_line_is_reported() -> None:
    animation = mien.say("Yes.", emotion="happy[50-60]")
    assert any("happy was asked for from 50 s" in note.message for note in animation.notes)
    assert not any("was asked for from" in note.message for note in mien.say("Yes.", emotion="happy").notes)


def test_neutral_over_finished_motion_is_said_to_change_nothing() -> None:
    animation = mien.say("Yes.")
    laid = mien.express(animation, emotion="neutral")
    assert any("neutral changes nothing" in note.message for note in laid.notes)
    assert np.array_equal(laid.channels.values, animation.channels.values)


def test_a_smile_gives_way_to_rounded_lips_and_nothing_else_does() -> None:
    table = emotion_table()["rounded"]
    mouth, expression = np.zeros((2, len(channels.ALL))), np.full((2, len(channels.ALL)), 0.5)
    mouth[1, channels.ALL.index("mouthPucker")] = 0.8
    spread, rounded = blend(mouth, expression, np.zeros_like(mouth))
    smile, brow = channels.ALL.index("mouthSmileLeft"), channels.ALL.index("browInnerUp")
    assert spread[smile] == 0.5
    assert rounded[smile] == pytest.approx(0.5 * (1 - 0.8 * table["gives_way"]))
    assert rounded[brow] == 0.5
    assert table["gives_way"] >= 0.4
    assert {f"mouth{muscle}{side}" for muscle in ("Smile", "Stretch") for side in ("Left", "Right")} <= set(
        table["channels"]
    )
