"""The mouth frame by frame: with all phones known it is the offline mouth; revised phones make no jump."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.motion.expression.endless_motion import BLOCK, EndlessMotion, endless_expression, endless_idle
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.mouth.streaming_mouth import StreamingMouth, expected, without_sound
from mien.motion.performer import MouthModel, Performer
from mien.motion.performers import load_performer
from mien.text.score import Score

RATE = FrameRate.of(30)
SAID = ["SIL", "M", "AA", "T", "AH", "B", "IY", "K", "S", "AH", "N", "D", "IH", "P", "EH", "SIL"]
PHONES = Tier("phones", tuple(Interval(0.1 * i, 0.1 * i + 0.1, label) for i, label in enumerate(SAID)))
END = PHONES.intervals[-1].end
MOUTH = [channels.ALL.index(name) for name in channels.MOUTH]


def known_until(end: float) -> Tier:
    return Tier("phones", tuple(Interval(p.start, min(p.end, end), p.label) for p in PHONES if p.start < end))


def offline(mouth: MouthModel) -> np.ndarray:
    sound = Audio.silence(END, 16000)
    return mouth.perform(Utterance("", sound, Tier("words", ()), PHONES, "en-US", "aligned"), RATE).values


@pytest.fixture(scope="module", params=["hand-made", "default"])
def mouth(request: pytest.FixtureRequest) -> MouthModel:
    return without_sound(load_performer(request.param).mouth)


def test_the_longer_the_look_ahead_the_nearer_the_offline_mouth(mouth: MouthModel) -> None:
    wanted = offline(mouth)
    missed = []
    for look_ahead in (0.05, 0.15, 0.3, 2.0):
        streaming = StreamingMouth(mouth, RATE)
        times = RATE.times(len(wanted))
        found = np.array([streaming.frame(t, known_until(t + look_ahead))[0] for t in times])
        missed.append(float(np.sqrt(((found - wanted)[:, MOUTH] ** 2).mean())))
    assert missed == sorted(missed, reverse=True)
    assert missed[1] < 0.05
    assert missed[-1] < 0.02


def test_lips_shut_on_a_bilabial_that_is_known_only_just_before(mouth: MouthModel) -> None:
    streaming = StreamingMouth(mouth, RATE)
    seals = [streaming.frame(t, known_until(t + 0.1))[1] for t in RATE.times(45)]
    for middle in (0.15, 0.55, 1.35):
        assert max(seals[int((middle - 0.04) * 30) : int((middle + 0.08) * 30)]) > 0.9


def test_revised_phones_are_handed_over_without_a_jump() -> None:
    streaming, steady = StreamingMouth(HandMadeMouth(), RATE), StreamingMouth(HandMadeMouth(), RATE)
    wide, shut = (Tier("phones", (Interval(0.0, 2.0, label),)) for label in ("AA", PAUSE))
    values = [streaming.frame(t, wide if t < 0.5 else shut)[0] for t in RATE.times(30)]
    jump = np.abs(np.diff(values, axis=0)).max(axis=1)
    whole = np.abs(steady.frame(0.4, wide)[0] - StreamingMouth(HandMadeMouth(), RATE).frame(0.4, shut)[0]).max()
    assert jump.max() < 0.75 * whole
    assert np.abs(values[-1]).max() < 0.05


def test_time_may_stand_still_and_leap(mouth: MouthModel) -> None:
    streaming = StreamingMouth(mouth, RATE)
    for seconds in (0.0, 0.0, 0.1, 0.1, 1.2, 1.21):
        values, seal = streaming.frame(seconds, PHONES)
        assert np.isfinite(values).all()
        assert 0 <= seal <= 1


def test_what_is_expected_follows_what_is_known() -> None:
    assert expected(Tier("phones", ())) == Tier("phones", ())
    for label in ("AA", "M", PAUSE):
        found = expected(Tier("phones", (Interval(0.0, 0.02, label),)))
        assert found.intervals[0].label == label
        assert found.intervals[-1].end > 0.3


def test_endless_motion_goes_on_without_a_jump_and_blinks_shut() -> None:
    random = np.random.default_rng(3)
    motion = endless_idle(Performer.hand_made().idle, RATE, random)
    frames = np.array([motion.next() for _ in range(int(10 * BLOCK * 30))])
    head = frames[:, [channels.ALL.index(name) for name in channels.HEAD]]
    assert np.abs(np.diff(head, axis=0)).max() < 0.6  # degrees in a frame
    lids = frames[:, channels.ALL.index("eyeBlinkLeft")]
    peaks = lids[1:-1][(lids[1:-1] > 0.1) & (lids[1:-1] >= lids[:-2]) & (lids[1:-1] > lids[2:])]
    assert len(peaks) > 10
    assert (peaks > 0.95).all()


def test_endless_motion_is_the_same_for_the_same_seed() -> None:
    performer = Performer.hand_made()
    one, other = (endless_expression(performer.expression, Score(), RATE, np.random.default_rng(5)) for _ in range(2))
    for _ in range(900):
        np.testing.assert_array_equal(one.next(), other.next())


def test_stretches_take_over_on_a_half_cosine() -> None:
    made = iter(range(10))

    def make(duration: float, random: np.random.Generator) -> np.ndarray:
        return np.full((RATE.frames_covering(duration), len(channels.ALL)), float(next(made)))

    motion = EndlessMotion(make, RATE, np.random.default_rng(0))
    curve = np.array([motion.next()[MOUTH[0]] for _ in range(700)])
    assert (np.diff(curve) >= 0).all()
    assert curve[-1] == 2.0 or curve[-1] == 1.0
    assert np.diff(curve).max() < 0.1
