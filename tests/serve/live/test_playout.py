"""An hour of live sound on a clock that runs wrong, in pieces, late, or not at all: nothing adds up."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.serve.live.playout import BEHIND, FAR_BEHIND, Playout

RATE, LOOK_AHEAD = FrameRate.of(30), 0.15
FRAME = RATE.time_of(1)


def run(arrived: Callable[[float], float], seconds: float) -> tuple[np.ndarray, np.ndarray, Playout]:
    """Instants shown and sound heard, for a source that has given ``arrived(now)`` seconds of sound until ``now``."""
    playout, inserted = Playout(RATE, LOOK_AHEAD), 0.0
    shown, heard = [], []
    for number in range(int(seconds * RATE.fps)):
        got = arrived(RATE.time_of(number)) + inserted
        showing = playout.next(got)
        inserted += showing.silence
        shown.append(showing.seconds)
        heard.append(got + showing.silence)
    return np.array(shown), np.array(heard), playout


@pytest.mark.parametrize("fast", [0.0, 50e-6, -50e-6, 1e-3, -1e-3])
@pytest.mark.parametrize("piece", [0.0, 0.01, 0.1])
def test_an_hour_on_a_sound_card_that_runs_wrong_drifts_by_less_than_a_frame(fast: float, piece: float) -> None:
    def arrived(now: float) -> float:
        true = now * (1 + fast)
        return true if not piece else np.floor(true / piece) * piece

    shown, heard, playout = run(arrived, 3600)
    delay = heard - shown
    settled = delay[len(delay) // 100 :]
    # The least that there is to spare in a second is the look-ahead, give or take a frame: at the end as at the start.
    assert abs(settled[:60].min() - settled[-60:].min()) < FRAME
    assert abs(settled[-60:].min() - LOOK_AHEAD) < FRAME
    assert settled.max() < LOOK_AHEAD + piece + FRAME
    assert playout.left_out == 0
    assert playout.silence < LOOK_AHEAD + piece + 2 * FRAME  # what the stream began with
    steps = np.diff(shown)[30:] / FRAME
    assert (steps > 0.97).all()
    assert (steps < 1.03).all()


def test_instants_never_run_backwards_whatever_the_source_does() -> None:
    random = np.random.default_rng(4)
    given = 0.0

    def arrived(now: float) -> float:
        nonlocal given
        if random.random() < 0.3:
            given += float(random.exponential(0.1))
        return given

    shown, heard, _ = run(arrived, 600)
    assert (np.diff(shown) >= 0).all()
    assert (heard - shown >= -1e-9).all()


def test_a_source_that_pauses_gets_silence_and_its_look_ahead_back() -> None:
    def arrived(now: float) -> float:  # ten seconds of sound, five of nothing, then it goes on where it stopped
        return min(now, 10.0) + max(0.0, now - 15.0)

    shown, heard, playout = run(arrived, 30)
    delay = heard - shown
    stalled = int(14 * RATE.fps)
    assert delay[stalled] == pytest.approx(0.0, abs=1e-6)  # all that came was shown
    assert np.diff(shown)[stalled] == pytest.approx(FRAME, rel=0.03)  # and the face goes on
    assert delay[-1] == pytest.approx(LOOK_AHEAD, abs=FRAME)
    assert playout.left_out == 0
    assert playout.silence == pytest.approx(5.0 + LOOK_AHEAD, abs=0.1)


@pytest.mark.parametrize("held_up", [0.3, 3.0])
def test_sound_that_was_held_up_and_comes_at_once_is_caught_up_with(held_up: float) -> None:
    def arrived(now: float) -> float:
        return now if not 10.0 < now < 10.0 + held_up else 10.0

    shown, heard, playout = run(arrived, 30)
    delay = heard - shown
    assert delay[int(16 * RATE.fps) :].max() < LOOK_AHEAD + BEHIND + FRAME
    assert (playout.left_out > 0) == (held_up > FAR_BEHIND)


def test_memory_stays_flat() -> None:
    playout = Playout(RATE, LOOK_AHEAD)
    for number in range(1000):
        playout.next(number * FRAME)
    tracemalloc.start()
    for number in range(1000, 30_000):
        playout.next(number * FRAME)
    grown = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert grown < 20_000


def test_frames_that_were_left_out_count() -> None:
    playout = Playout(RATE, LOOK_AHEAD)
    first = playout.next(10.0)
    assert playout.next(10.0, frames=4).seconds - first.seconds == pytest.approx(4 * FRAME, rel=0.6)
    with pytest.raises(InputError, match="not negative"):
        Playout(RATE, -0.1)
