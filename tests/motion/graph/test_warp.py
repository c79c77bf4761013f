from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mien.motion.graph.warp import time_map, warped_rows

Floats = NDArray[np.float64]


def path_by_definition(said: Floats, recorded: Floats) -> list[tuple[int, int]]:
    """Best path of pairs of frames: a step on in both counts its distance twice, one on in either once."""
    best: dict[tuple[int, int], tuple[float, list[tuple[int, int]]]] = {}
    for i in range(len(said)):
        for j in range(len(recorded)):
            step = float(np.linalg.norm(said[i] - recorded[j]))
            ways = [(i - 1, j - 1, 2), (i - 1, j, 1), (i, j - 1, 1)]
            reached = [(best[a, b][0] + times * step, best[a, b][1]) for a, b, times in ways if (a, b) in best]
            cost, path = min(reached, key=lambda found: found[0]) if reached else (2 * step, [])
            best[i, j] = cost, [*path, (i, j)]
    return best[len(said) - 1, len(recorded) - 1][1]


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_the_kernel_and_the_definition_agree(said: int, recorded: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    one, other = random.standard_normal((said, 3)), random.standard_normal((recorded, 3))
    rows = warped_rows(one, other)
    path = path_by_definition(one, other)
    assert np.allclose(rows, [np.mean([j for i, j in path if i == row]) for row in range(said)])
    assert (np.diff(rows) >= 0).all()
    assert (rows >= 0).all()
    assert (rows <= recorded - 1).all()


def test_a_known_warp_is_found_again() -> None:
    recorded = np.stack([np.linspace(0, 4, 30), np.sin(np.linspace(0, 4, 30))], axis=1)
    under = 29 * np.linspace(0, 1, 40) ** 2
    said = np.stack([np.interp(under, np.arange(30), column) for column in recorded.T], axis=1)
    assert np.abs(warped_rows(said, recorded) - under).max() < 0.8


def test_the_map_begins_and_ends_where_the_phones_do_and_never_runs_back() -> None:
    random = np.random.default_rng(0)
    for evenness in (0.0, 0.5, 1.0):
        at, under = time_map(
            random.standard_normal((12, 9)), random.standard_normal((7, 9)), (2, 2.1), (5, 5.3), evenness
        )
        assert (at[0], at[-1], under[0], under[-1]) == (2, pytest.approx(2.1), 5, pytest.approx(5.3))
        assert (np.diff(at) > 0).all()
        assert (np.diff(under) >= 0).all()


def test_evenness_draws_towards_the_straight_line() -> None:
    said, recorded = np.repeat([[0.0], [1.0]], [9, 1], axis=0), np.repeat([[0.0], [1.0]], [1, 9], axis=0)
    bent = [
        np.abs(under - at).max()
        for at, under in (time_map(said, recorded, (0, 1), (0, 1), evenness) for evenness in (0.0, 0.5, 1.0))
    ]
    assert bent[0] > 0.5
    assert bent[1] == pytest.approx(bent[0] / 2)
    assert bent[2] == 0


def test_a_phone_without_length_and_one_without_sound_are_met_evenly() -> None:
    for said, span in ((None, (1.0, 2.0)), (np.zeros((5, 9)), (1.0, 1.0)), (np.zeros((1, 9)), (1.0, 1.2))):
        at, under = time_map(said, np.zeros((5, 9)), span, (0.0, 0.4), 0.0)
        assert at.tolist() == list(span)
        assert under.tolist() == [0.0, 0.4]
