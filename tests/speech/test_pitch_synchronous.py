"""Periods laid down elsewhere: the pitch asked for, the times asked for, formants where they were."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.speech.pitch import pitch_contour
from mien.speech.pitch_synchronous import pitch_marks, repitched

RATE = 16_000


def vowel(hertz: float = 150.0, seconds: float = 1.0) -> NDArray[np.float64]:
    """Pulses through one resonance at 700 Hz."""
    from scipy.signal import lfilter

    pulses = np.zeros(round(seconds * RATE))
    pulses[(np.arange(0, seconds, 1 / hertz) * RATE).round().astype(int)] = 1.0
    pole = np.exp(-np.pi * 90 / RATE + 2j * np.pi * 700 / RATE)
    return np.asarray(0.1 * lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], pulses))


def formant(samples: NDArray[np.float64]) -> float:
    """Centre of the spectrum's envelope between 300 and 1500 Hz."""
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples)))) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / RATE)
    inside = (hertz > 300) & (hertz < 1500)
    return float((hertz * spectrum)[inside].sum() / spectrum[inside].sum())


def shaped(samples: NDArray[np.float64], factor: float, longer: float = 1.0) -> NDArray[np.float64]:
    marks = pitch_marks(samples, RATE, pitch_contour(Audio(samples, RATE)))
    ends = np.array([0.0, len(samples) / RATE])
    return repitched(samples, RATE, marks, ends, ends * longer, np.full(2, factor))


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.4])
def test_pitch_moves_and_formants_stay(factor: float) -> None:
    moved = shaped(vowel(), factor)
    assert pitch_contour(Audio(moved, RATE)).median == pytest.approx(150 * factor, rel=0.02)
    assert formant(moved) == pytest.approx(formant(vowel()), rel=0.05)


@pytest.mark.parametrize("longer", [0.7, 1.5])
def test_time_moves_and_pitch_stays(longer: float) -> None:
    moved = shaped(vowel(), 1.0, longer)
    assert len(moved) == round(longer * RATE)
    assert pitch_contour(Audio(moved, RATE)).median == pytest.approx(150, rel=0.02)


def test_what_is_not_changed_stays_nearly_as_it_is() -> None:
    sound = vowel()
    middle = slice(RATE // 4, 3 * RATE // 4)
    assert np.corrcoef(shaped(sound, 1.0)[middle], sound[middle])[0, 1] > 0.999


def test_only_the_stretch_that_is_asked_for() -> None:
    sound = vowel(seconds=2.0)
    marks = pitch_marks(sound, RATE, pitch_contour(Audio(sound, RATE)))
    times = np.array([0.0, 0.95, 1.05, 2.0])
    moved = repitched(sound, RATE, marks, times, times, np.array([1.0, 1.0, 1.3, 1.3]))
    found = pitch_contour(Audio(moved, RATE))
    early, late = (float(np.nanmedian(found.hertz[part])) for part in (found.times < 0.9, found.times > 1.1))
    assert (early, late) == pytest.approx((150, 195), rel=0.02)


def test_noise_and_silence_are_stretched_too() -> None:
    noise = np.random.default_rng(1).normal(0, 0.05, RATE)
    longer = shaped(noise, 1.3, 1.5)
    assert len(longer) == round(1.5 * RATE)
    assert longer[RATE // 4 : -RATE // 4].std() == pytest.approx(0.05, rel=0.2)
    spectrum = np.abs(np.fft.rfft(longer * np.hanning(len(longer))))
    assert spectrum.max() < 8 * np.median(spectrum)  # no tone
    assert not shaped(np.zeros(RATE), 1.3, 1.5).any()
