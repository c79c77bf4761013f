from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.timeline import FrameRate
from mien.motion.alive.idle import HandMadeIdle
from mien.motion.drift import smooth_drift
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
    idle = HandMadeIdle(blinks_per_minute=20)
    line = utterance(("SIL", 600.0))
    count = len(idle.blink_times(line, np.random.default_rng(5)))
    assert 150 < count < 250
    lids = idle.perform(utterance(("SIL", 30.0)), FrameRate.of(25), np.random.default_rng(5))
    assert lids[:, channels.ALL.index("eyeBlinkLeft")].max() == pytest.approx(1.0)


def test_blinks_can_be_switched_off() -> None:
    assert HandMadeIdle(blinks_per_minute=0).blink_times(utterance(("SIL", 60.0)), np.random.default_rng(1)) == []


def test_a_blink_prefers_a_pause() -> None:
    phones = [("AA", 1.0), ("SIL", 0.4)] * 60
    line = utterance(*phones)
    pauses = np.array([p.start for p in line.phones if p.label == "SIL"])
    blinks = np.array(HandMadeIdle().blink_times(line, np.random.default_rng(2)))
    near = np.abs(blinks[:, None] - pauses[None, :]).min(axis=1) < 0.15
    assert near.mean() > 0.7
