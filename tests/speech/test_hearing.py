"""Hearing a whole sound: blocks agree with the stream, edges between rows; what Gaussians and noise floor say."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.utterance import PAUSE
from mien.speech import hearing
from mien.speech.frame_classifier import default_classifier
from mien.speech.hearing import MIXTURES, SHARE, Hearing, hear
from mien.speech.noise_floor import NoiseFloor
from mien.speech.phone_likelihoods import LAG, PhoneLikelihoods, likelihood_labels, mixtures
from mien.speech.streaming_features import BANDS, HOP, RATE, StreamingFeatures


def test_blocks_are_heard_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = np.random.default_rng(0).normal(0, 0.05, 2 * RATE)
    network = default_classifier()
    rows = StreamingFeatures().push(sound)
    late = np.concatenate([rows[LAG:, BANDS + 2 :], np.repeat(rows[-1:, BANDS + 2 :], LAG, axis=0)])
    whole = network.log_posteriors(rows) - SHARE * network.log_share + MIXTURES * late
    whole[:, 0] -= hearing.PAUSE_IN_NOISE  # white noise all along: nothing in it is quiet
    monkeypatch.setattr(hearing, "_BLOCK", RATE // 3)
    np.testing.assert_allclose(hear(Audio(sound, RATE)).rows, whole, atol=0.05)


def test_an_edge_lies_where_both_are_as_likely() -> None:
    rows = np.array([[0.0, -3.0], [0.0, -3.0], [-1.0, 0.0], [-3.0, 0.0]], np.float32)
    heard = Hearing((PAUSE, "A"), rows)
    assert heard.edge(2, PAUSE, "A") == pytest.approx(0.0125 + 1.75 * HOP / RATE)
    assert heard.score("A", 2, 4) == 0.0
    assert heard.score(PAUSE, 2, 4) == pytest.approx(-2.0)


def test_the_mixtures_are_those_of_pocketsphinx() -> None:
    model = mixtures()
    assert model.weights.shape == (3, 40, 128, 3)
    np.testing.assert_allclose(model.weights.sum(axis=2), 1.0, atol=0.08)  # stored in steps of a tenth


def test_a_density_is_likeliest_at_its_own_mean() -> None:
    model, vowel = mixtures(), likelihood_labels().index("IY")
    squares, values = (model.densities[:, place : place + 13] for place in (0, 13))
    means = (values / (-2 * squares)).reshape(3, 13, 40, 128)[:, :, vowel]
    common = int(model.weights[0, vowel].mean(axis=1).argmax())
    features = np.stack([means[0, :, common], *means[1:].mean(axis=2)])[None].astype(np.float32)
    assert int(model.scores(features).argmax()) == vowel


def test_scores_of_a_stream_come_late_and_do_not_depend_on_how_it_is_cut() -> None:
    powers = np.random.default_rng(2).gamma(1.0, 1e-4, (60, 257))
    whole, cut = PhoneLikelihoods(512, RATE), PhoneLikelihoods(512, RATE)
    scores = whole.push(powers)
    parts = np.concatenate([cut.push(part) for part in np.split(powers, [1, 5, 40])])
    np.testing.assert_allclose(parts, scores, atol=0.01)
    assert scores.shape == (60, 40)
    assert scores.max() == 0.0
    changed = powers.copy()
    changed[50:] *= 100
    np.testing.assert_allclose(PhoneLikelihoods(512, RATE).push(changed)[:50], scores[:50], atol=1e-3)
    assert LAG == 3


def test_steady_noise_is_taken_away_and_a_burst_is_not() -> None:
    random = np.random.default_rng(3)
    powers = random.gamma(8.0, 1e5, (400, 25))
    powers[200:205] *= 100
    floor = NoiseFloor(25)
    clean = floor.push(powers)
    gain = clean.sum(axis=1) / powers.sum(axis=1)
    assert np.median(gain[50:200]) < 0.3
    assert gain[201:205].min() > 0.8
    assert floor.noise.mean() == pytest.approx(8e5, rel=0.35)
