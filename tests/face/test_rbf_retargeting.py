"""Regression on radial basis functions: exact on straight lines, bounded, and honest about what it is given."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.face.rbf_retargeting import RbfRetargeter, sampled_pairs, steadied
from mien.face.retargeting_report import ambiguous_channels, residual_by_region

BASIS = np.random.default_rng(2).normal(0, 3, (5, 8, 3))


def test_straight_lines_come_back_exactly_even_between_and_beyond_the_examples() -> None:
    learned = RbfRetargeter(steadiness=0.0).fit(*sampled_pairs(BASIS, 80, np.random.default_rng(0)))
    weights = np.random.default_rng(1).uniform(0, 1, (50, 5))
    got = learned.predict(np.einsum("pc,cmk->pmk", weights, BASIS))
    np.testing.assert_allclose(got, weights, atol=1e-6)


def test_the_system_is_solved_as_it_is_written() -> None:
    shown, wanted = sampled_pairs(BASIS, 10, np.random.default_rng(0))
    learned = RbfRetargeter(kernel="gaussian", variance=1.0, ridge=1e-3).fit(shown, wanted)
    numbers = (shown.reshape(len(shown), -1) - learned.mean_) @ learned.axes_.T
    design = np.array(
        [[np.exp(-np.sum((a - b) ** 2) / (2 * learned.width_**2)) for b in learned.centres_] for a in numbers]
    )
    left = (design.T @ design + 1e-3 * np.eye(len(design))) @ learned.coefficients_
    np.testing.assert_allclose(left, design.T @ wanted, atol=1e-8)
    np.testing.assert_allclose(learned.predict(shown), np.clip(design @ learned.coefficients_, 0, 1), atol=1e-9)


def test_curved_pairs_are_met_at_the_examples() -> None:
    random = np.random.default_rng(3)
    shown = random.normal(0, 4, (40, 3, 3))
    wanted = 0.5 + 0.4 * np.sin(shown[:, :2, 0] / 3)
    learned = RbfRetargeter(variance=1.0, ridge=0.0).fit(shown, wanted)
    np.testing.assert_allclose(learned.predict(shown), wanted, atol=1e-6)


@given(st.integers(0, 1000), st.sampled_from(["linear", "gaussian"]))
def test_answers_stay_in_bounds(seed: int, kernel: str) -> None:
    random = np.random.default_rng(seed)
    learned = RbfRetargeter(kernel=kernel).fit(random.normal(0, 5, (6, 2, 3)), random.uniform(0, 1, (6, 2)))
    got = learned.solve(random.normal(0, 500, (7, 2, 3)))
    assert np.isfinite(got).all()
    assert got.min() >= 0.0
    assert got.max() <= 1.0


def test_steadying_is_the_solution_of_its_equation() -> None:
    values = np.random.default_rng(1).uniform(0, 1, (9, 2))
    difference = np.diff(np.eye(9), axis=0)
    expected = np.linalg.solve(np.eye(9) + 0.7 * difference.T @ difference, values)
    np.testing.assert_allclose(steadied(values, 0.7), expected)


def test_same_seed_same_pairs() -> None:
    one, other = (sampled_pairs(BASIS, 20, np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(one[0], other[0])
    assert len(one[1]) == 1 + 4 * 5 + 20
    assert not one[1][0].any()


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InputError, match="kernel"):
        RbfRetargeter(kernel="cubic")
    with pytest.raises(InputError, match="variance"):
        RbfRetargeter(variance=0.0)
    with pytest.raises(InputError, match="expected"):
        RbfRetargeter().fit(np.zeros((3, 2, 3)), np.zeros((2, 1)))
    with pytest.raises(InputError, match="from 0 to 1"):
        RbfRetargeter().fit(np.ones((2, 2, 3)), [[0.0], [1.5]])
    with pytest.raises(InputError, match="same displacements"):
        RbfRetargeter().fit(np.ones((3, 2, 3)), np.zeros((3, 1)))
    learned = RbfRetargeter().fit(*sampled_pairs(BASIS, 5, np.random.default_rng(0)))
    with pytest.raises(InputError, match="8 markers"):
        learned.predict(np.zeros((2, 3, 3)))
    asked = np.zeros((2, 8, 3))
    asked[1, 4, 0] = np.inf
    with pytest.raises(InputError, match="frame 1, marker 4"):
        learned.predict(asked)


def test_residuals_by_region_and_ambiguous_shapes() -> None:
    asked = np.zeros((4, 3, 3))
    asked[:, 0, 0], asked[:, 2, 2] = 3.0, 1.0
    brow, mouth = residual_by_region(
        asked, np.zeros_like(asked), ["a", "b", "c"], {"brow": ["a", "b"], "mouth": ["c", "x"]}
    )
    assert (brow.worst, brow.markers, mouth.markers) == ("a", 2, 1)
    assert brow.missed == pytest.approx(3 / np.sqrt(2))
    assert "sideways" in brow.line()
    assert "in depth" in mouth.line()
    basis = np.concatenate([BASIS, BASIS[:1] + np.random.default_rng(5).normal(0, 0.05, (1, 8, 3))])
    (first, twin) = ambiguous_channels(basis, ["v", "w", "x", "y", "z", "v again"])
    assert (first.channel, twin.channel) == ("v", "v again")
    assert first.stand_ins == ("v again",)
