"""Features of a live sound: the same however it is cut, deaf to level, offset and the microphone's colour."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from mien.speech.streaming_features import BANDS, CENTRE, HOP, RATE, WINDOW, StreamingFeatures, mel_bank

RANDOM = np.random.default_rng(1)
SOUND = RANDOM.normal(0, 0.05, 3 * RATE) * (np.sin(2 * np.pi * 3 * np.arange(3 * RATE) / RATE) > -0.3)


@given(st.lists(st.integers(0, 3 * RATE), max_size=30))
@settings(max_examples=15)
def test_however_the_sound_is_cut_the_rows_are_the_same(cuts: list[int]) -> None:
    features = StreamingFeatures()
    found = np.concatenate([features.push(piece) for piece in np.split(SOUND, sorted(cuts))])
    whole = StreamingFeatures().push(SOUND)
    np.testing.assert_allclose(found[:, : BANDS + 2], whole[:, : BANDS + 2], atol=1e-9)
    np.testing.assert_allclose(found[:, BANDS + 2 :], whole[:, BANDS + 2 :], atol=0.05)  # in single precision


def test_rows_see_only_the_past_and_their_own_window() -> None:
    whole = StreamingFeatures().push(SOUND)
    changed = SOUND.copy()
    changed[RATE:] = 0.3
    other = StreamingFeatures().push(changed)
    before = (RATE - WINDOW) // HOP
    np.testing.assert_array_equal(whole[:before], other[:before])
    assert CENTRE + before * HOP / RATE <= 1.0


def test_a_tone_is_heard_in_its_band() -> None:
    for hertz in (300, 1000, 3000):
        tone = 0.1 * np.sin(2 * np.pi * hertz * np.arange(RATE) / RATE) + RANDOM.normal(0, 1e-4, RATE)
        row = StreamingFeatures().push(tone)[20, :BANDS]
        bank = mel_bank()
        assert np.argmax(row) == np.argmax(bank[round(hertz / RATE * 512)] / bank.max(axis=0))


@pytest.mark.parametrize("gain", [0.03, 10.0])
def test_after_a_while_the_level_does_not_matter(gain: float) -> None:
    late = slice(-50, None)
    usual, other = (StreamingFeatures().push(np.tile(SOUND * g, 5))[late, :BANDS] for g in (1.0, gain))
    loud = usual.mean(axis=1) > np.median(usual.mean(axis=1))
    assert np.abs(usual[loud] - other[loud]).mean() < 0.35 * abs(np.log(gain**2)) * 0.5


def test_an_offset_is_not_heard() -> None:
    plain, moved = StreamingFeatures().push(SOUND), StreamingFeatures().push(SOUND + 0.2)
    assert np.abs(plain[30:] - moved[30:]).mean() < 0.05


def test_the_colour_of_a_microphone_fades_out() -> None:
    coloured = lfilter([1.0, -0.7], [1.0], np.tile(SOUND, 4))
    plain = StreamingFeatures().push(np.tile(SOUND, 4))[-150:, :BANDS]
    found = StreamingFeatures().push(coloured)[-150:, :BANDS]
    loud = plain.mean(axis=1) > np.median(plain.mean(axis=1))
    shape = (found - plain)[loud].mean(axis=0)
    filtered = np.log(np.abs(1 - 0.7 * np.exp(-1j * np.pi * np.linspace(0.01, 0.95, BANDS))) ** 2)
    assert np.ptp(shape) < 0.5 * np.ptp(filtered)
