"""RASTA-PLP against what is known of it: what it must not hear, and what it must."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from mien.core.audio import Audio
from mien.speech.rasta_plp import RATE, STEP, all_pole, bark_weights, cepstrum_of, rasta_plp

Floats = NDArray[np.float64]
VOWELS = {"IY": (270, 2290, 3010), "AA": (730, 1090, 2440), "UW": (300, 870, 2240)}
"""Formants in Hz (Peterson, Barney 1952)."""


RANDOM = np.random.default_rng(7)


def vowel(name: str, seconds: float = 0.3, pitch: float = 110.0) -> Floats:
    """A buzz through three resonances."""
    sound = np.zeros(round(seconds * RATE))
    sound[:: round(RATE / pitch)] = 1.0
    for formant in VOWELS[name]:
        radius, angle = np.exp(-np.pi * 80 / RATE), 2 * np.pi * formant / RATE
        sound = lfilter([1.0], [1, -2 * radius * np.cos(angle), radius**2], sound)
    return 0.1 * sound / np.abs(sound).max()


def speech(*names: str, noise: float = 1e-4, pitch: float = 110.0) -> Floats:
    """Vowels with near-silence between."""
    random = np.random.default_rng(0)
    pieces = [piece for name in names for piece in (np.zeros(RATE // 10), vowel(name, pitch=pitch))]
    sound = np.concatenate([*pieces, np.zeros(RATE // 10)])
    return sound + noise * random.standard_normal(len(sound))


def distance(one: Floats, other: Floats) -> float:
    return float(np.linalg.norm(one - other, axis=1).mean())


SAID = speech("IY", "AA", "UW", "AA", "IY")


def test_frames_stand_at_the_middles_of_their_windows() -> None:
    heard = rasta_plp(Audio(SAID, RATE))
    assert heard.values.shape == (1 + len(SAID) // round(STEP * RATE), 9)
    assert (heard.times[0], heard.times[100]) == (0.0, pytest.approx(1.0))
    assert [heard.place(t) for t in (-1.0, 0.004, 1.0, 99.0)] == [0, 0, 100, len(heard.values) - 1]


def test_what_is_heard_at_an_instant_stands_in_its_frame() -> None:
    click = np.zeros(RATE)
    click[RATE // 2 :] = vowel("AA", 0.5)
    change = np.abs(np.diff(rasta_plp(Audio(click + 1e-4 * RANDOM.standard_normal(RATE), RATE)).values[:, 0]))
    assert abs(int(change.argmax()) - 50) <= 2


def test_gain_is_not_heard() -> None:
    loud, quiet = (rasta_plp(Audio(SAID * gain, RATE)).values for gain in (1.0, 0.25))
    assert np.allclose(loud, quiet, atol=2e-3)  # what is left is the rounding of sound to 24 bit


def test_a_fixed_linear_filter_hardly_moves_it_while_plp_is_moved() -> None:
    coloured = 0.25 * lfilter([1.0, -0.9], [1.0, -0.3], SAID)
    moved = {}
    for rasta in (True, False):
        plain, filtered = (rasta_plp(Audio(sound, RATE), rasta=rasta).values for sound in (SAID, coloured))
        moved[rasta] = distance(plain, filtered) / np.sqrt(plain.var(axis=0).sum())
    assert moved[True] < 0.12
    assert moved[True] < moved[False] / 8


def test_different_vowels_differ_more_than_the_same_vowel_at_two_pitches() -> None:
    onset = slice(13, 28)  # the first vowel, from its start
    heard = {
        (name, pitch): rasta_plp(Audio(speech(name, "AA", pitch=pitch), RATE)).values[onset]
        for name in VOWELS
        for pitch in (110.0, 150.0)
    }
    same = max(distance(heard[name, 110.0], heard[name, 150.0]) for name in VOWELS)
    others = [distance(heard[a, 110.0], heard[b, 110.0]) for a in VOWELS for b in VOWELS if a < b]
    assert same < min(others) / 1.5


def test_the_colour_of_stationary_noise_is_suppressed() -> None:
    white = 0.05 * np.random.default_rng(3).standard_normal(3 * RATE)
    dull = lfilter([1.0], [1.0, -0.95], white) / 8
    steady = slice(50, None)
    apart = {}
    for rasta in (True, False):
        means = [rasta_plp(Audio(noise, RATE), rasta=rasta).values[steady].mean(axis=0) for noise in (white, dull)]
        apart[rasta] = float(np.linalg.norm(means[0] - means[1]))
    assert apart[True] < 0.05 * apart[False]


def test_digital_silence_and_the_shortest_sounds_give_finite_numbers() -> None:
    for samples in (np.zeros(0), np.zeros(10), np.ones(1), np.concatenate([np.zeros(8000), SAID, np.zeros(8000)])):
        values = rasta_plp(Audio(samples, RATE)).values
        assert len(values) >= 1
        assert np.isfinite(values).all()


def test_other_rates_hear_nearly_the_same() -> None:
    same, other = (rasta_plp(sound).values for sound in (Audio(SAID, RATE), Audio(SAID, RATE).resampled(44_100)))
    frames = min(len(same), len(other))
    assert distance(same[:frames], other[:frames]) < 0.1 * np.sqrt(same.var(axis=0).sum())


def test_an_all_pole_spectrum_is_found_again() -> None:
    poles = np.poly([0.8 * np.exp(1j), 0.8 * np.exp(-1j), 0.5]).real
    steps = 129
    response = 1 / np.abs(np.exp(-1j * np.outer(np.linspace(0, np.pi, steps), np.arange(4))) @ poles) ** 2
    found, gain = all_pole(2.5 * response[None], 3)
    assert np.allclose(found[0], poles, atol=1e-6)
    assert gain[0] == pytest.approx(2.5, rel=1e-6)
    roots = np.array([0.8 * np.exp(1j), 0.8 * np.exp(-1j), 0.5])
    known = [(roots**k).sum().real / k * k**0.6 for k in range(1, 4)]
    assert np.allclose(cepstrum_of(found, gain)[0, 1:], known, atol=1e-6)


def test_bands_cover_every_frequency_and_peak_in_their_order() -> None:
    weights = bark_weights()
    assert weights.max() == 1.0
    assert (weights[:, 3:].sum(axis=0) > 0.5).all()
    assert (np.diff(weights.argmax(axis=1)) >= 0).all()
