"""What the face has to show across lips and lids."""

from __future__ import annotations

import numpy as np
import pytest

from mien.capture.knowledge import knowledge
from mien.capture.openings import Seen, wanted

OPENINGS = {opening.name: opening for opening in knowledge().openings}


def test_lips_are_shut_below_the_least_distance_and_kept_above_twice_it() -> None:
    seen = Seen(OPENINGS["mouth"], np.zeros(2), 0.2, 0.75)
    goal, shut = wanted(seen, np.array([0.1, 0.75, 1.0, 1.5, 9.0]), 0.0)
    assert goal == pytest.approx([0, 0, 0.5, 1.5, 9.0])
    assert shut.tolist() == [True, True, False, False, False]


def test_a_blink_ends_shut_and_small_motion_of_lids_keeps_its_size() -> None:
    seen = Seen(OPENINGS["eye_left"], np.zeros(2), 8.0, 1.0)
    goal, shut = wanted(seen, np.array([0.9, 6.5, 8.0, 9.0]), 10.0)
    assert goal == pytest.approx([-10.0, -1.5, 0.0, 1.0])
    assert shut.tolist() == [True, False, False, False]
    falling = wanted(seen, np.linspace(1, 9, 100), 10.0)[0]
    assert (np.diff(falling) > -1e-9).all()


def test_the_width_never_shuts() -> None:
    goal, shut = wanted(Seen(OPENINGS["width"], np.zeros(2), 50.0, -np.inf), np.array([45.0, 52.0]), 0.0)
    assert goal == pytest.approx([-5.0, 2.0])
    assert not shut.any()
