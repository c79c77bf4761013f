"""What a line asks of an emotion: it opens a speaking mouth, less where the teeth must stay close."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.audio import Audio
from mien.core.emotions import emotion_table
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.motion.expression.hand_made_performance import hand_made_expression, spoken_share
from mien.motion.expression.line import Line, line_of
from mien.text.score import EmotionSpan, Score

RATE = FrameRate.of(50)
JAW = channels.ALL.index("jawOpen")


def line_with(middle: str) -> Line:
    """Half a second of silence, of a vowel, of one other phone, and of a vowel; the jaw as far open throughout."""
    phones = Tier("phones", tuple(Interval(n / 2, n / 2 + 0.5, p) for n, p in enumerate(("SIL", "AA", middle, "AA"))))
    mouth = np.zeros((100, len(channels.ALL)))
    mouth[:, JAW] = 0.3
    return line_of(Utterance("", Audio.silence(2.0, 1000), Tier("words", ()), phones, "en", "none"), (), mouth, RATE)


@pytest.mark.parametrize("phone", ["S", "Z", "SH", "ZH", "CH", "JH"])
def test_at_a_sibilant_half_of_what_is_added_is_left(phone: str) -> None:
    hissed, spoken = line_with(phone).speaking, line_with("T").speaking
    assert hissed[62] == pytest.approx(emotion_table()["line"]["sibilant"] * spoken[62])
    assert np.allclose(hissed[:46], spoken[:46])  # the vowel before it is as open as ever
    assert emotion_table()["line"]["sibilant"] < 0.8


def test_nothing_is_added_in_silence_and_more_where_the_jaw_is_open() -> None:
    assert line_with("T").speaking[:16] == pytest.approx(0.0)
    assert line_with("T").speaking[62] == pytest.approx(1.0)


@pytest.mark.parametrize("emotion", ["angry", "afraid", "happy", "surprised", "disgusted"])
def test_a_speaking_mouth_opens_more_than_a_silent_one_by_the_emotions_own_share(emotion: str) -> None:
    frames, expression = 50, hand_made_expression()
    ones, zeros = np.ones(frames), np.zeros(frames)
    silent, speaking = (
        expression.perform(Score((EmotionSpan(emotion),)), 1.0, RATE, np.random.default_rng(1), line=Line(ones, speech))
        for speech in (zeros, ones)
    )
    share = spoken_share()[emotion]
    assert np.allclose(speaking - silent, share)
    assert share[JAW] > 0.05
