"""Phones from a stream: known answers of a made network, the plain search as referee, bounded memory, real speech."""

from __future__ import annotations

import io
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from mien.core.utterance import PAUSE
from mien.speech import frame_classifier
from mien.speech.frame_classifier import FUTURE, STEP, FrameClassifier, FrameStream, default_classifier
from mien.speech.phone_stream import MEMORY, SHORTEST, DecodingSettings, PhoneStream, _Paths, _traced
from mien.speech.streaming_features import BANDS, RATE, StreamingFeatures
from mien.text.phones import phone_table

RANDOM = np.random.default_rng(2)


def made_network() -> FrameClassifier:
    """Two blocks of random weights, four wide, with the names and reaches of the one that ships."""
    width, inner, labels = 4, 6, 3
    shapes = {"sub_w": (3, BANDS, width), "sub_b": (width,)}
    for block in range(2):
        for name, entering, leaving in (("ffn1", inner, width), ("ffn2", inner, width), ("attn", 3 * width, width)):
            shapes |= {f"{block}.{name}.in_w": (width, entering), f"{block}.{name}.in_b": (entering,)}
            shapes |= {f"{block}.{name}.out_w": (entering if name != "attn" else width, leaving)}
            shapes |= {f"{block}.{name}.out_b": (leaving,)}
        shapes |= {f"{block}.conv.in_w": (width, 2 * width), f"{block}.conv.in_b": (2 * width,)}
        shapes |= {f"{block}.conv.deep_w": (5, width), f"{block}.conv.deep_b": (width,)}
        shapes |= {f"{block}.conv.out_w": (width, width), f"{block}.conv.out_b": (width,)}
        for name in ("ffn1.", "ffn2.", "attn.", "conv.", ""):
            shapes |= {f"{block}.{name}norm_w": (width,), f"{block}.{name}norm_b": (width,)}
    shapes |= {"head.near_w": (2 * width, 5), "head.near_b": (5,), "head.wide_w": (3, 5, 7), "head.wide_b": (7,)}
    shapes |= {"head.out_w": (7, 2 * labels), "head.out_b": (2 * labels,)}
    random = np.random.default_rng(2)
    weights = {name: random.normal(0, 0.5, shape).astype(np.float32) for name, shape in shapes.items()}
    even = np.log(np.full(3, 1 / 3, np.float32))
    return FrameClassifier((PAUSE, "M", "AA"), weights, even, np.tile(even, (3, 1)))


def test_all_at_once_is_the_stream_that_waits_for_all() -> None:
    network, rows = made_network(), RANDOM.normal(0, 1, (61, BANDS)).astype(np.float32)
    whole, stream = network.log_posteriors(rows), FrameStream(network, future=40, step=10)
    found = np.concatenate([*(stream.push(part) for part in np.split(rows, [3, 20])), stream.pending()])
    np.testing.assert_allclose(found, whole[:60], atol=1e-5)
    np.testing.assert_allclose(np.exp(whole).sum(axis=1), 1.0, atol=1e-4)
    assert whole.shape == (61, 3)
    assert network.log_posteriors(rows[:1]).shape == (1, 3)


def test_answers_do_not_depend_on_how_rows_come_and_are_settled_once() -> None:
    network, rows = made_network(), RANDOM.normal(0, 1, (120, BANDS)).astype(np.float32)
    one, other = (FrameStream(network, future=4, step=3, past=8) for _ in range(2))
    settled = one.push(rows)
    pieces = []
    for part in np.split(rows, np.sort(RANDOM.integers(0, 120, 15))):
        pieces.append(other.push(part))
        other.pending()
    np.testing.assert_array_equal(np.concatenate(pieces), settled)
    np.testing.assert_array_equal(other.pending(), one.pending())
    assert one.settled == len(settled) == 120 - 14 + 120 % 2 + 2
    assert len(one._window.kept[0].attended) == 8


def test_a_block_agrees_with_a_plain_reference() -> None:
    """Attention one frame and one head at a time, the convolution one tap at a time."""
    network, frames = made_network(), RANDOM.normal(0, 1, (7, 4)).astype(np.float32)
    weights = {name[2:]: values.astype(np.float64) for name, values in network.weights.items() if name[:2] == "0."}

    def normal(x: np.ndarray, name: str) -> np.ndarray:
        x = (x - x.mean()) / np.sqrt(x.var() + 1e-5)
        return x * weights[f"{name}norm_w"] + weights[f"{name}norm_b"]

    def into(x: np.ndarray, name: str) -> np.ndarray:
        return np.array([normal(row, name) @ weights[f"{name}in_w"] + weights[f"{name}in_b"] for row in x])

    def out(x: np.ndarray, name: str) -> np.ndarray:
        return x @ weights[f"{name}out_w"] + weights[f"{name}out_b"]

    def swish(x: np.ndarray) -> np.ndarray:
        return x / (1 + np.exp(-x))

    x = frames.astype(np.float64)
    x = x + 0.5 * out(swish(into(x, "ffn1.")), "ffn1.")
    query, key, value = np.split(into(x, "attn."), 3, axis=1)
    taken = np.zeros_like(x)
    for frame, head in product(range(7), range(4)):  # one column a head
        share = np.exp(query[frame, head] * key[:, head])
        taken[frame, head] = share @ value[:, head] / share.sum()
    x = x + out(taken, "attn.")
    value, gate = np.split(into(x, "conv."), 2, axis=1)
    value, deep = value / (1 + np.exp(-gate)), np.tile(weights["conv.deep_b"], (7, 1))
    for frame, tap in product(range(7), range(5)):
        if 0 <= frame + tap - 2 < 7:
            deep[frame] += value[frame + tap - 2] * weights["conv.deep_w"][tap]
    x = x + out(swish(deep), "conv.")
    x = x + 0.5 * out(swish(into(x, "ffn2.")), "ffn2.")
    window = frame_classifier._Window(network, 10)
    found = window._block(frames, "0.", window.kept[0], 0)
    np.testing.assert_allclose(found, [normal(row, "") for row in x], atol=1e-4)


def test_a_network_comes_back_from_its_file(tmp_path: Path) -> None:
    network, rows = made_network(), RANDOM.normal(0, 1, (12, BANDS)).astype(np.float32)
    path = str(tmp_path / "network.npz")
    network.save(path)
    back = FrameClassifier.load(io.BytesIO(Path(path).read_bytes()))
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
    assert tier.intervals[0].start >= stream.heard - MEMORY - 0.35
    assert len(stream._frames._rows) < 2 * (FUTURE + STEP)
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
    assert sum(values.size for values in network.weights.values()) * 2 < 5_500_000
    rows = StreamingFeatures().push(RANDOM.normal(0, 0.01, RATE))
    assert np.isfinite(network.log_posteriors(rows)).all()
