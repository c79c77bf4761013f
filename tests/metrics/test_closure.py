from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.metrics.closure import ClosureCounts, closure_counts

TIMES = np.arange(50) / 25


def phones(*labels: str, duration: float = 0.2) -> Tier:
    return Tier("phones", tuple(Interval(i * duration, (i + 1) * duration, p) for i, p in enumerate(labels)))


def shut(*stretches: tuple[float, float]) -> np.ndarray:
    opening = np.full(len(TIMES), 8.0)
    for start, end in stretches:
        opening[(start <= TIMES) & (end > TIMES)] = 0.3
    return opening


def test_a_bilabial_is_found_within_fifty_milliseconds_and_not_beyond() -> None:
    tier = phones("T", "AA", "B", "AA", "T")  # B is 0.40..0.60
    assert closure_counts(shut((0.64, 0.66)), TIMES, tier).found == 1  # frame at 0.64
    assert closure_counts(shut((0.36, 0.38)), TIMES, tier).found == 1
    assert closure_counts(shut((0.67, 0.72)), TIMES, tier).found == 0  # frame at 0.68
    assert closure_counts(shut((0.28, 0.34)), TIMES, tier).found == 0


def test_lips_at_three_quarters_of_a_millimetre_are_open() -> None:
    tier = phones("AA", "M", "AA")
    assert closure_counts(np.full(50, 0.75), TIMES, tier).found == 0
    assert closure_counts(np.full(50, 0.7499), TIMES, tier).found == 1


def test_only_bilabials_with_speech_on_both_sides_count() -> None:
    tier = phones("SIL", "B", "AA", "P", "AA", "M", "SIL", "AA", "M")
    assert closure_counts(shut(), TIMES, tier).bilabials == 1
    gap = Tier("phones", (Interval(0, 0.2, "AA"), Interval(0.3, 0.5, "M"), Interval(0.5, 0.7, "AA")))
    assert closure_counts(shut(), TIMES, gap).bilabials == 0


def test_precision_is_over_speech_frames_away_from_bilabials_beside_a_pause() -> None:
    tier = phones("SIL", "B", "AA", "T", "M", "AA", "SIL")  # B .2-.4 beside a pause, M .8-1.0 counts
    counts = closure_counts(shut((0.0, 0.4), (0.68, 0.72), (0.84, 0.96), (1.24, 1.4)), TIMES, tier)
    # In the pauses and at the first B nothing is judged; 0.68 is wrong, 0.84, 0.88 and 0.92 are right.
    assert counts == ClosureCounts(bilabials=1, found=1, closed_frames=4, right_frames=3)
    assert (counts.recall, counts.precision) == (1.0, 0.75)
    assert counts.f1 == pytest.approx(6 / 7)


def test_a_recording_that_misses_a_closure_has_a_recall_below_one() -> None:
    tier = phones("AA", "B", "AA", "P", "AA")
    counts = closure_counts(shut((0.28, 0.36)), TIMES, tier)
    assert counts.recall == 0.5
    assert counts.precision == 1.0


def test_counts_of_takes_add_up() -> None:
    total = ClosureCounts(2, 1, 3, 2) + ClosureCounts(1, 1, 1, 1)
    assert total == ClosureCounts(3, 2, 4, 3)


def test_without_bilabials_or_closures() -> None:
    assert np.isnan(ClosureCounts(0, 0, 0, 0).f1)
    assert ClosureCounts(2, 0, 0, 0).f1 == 0.0
    assert np.isnan(ClosureCounts(2, 0, 0, 0).precision)


def test_only_the_frames_asked_for_are_scored() -> None:
    tier = phones("AA", "B", "AA", "P", "AA")
    first_half = TIMES < 0.5
    counts = closure_counts(shut((0.24, 0.36), (0.64, 0.76)), TIMES, tier, first_half)
    assert counts == ClosureCounts(bilabials=1, found=1, closed_frames=3, right_frames=3)


def test_a_frame_that_was_not_seen_is_not_shut() -> None:
    assert closure_counts(np.full(50, np.nan), TIMES, phones("AA", "M", "AA")).found == 0


def test_other_lengths_are_refused() -> None:
    with pytest.raises(InputError, match="one lip opening for each time"):
        closure_counts(np.zeros(3), TIMES, phones("AA"))


def test_a_bilabial_of_the_next_word_is_not_asked_for() -> None:
    tier = Tier("phones", (Interval(0, 0.385, "AA"), Interval(0.385, 0.395, "B"), Interval(0.395, 0.6, "AA")))
    first, second = TIMES < 0.385, TIMES >= 0.385
    assert closure_counts(shut(), TIMES, tier, first).bilabials == 0
    assert closure_counts(shut(), TIMES, tier, second).bilabials == 0  # too short to hold a frame of either
    assert closure_counts(shut(), TIMES, tier, first | second).bilabials == 1
