from __future__ import annotations

import numpy as np
import pytest

from mien import channels
from mien.errors import InputError
from mien.models.authored_expression import AuthoredExpression
from mien.models.authored_idle import AuthoredIdle
from mien.models.drift import smooth_drift
from mien.script.score import EmotionSpan, Score
from mien.timeline import FrameRate
from tests.utterances import utterance


def test_drift_has_its_stated_mean_spread_and_memory() -> None:
    times = np.arange(0, 2000, 0.05)
    curve = smooth_drift(times, 1.0, np.random.default_rng(3))
    assert curve.mean() == pytest.approx(0, abs=0.1)
    assert curve.std() == pytest.approx(1, abs=0.05)
    lag = np.corrcoef(curve[:-20], curve[20:])[0, 1]
    assert lag == pytest.approx(np.exp(-1), abs=0.06)


def test_drift_is_the_same_curve_at_every_frame_rate() -> None:
    slow = smooth_drift(FrameRate.of(24).times(240), 1.0, np.random.default_rng(3))
    fast = smooth_drift(FrameRate.of(48).times(480), 1.0, np.random.default_rng(3))
    assert fast[::2] == pytest.approx(slow)


def test_blinks_come_at_their_rate_and_close_the_lids() -> None:
    idle = AuthoredIdle(blinks_per_minute=20)
    line = utterance(("SIL", 600.0))
    count = len(idle.blink_times(line, np.random.default_rng(5)))
    assert 150 < count < 250
    lids = idle.perform(utterance(("SIL", 30.0)), FrameRate.of(25), np.random.default_rng(5))
    assert lids[:, channels.ALL.index("eyeBlinkLeft")].max() == pytest.approx(1.0)


def test_blinks_can_be_switched_off() -> None:
    assert AuthoredIdle(blinks_per_minute=0).blink_times(utterance(("SIL", 60.0)), np.random.default_rng(1)) == []


def test_a_blink_prefers_a_pause() -> None:
    phones = [("AA", 1.0), ("SIL", 0.4)] * 60
    line = utterance(*phones)
    pauses = np.array([p.start for p in line.phones if p.label == "SIL"])
    blinks = np.array(AuthoredIdle().blink_times(line, np.random.default_rng(2)))
    near = np.abs(blinks[:, None] - pauses[None, :]).min(axis=1) < 0.15
    assert near.mean() > 0.7


def test_an_intensity_of_zero_is_neutral_and_one_is_the_pose() -> None:
    model = AuthoredExpression()
    rate = FrameRate.of(30)

    def happy(intensity: float) -> np.ndarray:
        return model.perform(Score((EmotionSpan("happy", intensity),)), 4.0, rate, np.random.default_rng(1))

    smile = channels.ALL.index("mouthSmileLeft")
    assert not happy(0.0).any()
    full = model.pose("happy")[smile]
    assert happy(1.0)[:, smile].mean() == pytest.approx(full, rel=0.12)
    assert happy(0.5)[:, smile].mean() == pytest.approx(full / 2, rel=0.15)


def test_a_span_comes_and_goes() -> None:
    span = EmotionSpan("surprised", 1.0, start=1.0, end=2.0)
    values = AuthoredExpression().perform(Score((span,)), 3.0, FrameRate.of(20), np.random.default_rng(1))
    brow = values[:, channels.ALL.index("browInnerUp")]
    assert brow[0] == 0
    assert brow[-1] == 0
    assert brow[30] > 0.6
    assert np.abs(np.diff(brow)).max() < 0.3


def test_an_unknown_emotion_gets_a_guess() -> None:
    with pytest.raises(InputError, match="did you mean 'happy'"):
        AuthoredExpression().check(Score((EmotionSpan("hapy"),)))


@pytest.mark.parametrize(
    ("text", "words"),
    [("happy:7", "from 0 to 1"), ("happy:50", r"did you mean 0\.5"), ("happy:much", "a number from 0 to 1")],
)
def test_bad_intensities_are_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        EmotionSpan.parse(text)
