"""The emotion that is heard in a live voice: the same for any cut of the sound, soft, and neutral in silence."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.emotion.emotion_classifier import EmotionClassifier, EmotionReading, default_classifier
from mien.motion.expression.hand_made_performance import hand_made_expression
from mien.serve.live.animator import LiveSettings
from mien.serve.live.heard_emotion import HeardEmotion, HeardExpression
from mien.speech.streaming_features import RATE
from mien.text.score import EmotionSpan, Score


class Angry:
    """A reader that finds anger in every voice."""

    emotions, usual_ = ("angry", "neutral"), default_classifier().usual_
    from_neutral_ = np.zeros(len(default_classifier().usual_))

    def probabilities(self, features: np.ndarray, baseline: np.ndarray) -> np.ndarray:
        return np.tile([0.9, 0.1], (len(features), 1))

    def activations(self, features: np.ndarray, baseline: np.ndarray) -> np.ndarray:
        return np.ones(len(features))

    def reading(self, probabilities: np.ndarray, activation: np.ndarray, spoken: float) -> EmotionReading:
        return EmotionReading({"angry": 0.9, "neutral": 0.1}, 0.5, 1.0, spoken)


def voice(seconds: float) -> np.ndarray:
    times = np.arange(round(seconds * RATE)) / RATE
    return np.asarray(0.2 * np.sign(np.sin(2 * np.pi * 150 * times)) * np.sin(2 * np.pi * 3 * times) ** 2)


def course(block: float, sound: np.ndarray) -> list[tuple[float, str]]:
    """What is asked for at each half second, heard in blocks of so many seconds."""
    heard, found = HeardEmotion(cast(EmotionClassifier, Angry())), []
    for start in range(0, len(sound), round(block * RATE)):
        heard.hear(sound[start : start + round(block * RATE)])
        if (start + round(block * RATE)) % (RATE // 2) == 0:
            found.append(((start + round(block * RATE)) / RATE, heard.asked[0]))
    return found


def test_any_cut_of_the_sound_gives_the_same_readings_and_silence_is_neutral() -> None:
    sound = np.concatenate([voice(2.0), np.zeros(4 * RATE)])
    small, large = course(0.02, sound), course(0.5, sound)
    assert small == large
    assert [emotion for _, emotion in large][:2] == ["neutral", "angry"]  # half a second after it was heard
    assert large[-1][1] == "neutral"


def test_the_face_comes_to_it_softly() -> None:
    heard = HeardEmotion(cast(EmotionClassifier, Angry()))
    face = HeardExpression(hand_made_expression(), FrameRate.of(25), np.random.default_rng(1), heard)
    brow = channels.ALL.index("browDownLeft")
    calm = [face.next()[brow] for _ in range(25)]
    heard.asked = ("angry", 1.0)
    angry = [face.next()[brow] for _ in range(50)]
    assert max(calm) < 0.3 < min(angry[25:])
    assert np.abs(np.diff([calm[-1], *angry])).max() < 0.15


def test_one_that_is_heard_and_one_that_is_named_are_not_both_shown() -> None:
    with pytest.raises(InputError, match="not both"):
        LiveSettings(score=Score((EmotionSpan("sad"),)), hear_emotion=True)
