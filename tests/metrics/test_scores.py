"""Tallies and what is read from them."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.metrics.closure import closure_counts
from mien.metrics.counts import Tally, tally
from mien.metrics.distance import marker_rms
from mien.metrics.published import lip_vertex_error
from mien.metrics.scored_takes import Recording, prepare
from mien.metrics.scores import METRICS, score
from mien.metrics.track_jitter import jitter
from mien.metrics.trajectory import correlation, rms_error, separation, velocity
from tests.metrics.synthetic import takes


@pytest.fixture(scope="module")
def pairs() -> list[tuple[Recording, np.ndarray]]:
    random = np.random.default_rng(8)
    ready = [prepare(take) for take in takes(6, noise=0.05)]
    return [(r, r.positions + random.normal(0, 0.5 + i / 4, r.positions.shape)) for i, r in enumerate(ready)]


def tallies(pairs: list[tuple[Recording, np.ndarray]]) -> list[Tally]:
    return [tally(recording, mouth, recording.speech) for recording, mouth in pairs]


def test_averaged_scores_are_the_means_of_the_pure_functions(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    scores = score(tallies(pairs), pooled=False, random=np.random.default_rng(0))
    cut = [(r.positions[r.speech], mouth[r.speech], r) for r, mouth in pairs]
    assert scores["rms"].value == pytest.approx(np.mean([marker_rms(a, b) for a, b, _ in cut]))
    assert scores["jitter"].value == pytest.approx(np.mean([jitter(b) for _, b, _ in cut]))
    lips = [lip_vertex_error(a[:, r.sites.lips], b[:, r.sites.lips]) for a, b, r in cut]
    assert scores["lip_vertex_error"].value == pytest.approx(np.mean(lips))
    opening = [(separation(a, *r.sites.opening), separation(b, *r.sites.opening)) for a, b, r in cut]
    assert scores["opening_r"].value == pytest.approx(np.mean([correlation(a, b) for a, b in opening]))
    width = [(separation(a, *r.sites.width), separation(b, *r.sites.width)) for a, b, r in cut]
    assert scores["width_error"].value == pytest.approx(np.mean([rms_error(a, b) for a, b in width]))


def test_pooled_scores_are_those_of_all_frames_together(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    scores = score(tallies(pairs), pooled=True, random=np.random.default_rng(0))
    recorded = np.concatenate([r.positions[r.speech] for r, _ in pairs])
    synthesised = np.concatenate([mouth[r.speech] for r, mouth in pairs])
    assert scores["rms"].value == pytest.approx(marker_rms(recorded, synthesised))
    opening = pairs[0][0].sites.opening
    speeds = [
        np.concatenate([velocity(separation(p, *opening), 25.0)[r.speech] for r, p in which])
        for which in ([(r, r.positions) for r, _ in pairs], pairs)
    ]
    assert scores["opening_velocity_r"].value == pytest.approx(correlation(*speeds))


def test_closures_are_pooled_always(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    counts = [closure_counts(separation(m, *r.sites.opening), r.times, r.take.phones, r.speech) for r, m in pairs]
    total = counts[0]
    for more in counts[1:]:
        total = total + more
    for pooled in (False, True):
        scores = score(tallies(pairs), pooled=pooled, random=np.random.default_rng(0))
        assert scores["closure_f1"].value == pytest.approx(total.f1)
        assert scores["closure_recall"].value == pytest.approx(total.recall)


def test_a_recording_scored_against_itself(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    own = [tally(r, r.positions, r.speech) for r, _ in pairs]
    scores = score(own, pooled=False, random=np.random.default_rng(0))
    assert (scores["rms"].value, scores["lag"].value, scores["onset_lag"].value) == (
        0.0,
        pytest.approx(0, abs=1e-6),
        0.0,
    )
    assert scores["opening_r"].value == pytest.approx(1.0)
    assert scores["closure_recall"].value == 1.0


def test_the_interval_holds_the_figure_and_narrows_with_more_takes(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    few = score(tallies(pairs), pooled=False, random=np.random.default_rng(0))["rms"]
    many = score(tallies(pairs) * 9, pooled=False, random=np.random.default_rng(0))["rms"]
    assert few.low < few.value < few.high
    assert many.high - many.low < (few.high - few.low) / 2
    again = score(tallies(pairs), pooled=False, random=np.random.default_rng(0))["rms"]
    assert again == few


def test_the_interval_is_that_of_the_mean() -> None:
    values = np.random.default_rng(4).normal(2.0, 0.3, 200)
    rows: list[Tally] = [dict.fromkeys((m.family for m in METRICS.values()), np.ones(6)) for _ in values]
    rows = [{**row, "distance": np.array([v**2, 1.0])} for row, v in zip(rows, values, strict=True)]
    interval = score(rows, pooled=False, random=np.random.default_rng(0))["rms"]
    half = 1.96 * values.std() / np.sqrt(len(values))
    assert interval.value == pytest.approx(values.mean())
    assert interval.high - interval.low == pytest.approx(2 * half, rel=0.1)


def test_what_cannot_be_told_is_nan() -> None:
    recording = prepare(takes(1)[0])
    still = np.tile(recording.positions[:1], (len(recording.positions), 1, 1))
    scores = score([tally(recording, still, recording.speech)], pooled=False, random=np.random.default_rng(0))
    assert np.isnan(scores["opening_r"].value)
    assert np.isnan(scores["lag"].low)


def test_what_a_model_may_not_give(pairs: list[tuple[Recording, np.ndarray]]) -> None:
    recording, mouth = pairs[0]
    with pytest.raises(InputError, match="take 'take00': expected finite positions of shape"):
        tally(recording, mouth[:-1], recording.speech)
    broken = mouth.copy()
    broken[3, 2, 1] = np.inf
    with pytest.raises(InputError, match="expected finite positions"):
        tally(recording, broken, recording.speech)
    with pytest.raises(InputError, match="at least one take"):
        score([], pooled=False, random=np.random.default_rng(0))
