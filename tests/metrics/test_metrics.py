"""Distance, trajectories, published measures and jitter on known answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.metrics.distance import marker_rms
from mien.metrics.published import lip_vertex_error, mouth_opening_difference, upper_face_dynamics_deviation
from mien.metrics.track_jitter import jitter
from mien.metrics.trajectory import correlation, correlation_of, moments, rms_error, separation, velocity


def test_rms_is_the_root_of_the_mean_squared_distance() -> None:
    recorded, synthesised = np.zeros((2, 2, 3)), np.zeros((2, 2, 3))
    synthesised[0, 0] = (3.0, 4.0, 0.0)  # 25 mm² in one of four: root of 6.25
    assert marker_rms(recorded, synthesised) == 2.5


@pytest.mark.parametrize(
    ("one", "other", "reason"),
    [
        (np.zeros((2, 2, 3)), np.zeros((3, 2, 3)), "one shape"),
        (np.zeros((0, 2, 3)), np.zeros((0, 2, 3)), "at least one frame"),
        (np.zeros((2, 2, 2)), np.zeros((2, 2, 2)), "one shape"),
        (np.zeros((2, 2, 3)), np.full((2, 2, 3), np.nan), "synthesised positions: not finite in 2 frames"),
    ],
)
def test_positions_that_cannot_be_compared_are_refused(one: np.ndarray, other: np.ndarray, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        marker_rms(one, other)


@given(st.integers(3, 60), st.integers(0, 10_000))
def test_correlation_agrees_with_numpy(number: int, seed: int) -> None:
    one, other = np.random.default_rng(seed).normal(8.0, 3.0, (2, number))
    assert correlation(one, other) == pytest.approx(np.corrcoef(one, other)[0, 1], abs=1e-9)
    assert rms_error(one, other) == pytest.approx(np.sqrt(((one - other) ** 2).mean()), rel=1e-9)


def test_moments_of_parts_add_up_to_those_of_the_whole() -> None:
    one, other = np.random.default_rng(3).normal(0, 1, (2, 50))
    added = moments(one[:20], other[:20]) + moments(one[20:], other[20:])
    assert correlation_of(added) == pytest.approx(correlation(one, other), rel=1e-12)


def test_a_still_curve_has_no_correlation() -> None:
    assert np.isnan(correlation(np.arange(5.0), np.full(5, 7.1)))


def test_curves_that_cannot_be_compared_are_refused() -> None:
    with pytest.raises(InputError, match="one length"):
        correlation(np.zeros(3), np.zeros(4))
    with pytest.raises(InputError, match="finite"):
        rms_error(np.array([np.nan]), np.array([1.0]))


def test_velocity_is_the_step_to_the_next_frame() -> None:
    assert velocity(np.array([0.0, 2.0, 2.0, 1.0]), 25.0).tolist() == [50.0, 0.0, -25.0, -25.0]
    assert velocity(np.array([4.0]), 25.0).tolist() == [0.0]


def test_separation_is_three_dimensional() -> None:
    assert separation(np.array([[[0.0, 0, 0], [2.0, 3.0, 6.0]]]), 0, 1).tolist() == [7.0]


def test_lip_vertex_error_takes_the_worst_vertex_squared_then_the_mean_over_frames() -> None:
    recorded, synthesised = np.zeros((2, 3, 3)), np.zeros((2, 3, 3))
    synthesised[0, 0, 0], synthesised[0, 1, 1], synthesised[1, 2, 2] = 1.0, 3.0, 1.0
    assert lip_vertex_error(recorded, synthesised) == (9.0 + 1.0) / 2


def test_upper_face_deviation_signed_and_absolute() -> None:
    rest = np.zeros((2, 3))
    recorded, synthesised = np.zeros((4, 2, 3)), np.zeros((4, 2, 3))
    recorded[:, 0, 1] = (0.0, 2.0, 0.0, 2.0)  # sd 1 against 0
    synthesised[:, 1, 1] = (0.0, 6.0, 0.0, 6.0)  # 0 against sd 3
    assert upper_face_dynamics_deviation(recorded, synthesised, rest) == (-1.0, 2.0)
    # Squared lengths as in CodeTalker's code: sd of (0, 4) is 2, of (0, 36) is 18.
    assert upper_face_dynamics_deviation(recorded, synthesised, rest, squared=True) == (-8.0, 10.0)


def test_a_rest_of_the_wrong_shape_is_refused() -> None:
    with pytest.raises(InputError, match="rest of shape"):
        upper_face_dynamics_deviation(np.zeros((4, 2, 3)), np.zeros((4, 2, 3)), np.zeros((3, 3)))


def test_mouth_opening_difference_is_the_rms_of_the_difference() -> None:
    assert mouth_opening_difference(np.array([0.0, 0.0]), np.array([3.0, -3.0])) == 3.0


def test_jitter_is_the_size_of_the_noise_whatever_smooth_motion_lies_below() -> None:
    random = np.random.default_rng(1)
    smooth = 10 * np.sin(np.arange(4000) / 25)[:, None, None] * np.ones((1, 2, 3))
    noisy = smooth + random.normal(0, 0.2, smooth.shape)
    assert jitter(noisy) == pytest.approx(0.2 * np.sqrt(3), rel=0.03)
    assert jitter(smooth) < 0.001


@pytest.mark.parametrize("positions", [np.zeros((3, 2, 3)), np.zeros((5, 2, 2)), np.full((5, 2, 3), np.nan)])
def test_jitter_refuses_what_has_none(positions: np.ndarray) -> None:
    with pytest.raises(InputError, match="jitter needs"):
        jitter(positions)
