"""Glances have the published statistics: sizes, ways, stays; and each sign of life can be switched alone."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mien.core import channels
from mien.core.errors import InputError
from mien.core.poses import read_table
from mien.core.timeline import FrameRate
from mien.motion.alive.gaze import HandMadeGaze, Saccade
from mien.motion.alive.idle import HandMadeIdle
from tests.utterances import utterance

TABLE = read_table("gaze.toml")
EYES = [channels.ALL.index(f"eyeLook{way}{side}") for way in ("Up", "Down", "In", "Out") for side in ("Left", "Right")]
LIDS = [channels.ALL.index(f"eyeBlink{side}") for side in ("Left", "Right")]
HEAD = [channels.ALL.index(name) for name in channels.HEAD]


@pytest.fixture(scope="module")
def long_talk() -> list[Saccade]:
    return HandMadeGaze().saccades(utterance(("AA", 4000.0)), 4000.0, np.random.default_rng(1))


def test_sizes_follow_the_published_law() -> None:
    """-6.9 ln(P / 15.7), P even in (0, 15]: the mean is 6.9 (1 + ln(15.7 / 15)) degrees, cut at 27.5."""
    gaze, random = HandMadeGaze(), np.random.default_rng(2)
    sizes = np.array([gaze._size(random) for _ in range(20_000)]) / TABLE["portrait"]["size"]
    uncut = 6.9 * (1 + np.log(15.7 / 15))
    assert sizes.mean() == pytest.approx(uncut - 6.9 * np.exp(-27.5 / 6.9) * 15.7 / 15, rel=0.02)
    assert sizes.max() == pytest.approx(27.5)
    assert sizes.min() == pytest.approx(6.9 * np.log(15.7 / 15), abs=0.02)


def test_eyes_stay_on_and_away_as_long_as_measured(long_talk: list[Saccade]) -> None:
    far = np.array([np.hypot(s.side, s.height) for s in long_talk])
    start = np.array([s.start for s in long_talk])
    large = np.flatnonzero(far[:-1] > 8)  # hardly ever a fixation
    away = start[large + 1] - start[large]
    assert np.mean(away) == pytest.approx(TABLE["talking"]["away"][0], rel=0.15)
    assert np.all(np.diff(start) > 0)


def test_eyes_of_a_listener_stay_longer(long_talk: list[Saccade]) -> None:
    quiet = HandMadeGaze().saccades(utterance(("SIL", 4000.0)), 4000.0, np.random.default_rng(1))
    share = [np.mean([np.hypot(s.side, s.height) > 5 for s in found]) for found in (long_talk, quiet)]
    assert share[1] < 0.6 * share[0]


def test_a_saccade_lasts_as_long_as_its_size_asks(long_talk: list[Saccade]) -> None:
    for before, after in pairwise(long_talk[:200]):
        size = np.hypot(after.side - before.side, after.height - before.height)
        assert after.seconds == pytest.approx(0.025 + 0.0024 * size)
        assert after.start >= before.start + before.seconds - 1e-12


def test_eyes_jump_and_hold(long_talk: list[Saccade]) -> None:
    side, _ = HandMadeGaze().directions([Saccade(1.0, 10.0, 0.0, 0.05)], np.array([0.9, 1.025, 1.05, 3.0]))
    assert side == pytest.approx([0.0, 5.0, 10.0, 10.0])


def test_the_same_glances_at_every_frame_rate() -> None:
    line = utterance(("AA", 10.0))
    slow, fast = (
        HandMadeIdle().perform(line, FrameRate.of(fps), np.random.default_rng(4)) for fps in (25, 50)
    )  # fmt: skip
    np.testing.assert_allclose(fast[::2][: len(slow)], slow, atol=1e-9)


@pytest.mark.parametrize(
    ("signs", "still"), [("gaze,sway,head", LIDS), ("blinks,sway,head", EYES), ("blinks,gaze", HEAD)]
)
def test_switching_one_sign_off_leaves_the_others_bit_for_bit(signs: str, still: list[int]) -> None:
    line, rate = utterance(("AA", 30.0)), FrameRate.of(30)
    whole = HandMadeIdle().perform(line, rate, np.random.default_rng(7))
    part = HandMadeIdle.of(signs).perform(line, rate, np.random.default_rng(7))
    assert whole[:, still].any()
    assert not part[:, still].any()
    others = [column for column in range(whole.shape[1]) if column not in still]
    np.testing.assert_array_equal(part[:, others], whole[:, others])


def test_off_and_unknown_signs() -> None:
    nothing = HandMadeIdle.of("off").perform(utterance(("AA", 5.0)), FrameRate.of(30), np.random.default_rng(1))
    assert not nothing.any()
    with pytest.raises(InputError, match="unknown sign of life 'gase': did you mean 'gaze'"):
        HandMadeIdle.of("gase")
    with pytest.raises(InputError, match="blinks per minute are 0"):
        HandMadeIdle(-1)


def test_the_option_reaches_the_performer() -> None:
    from mien.pipeline.options import prepared

    idle = prepared("hand-made", None, 30, 0, 0.5, None, "gaze")[0].idle
    assert isinstance(idle, HandMadeIdle)
    assert (idle.blinks_per_minute, idle.gaze, idle.sway, idle.head) == (0.0, True, False, False)
    with pytest.raises(InputError, match="unknown sign of life"):
        prepared("hand-made", None, 30, 0, 0.5, None, "winks")
