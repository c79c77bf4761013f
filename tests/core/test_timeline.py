from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier, timecode

rates = st.sampled_from([24, 25, 29.97, 30, 59.94, 60, 120, "30000/1001", 12.5])


@pytest.mark.parametrize(
    ("given_", "expected"),
    [
        (25, Fraction(25)),
        (29.97, Fraction(30000, 1001)),
        (23.976, Fraction(24000, 1001)),
        (59.94, Fraction(60000, 1001)),
        ("30000/1001", Fraction(30000, 1001)),
        (" 50 ", Fraction(50)),
        (12.5, Fraction(25, 2)),
        (30.0, Fraction(30)),
    ],
)
def test_rates_are_read_exactly(given_: float | str, expected: Fraction) -> None:
    assert FrameRate.of(given_).fraction == expected


@pytest.mark.parametrize("bad", [0, -25, "0", "fast", float("nan"), float("inf"), "1/0", 1001, ""])
def test_impossible_rates_are_refused_in_one_line(bad: float | str) -> None:
    with pytest.raises(InputError, match="frame rate") as caught:
        FrameRate.of(bad)
    assert "\n" not in str(caught.value)


@given(rates, st.integers(0, 10**6))
def test_a_frame_is_on_show_at_its_own_time(rate: float | str, frame: int) -> None:
    fps = FrameRate.of(rate)
    assert fps.frame_at(fps.time_of(frame)) == frame
    assert fps.nearest_frame(fps.time_of(frame)) == frame


@given(rates, st.floats(0, 10**4))
def test_frames_cover_the_sound_and_end_within_one_frame_of_it(rate: float | str, seconds: float) -> None:
    fps = FrameRate.of(rate)
    end = fps.frames_covering(seconds) / fps.fps
    assert end >= seconds - 1e-6
    assert end <= max(seconds, 0) + 1 / fps.fps + 1e-6


def test_times_match_time_of() -> None:
    fps = FrameRate.of(29.97)
    assert fps.times(100)[99] == pytest.approx(fps.time_of(99), abs=1e-12)


def test_an_interval_that_runs_backwards_is_refused() -> None:
    with pytest.raises(InputError, match="run forward"):
        Interval(1.0, 0.5, "x")


def test_a_tier_refuses_overlap_and_names_it() -> None:
    with pytest.raises(InputError, match=r"'b' starts at 0\.4000 s, before 'a' has ended"):
        Tier("words", (Interval(0, 0.5, "a"), Interval(0.4, 1, "b")))


def test_a_tier_finds_what_holds_an_instant() -> None:
    tier = Tier("phones", (Interval(0, 0.5, "a"), Interval(0.6, 1, "b")))
    assert [getattr(tier.at(t), "label", None) for t in (0, 0.499, 0.5, 0.6, 0.999, 1.0)] == [
        "a",
        "a",
        None,
        "b",
        "b",
        None,
    ]


def test_shifted_moves_every_interval() -> None:
    assert Tier("w", (Interval(0, 1, "a"),)).shifted(0.5).intervals == (Interval(0.5, 1.5, "a"),)


def test_timecode_counts_whole_frames() -> None:
    assert timecode(0, FrameRate.of(30)) == "00:00:00:00.000"
    assert timecode(30 * 3661 + 7, FrameRate.of(30)) == "01:01:01:07.000"
    assert timecode(30, FrameRate.of(29.97)) == "00:00:01:00.030"


@pytest.mark.parametrize(
    "value", ["1e99999999", "1e-99999999", "9" * 1000, "1/" + "9" * 1000, "nan", float("inf"), None]
)
def test_rates_that_would_take_minutes_are_refused(value: object) -> None:
    with pytest.raises(InputError, match="a frame rate is"):
        FrameRate.of(value)  # type: ignore[arg-type]


def test_a_rate_that_rounds_to_nothing_is_refused():
    with pytest.raises(InputError, match="above 0"):
        FrameRate.of("0.0001")
