"""One recording as another microphone in another room would have it, and as a slightly other voice would say it.

A classifier that learns from one studio needs it: without it, it learns the studio.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio

__all__ = ["varied"]

_RATE = 16_000
_Array = NDArray[np.float64]


def varied(audio: Audio, random: np.random.Generator) -> Audio:
    """A variation of a recording, at 16 kHz.

    Pitch and resonances move by up to 1.5 semitones (by resampling: the pace moves with them); a random filter colours
    the sound; seven in ten get noise 15 to 45 dB down, five in ten a short reverberation; silence with noise of up to
    a second stands on either side; peaks lie between -30 dB and full scale.
    """
    import soxr

    samples = audio.resampled(_RATE).samples.astype(np.float64)
    samples = soxr.resample(samples, _RATE, round(_RATE * 2 ** (random.uniform(-1.5, 1.5) / 12)))
    samples = _coloured(samples, random)
    size = max(float(samples.std()), 1e-6)
    if random.random() < 0.7:
        samples = samples + random.normal(size=len(samples)) * size * _factor(-random.uniform(15, 45))
    if random.random() < 0.5:
        samples = _echoing(samples, random)
    before, after = (
        random.normal(size=round(_RATE * random.uniform(0, 1))) * size * _factor(-random.uniform(40, 60))
        for _ in range(2)
    )
    samples = np.concatenate([before, samples, after])
    return Audio(samples / max(np.abs(samples).max(), 1e-6) * _factor(-random.uniform(0.1, 30)), _RATE)


def _factor(decibels: float) -> float:
    return float(10 ** (decibels / 20))


def _coloured(samples: _Array, random: np.random.Generator) -> _Array:
    from scipy.signal import firwin2, lfilter

    hertz = np.array([0, 100, 300, 1000, 3000, 5000, 8000])
    gains = np.concatenate(([-random.uniform(0, 20)], random.normal(-2.5, 3, 1), random.normal(0, 2.5, 5)))
    return np.asarray(lfilter(firwin2(257, hertz / 8000, 10 ** (gains / 20)), [1.0], samples))


def _echoing(samples: _Array, random: np.random.Generator) -> _Array:
    from scipy.signal import fftconvolve

    length = round(_RATE * random.uniform(0.05, 0.3))
    tail = random.normal(size=length) * np.exp(-6.9 * np.arange(length) / length)
    tail *= random.uniform(0.05, 0.4) / np.sqrt((tail**2).sum())
    tail[0] = 1.0
    return np.asarray(fftconvolve(samples, tail)[: len(samples)])
