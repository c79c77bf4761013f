"""Phones from a stream: known answers of a made network, the plain search as referee, bounded memory, real speech."""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.utterance import PAUSE
from mien.speech.frame_classifier import FrameClassifier, default_classifier
from mien.speech.phone_stream import MEMORY, SHORTEST, DecodingSettings, PhoneStream, _Paths, _traced
from mien.speech.streaming_features import COLUMNS, HOP, RATE, StreamingFeatures
from mien.text.phones import phone_table

RANDOM = np.random.default_rng(2)


def made_network() -> FrameClassifier:
    offsets = np.array([-2, 0, 1, 3])
    sizes = (len(offsets) * (COLUMNS + 1), 6, 3)
    layers = tuple(
        (RANDOM.normal(0, 0.3, (a, b)).astype(np.float32), RANDOM.normal(0, 0.1, b).astype(np.float32))
        for a, b in pairwise(sizes)
    )
    even = np.log(np.full(3, 1 / 3, np.float32))
    return FrameClassifier((PAUSE, "M", "AA"), offsets, np.zeros(COLUMNS, np.float32), np.ones(COLUMNS, np.float32),
                           layers, even, np.tile(even, (3, 1)))  # fmt: skip


def plain_posteriors(network: FrameClassifier, rows: np.ndarray, place: int) -> np.ndarray:
    """One row, one number at a time."""
    seen: list[float] = []
    flags: list[float] = []
    for offset in network.offsets:
        at = max(place + int(offset), 0)
        flags.append(float(at >= len(rows)))
        seen += [0.0] * COLUMNS if at >= len(rows) else list((rows[at] - network.mean) / network.spread)
    value = np.array(seen + flags)
    for number, (weights, bias) in enumerate(network.layers):
        value = value @ weights.astype(np.float64) + bias
        if number < len(network.layers) - 1:
            value = np.where(value > 0, value, 0.0)
    return np.asarray(np.log(np.exp(value) / np.exp(value).sum()))


def test_the_network_agrees_with_its_plain_reference() -> None:
    network, rows = made_network(), RANDOM.normal(0, 1, (12, COLUMNS))
    found = network.log_posteriors(rows)
    for place in range(len(rows)):
        np.testing.assert_allclose(found[place], plain_posteriors(network, rows, place), atol=1e-4)
    np.testing.assert_allclose(network.log_posteriors(rows, 3, 7), found[3:7], atol=1e-6)
    with pytest.raises(InputError, match="are not all among 12"):
        network.log_posteriors(rows, 3, 13)


def test_a_network_comes_back_from_its_file(tmp_path: Path) -> None:
    network, rows = made_network(), RANDOM.normal(0, 1, (12, COLUMNS))
    path = str(tmp_path / "network.npz")
    network.save(path)
    first = Path(path).read_bytes()
    back = FrameClassifier.load(io.BytesIO(first))
    assert back.labels == network.labels
    np.testing.assert_allclose(back.log_posteriors(rows), network.log_posteriors(rows), atol=0.02)


def plain_search(heard: np.ndarray, follow: np.ndarray, start: int) -> float:
    """The best score of all rows of labels, by trying every one of them."""
    best = -np.inf
    for labels in product(range(heard.shape[1]), repeat=len(heard)):
        runs: list[list[int]] = []
        for place, label in enumerate(labels):
            if place and label == labels[place - 1]:
                runs[-1][1] += 1
            else:
                runs.append([label, 1])
        score = float(heard[np.arange(len(heard)), labels].sum())
        before, allowed = start, True
        for number, (label, length) in enumerate(runs):
            goes_on = number == 0 and label == start
            if not goes_on:
                score += float(follow[before, label])
                allowed &= length >= SHORTEST or number == len(runs) - 1
            before = label
        best = max(best, score if allowed else -np.inf)
    return best


def test_the_best_row_of_phones_is_found() -> None:
    for seed in range(6):
        random = np.random.default_rng(seed)
        heard, follow = random.normal(0, 2, (7, 3)), random.normal(-0.5, 0.5, (3, 3))
        np.fill_diagonal(follow, -np.inf)
        start = np.full((SHORTEST, 3), -1e3)
        start[-1, 0] = 0.0
        paths, steps, lost = _Paths(start), [], 0.0
        for row in heard:
            raw = paths.scores
            paths, step = paths.step(row, follow)
            steps.append(step)
            entering = np.array([(raw[-1] + follow[:, k]).max() for k in range(3)])
            full = np.vstack([entering, raw[:-1]])
            full[-1] = np.maximum(full[-1], raw[-1])
            lost += float((full + row).max())
        assert lost == pytest.approx(plain_search(heard, follow, 0), abs=1e-6)
        spans = _traced(paths.scores, steps)
        assert [a for a, _, _ in spans] == [0, *(b for _, b, _ in spans[:-1])]
        score, before = 0.0, 0
        for number, (first, last, label) in enumerate(spans):
            score += float(heard[first:last, label].sum())
            score += 0.0 if number == 0 and label == 0 else float(follow[before, label])
            before = label
        assert score == pytest.approx(lost, abs=1e-6)


def test_however_the_sound_is_cut_the_phones_are_the_same() -> None:
    sound = RANDOM.normal(0, 0.05, RATE)
    one, other = PhoneStream(), PhoneStream()
    one.push(sound)
    for piece in np.split(sound, np.sort(RANDOM.integers(0, RATE, 12))):
        other.push(piece)
    assert one.phones() == other.phones()
    assert one.heard == other.heard == 1.0


def test_phones_cover_the_end_of_the_sound_without_gaps_and_memory_is_bounded() -> None:
    stream = PhoneStream()
    for _ in range(100):
        stream.push(RANDOM.normal(0, 0.05, RATE // 10))
    tier = stream.phones()
    assert all(a.end == pytest.approx(b.start) for a, b in zip(tier, tier.intervals[1:], strict=False))
    assert stream.heard - 0.03 < tier.intervals[-1].end <= stream.heard
    assert tier.intervals[0].start >= stream.heard - MEMORY - 0.3
    assert len(stream._rows) < 80
    settled = stream.phones(whole=False)
    assert settled.intervals[-1].end < tier.intervals[-1].end


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-3, 0.05])
def test_silence_and_noise_are_pauses(noise: float) -> None:
    stream = PhoneStream()
    stream.push(RANDOM.normal(0, noise, 3 * RATE) if noise else np.zeros(3 * RATE))
    paused = sum(phone.duration for phone in stream.phones() if phone.label == PAUSE)
    assert paused > 0.8 * MEMORY


def test_settings_matter() -> None:
    sound = RANDOM.normal(0, 0.05, RATE) * (np.sin(2 * np.pi * 4 * np.arange(RATE) / RATE) > 0)
    counts = []
    for change in (0.0, 30.0):
        stream = PhoneStream(settings=DecodingSettings(change=change))
        stream.push(sound)
        counts.append(len(stream.phones()))
    assert counts[1] <= counts[0]


def test_the_network_that_ships_is_small_and_knows_every_phone() -> None:
    network = default_classifier()
    assert set(network.labels) == {PAUSE, *phone_table()}
    assert sum(weights.size for weights, _ in network.layers) * 2 < 2_500_000
    assert network.future * HOP / RATE <= 0.2
    rows = StreamingFeatures().push(RANDOM.normal(0, 0.01, RATE))
    assert np.isfinite(network.log_posteriors(rows)).all()
    assert np.isfinite(replace(network, mean=network.mean + 1).log_posteriors(rows)).all()
