"""Tilt, breath and the bend at full scale."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.speech.timbre_shaping import coloured, limited

RATE = 16_000


def buzz() -> NDArray[np.float64]:
    times = np.arange(RATE) / RATE
    return np.asarray(sum(0.1 / n * np.sin(2 * np.pi * 125 * n * times) for n in range(1, 60)))


def octaves(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Level of the octaves from 500, 1000 and 2000 Hz, dB."""
    power = np.abs(np.fft.rfft(samples * np.hanning(len(samples)))) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / RATE)
    return np.array([10 * np.log10(power[(hertz >= f) & (hertz < 2 * f)].sum()) for f in (500, 1000, 2000)])


@pytest.mark.parametrize("tilt", [-3.0, 2.5])
def test_each_octave_gains_what_is_asked_and_the_whole_stays_as_loud(tilt: float) -> None:
    sound = buzz()
    moved = coloured(sound, RATE, np.full(RATE, tilt), np.zeros(RATE), np.random.default_rng(1))
    assert np.diff(octaves(moved) - octaves(sound)) == pytest.approx([tilt, tilt], abs=0.4)
    assert moved.std() == pytest.approx(sound.std(), rel=0.05)


def test_breath_is_noise_above_and_leaves_what_is_below() -> None:
    sound = buzz()
    moved = coloured(sound, RATE, np.zeros(RATE), np.full(RATE, 0.6), np.random.default_rng(1))
    spectrum = np.abs(np.fft.rfft(moved[:8000] * np.hanning(8000)))
    hertz = np.fft.rfftfreq(8000, 1 / RATE)

    def between_harmonics(low: float, high: float) -> float:
        inside = (hertz > low) & (hertz < high)
        tone = np.abs(hertz / 125 - np.round(hertz / 125)) < 0.1
        return float(20 * np.log10(np.median(spectrum[inside & ~tone]) / np.median(spectrum[inside & tone])))

    assert between_harmonics(2500, 4000) > between_harmonics(300, 900) + 15
    assert octaves(moved) == pytest.approx(octaves(sound), abs=1.0)


def test_only_where_it_is_asked_for() -> None:
    sound = buzz()
    tilt = np.where(np.arange(RATE) < RATE // 2, 0.0, 3.0)
    moved = coloured(sound, RATE, tilt, np.zeros(RATE), np.random.default_rng(1))
    assert moved[: RATE // 3] == pytest.approx(sound[: RATE // 3], abs=1e-9)


def test_what_is_loud_is_bent_in_what_is_soft_is_left() -> None:
    sound = np.linspace(-3, 3, 601)
    bent = limited(sound)
    assert np.abs(bent).max() < 1
    assert (np.diff(bent) >= 0).all()
    soft = np.abs(sound) <= 0.7
    assert np.array_equal(bent[soft], sound[soft])
