from __future__ import annotations

import numpy as np
import pytest

from mien.motion.graph.smoothing import learned_cut_offs, low_passed

TIMES = np.arange(400) / 100


def test_a_cut_off_is_learned_for_each_component() -> None:
    waves = np.stack([np.sin(2 * np.pi * hertz * np.arange(300) / 25) for hertz in (2.0, 7.0)], axis=1)
    found = learned_cut_offs([waves[:150] + 40.0, waves[150:] - 9.0, waves[:3]], 25.0)
    assert found == pytest.approx([2.0, 7.0], abs=0.4)


def test_one_hundredth_of_the_energy_may_lie_above() -> None:
    slow, fast = (np.sin(2 * np.pi * hertz * np.arange(2000) / 50)[:, None] for hertz in (2.0, 15.0))
    assert learned_cut_offs([slow + 0.09 * fast], 50.0)[0] < 3
    assert learned_cut_offs([slow + 0.11 * fast], 50.0)[0] > 14


def test_motion_that_rests_or_is_too_short_has_no_cut_off() -> None:
    assert learned_cut_offs([np.ones((50, 2))], 25.0).tolist() == [12.5, 12.5]
    assert learned_cut_offs([np.ones((4, 2))], 25.0).tolist() == [12.5, 12.5]


def test_what_is_slow_stays_in_place_and_steps_are_rounded() -> None:
    slow = np.sin(2 * np.pi * 2 * TIMES)[:, None]
    assert np.abs(low_passed(slow, 100.0, np.array([8.0])) - slow).max() < 0.02
    step = np.where(TIMES < 2, 0.0, 1.0)[:, None]
    rounded = low_passed(step, 100.0, np.array([8.0]))
    assert np.abs(np.diff(rounded, 2, axis=0)).max() < 0.2 * np.abs(np.diff(step, 2, axis=0)).max()
    assert abs(int(np.abs(np.diff(rounded[:, 0])).argmax()) - 199) <= 1  # zero phase: where it was


@pytest.mark.parametrize("frames", [1, 3, 5, 30])
def test_short_motion_and_high_cut_offs_pass(frames: int) -> None:
    motion = np.random.default_rng(0).standard_normal((frames, 2))
    assert np.array_equal(low_passed(motion, 25.0, np.array([12.5, 40.0])), motion)
    assert np.isfinite(low_passed(motion, 25.0, np.array([3.0, 5.0]))).all()
