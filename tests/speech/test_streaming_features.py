"""Rows of a live sound: the same however it is cut, made of their own window alone, each tone in its band."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.speech.streaming_features import BANDS, HOP, RATE, WINDOW, StreamingFeatures, mel_bank

RANDOM = np.random.default_rng(1)
SOUND = RANDOM.normal(0, 0.05, RATE // 2)


@given(st.lists(st.integers(0, RATE // 2), max_size=30))
@settings(max_examples=15)
def test_however_the_sound_is_cut_the_rows_are_the_same(cuts: list[int]) -> None:
    features = StreamingFeatures()
    found = np.concatenate([features.push(piece) for piece in np.split(SOUND, sorted(cuts))])
    np.testing.assert_allclose(found, StreamingFeatures().push(SOUND), atol=1e-3)


def test_rows_see_their_own_window() -> None:
    whole, changed = StreamingFeatures().push(SOUND), SOUND.copy()
    changed[RATE // 4 :] = 0.3
    before = (RATE // 4 - WINDOW // 2) // HOP
    np.testing.assert_array_equal(whole[:before], StreamingFeatures().push(changed)[:before])


def test_a_tone_is_heard_in_its_band() -> None:
    for hertz in (300, 1000, 3000):
        tone = 0.1 * np.sin(2 * np.pi * hertz * np.arange(RATE // 2) / RATE)
        row = StreamingFeatures().push(tone)[20]
        middle = (mel_bank() * np.arange(WINDOW // 2 + 1)[:, None] * RATE / WINDOW).sum(axis=0) / mel_bank().sum(axis=0)
        assert len(row) == BANDS
        assert abs(middle[row.argmax()] - hertz) < 0.1 * hertz
