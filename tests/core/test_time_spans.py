"""Moments against stretches, by search, as if every pair were looked at."""

import numpy as np

from mien.core.time_spans import is_within, places_within, seconds_away
from mien.core.timeline import Interval


def test_search_answers_as_every_pair_would() -> None:
    edges = np.cumsum(np.random.default_rng(3).integers(0, 4, 41)) / 8  # gaps, touching and empty stretches
    spans = [Interval(a, b, "x") for a, b in zip(edges[:-1:2].tolist(), edges[1::2].tolist(), strict=True)]
    times = np.arange(-1, edges[-1] + 1, 1 / 16)
    inside = [any(s.start <= t < s.end for s in spans) for t in times]
    away = [min(max(s.start - t, t - s.end, 0.0) for s in spans) for t in times]
    assert is_within(spans, times).tolist() == inside
    assert seconds_away(spans, times).tolist() == away
    assert times[places_within(times, 1.0, 2.5)].tolist() == [t for t in times.tolist() if 1.0 <= t <= 2.5]


def test_nothing_is_near_no_stretch() -> None:
    times = np.arange(3.0)
    assert not is_within((), times).any()
    assert np.isinf(seconds_away((), times)).all()
