import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.capture.cleaning.resample import resample
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from tests.capture.cleaning.synthetic import speaking

rates = st.sampled_from(["24", "25", "29.97", "30", "50", "60", "100", "120"]).map(FrameRate.of)
counts = st.integers(1, 150)


def of(values: np.ndarray, rate: FrameRate) -> MarkerTrack:
    return MarkerTrack(("a",), np.asarray(values, dtype=float)[:, None, None] * np.array([1.0, -2.0, 0.5]), rate)


@settings(max_examples=60, deadline=None)
@given(rates, rates, counts, st.floats(-1e3, 1e3))
def test_constant_stays_constant(old: FrameRate, new: FrameRate, count: int, value: float) -> None:
    result = resample(of(np.full(count, value), old), new).positions
    np.testing.assert_allclose(result, np.tile(value * np.array([1.0, -2.0, 0.5]), (len(result), 1, 1)), atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(rates, rates, st.integers(2, 150), st.floats(-50, 50))
def test_linear_stays_linear_up_to_the_last_frame(old: FrameRate, new: FrameRate, count: int, slope: float) -> None:
    result = resample(of(slope * old.times(count), old), new)
    np.testing.assert_allclose(result.positions[:, 0, 0], slope * new.times(len(result)), atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(rates, rates, counts)
def test_duration_is_kept_to_a_frame(old: FrameRate, new: FrameRate, count: int) -> None:
    result = resample(of(np.zeros(count), old), new)
    seconds = count / old.fps
    assert seconds - 1e-6 <= len(result) / new.fps < seconds + 1 / new.fps + 1e-6
    assert result.rate == new


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([(25, 50), (25, 100), (30, 60), (30, 120), (60, 120), (24, 120)]), st.integers(0, 1000))
def test_times_that_both_rates_share_keep_their_values_going_up(pair: tuple[int, int], seed: int) -> None:
    old, new = FrameRate.of(pair[0]), FrameRate.of(pair[1])
    values = np.random.default_rng(seed).normal(size=40)
    result = resample(of(values, old), new)
    np.testing.assert_array_equal(result.positions[:: pair[1] // pair[0]], of(values, old).positions)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([(25, 120), (25, 60), (30, 50), (60, 25), (120, 25), (120, 60)]), st.integers(0, 1000))
def test_round_trip_of_band_limited_motion(pair: tuple[int, int], seed: int) -> None:
    """Motion below 4 Hz (a third of the Nyquist frequency of the slower rate) survives there and back."""
    old, new = FrameRate.of(pair[0]), FrameRate.of(pair[1])
    random = np.random.default_rng(seed)
    t = old.times(int(4 * old.fps))
    waves = [random.normal() * np.sin(2 * np.pi * f * t + random.uniform(0, 6)) for f in (0.4, 1.1, 2.3, 3.9)]
    track = of(np.sum(waves, axis=0), old)
    back = resample(resample(track, new), old)
    inner = slice(int(0.6 * old.fps), -int(0.6 * old.fps))
    assert len(back) == len(track)
    error = np.abs(back.positions[inner, 0, 0] - track.positions[inner, 0, 0]).max()
    assert error < 0.02 * np.abs(track.positions[:, 0, 0]).max()


def test_what_the_slower_rate_cannot_hold_is_taken_out_and_not_folded_down() -> None:
    fast, slow = FrameRate.of(120), FrameRate.of(25)
    t = fast.times(480)
    high = resample(of(np.sin(2 * np.pi * 23 * t), fast), slow).positions[12:-12, 0, 0]
    low = resample(of(np.sin(2 * np.pi * 5 * t), fast), slow).positions[12:-12, 0, 0]
    assert np.abs(high).max() < 0.01  # plain picking of frames would show a 2 Hz ghost at full size
    np.testing.assert_allclose(low, np.sin(2 * np.pi * 5 * slow.times(100))[12:-12], atol=0.01)


def test_unseen_stays_unseen_and_spoils_nothing_else() -> None:
    track = speaking()
    positions = track.positions.copy()
    positions[40:45, 3] = np.nan
    positions[0, 5] = np.nan
    up = resample(MarkerTrack(track.names, positions, track.rate), FrameRate.of(50))
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(up.positions[:, 3, 0])), np.arange(79, 90))
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(up.positions[:, 5, 0])), [0, 1])
    others = [m for m in range(len(track.names)) if m not in (3, 5)]
    np.testing.assert_allclose(up.positions[:, others], resample(track, FrameRate.of(50)).positions[:, others])
    np.testing.assert_array_equal(up.positions[::2], positions)


def test_the_same_rate_gives_the_same_track_and_none_is_refused() -> None:
    track = speaking()
    assert resample(track, track.rate) is track
    with pytest.raises(InputError, match="no frames"):
        resample(MarkerTrack(("a",), np.zeros((0, 1, 3)), FrameRate.of(25)), FrameRate.of(30))
