"""The colour of a voice changed over time: brighter or darker, breathier, louder without clipping."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["coloured", "limited"]

Floats = NDArray[np.float64]
_WINDOW = 0.032  # seconds
_BLOCK = 1024  # windows at a time, for the sake of memory
_LOW, _HIGH, _PIVOT = 300.0, 6000.0, 1000.0  # Hz: the tilt acts between the first two, about the third
_BREATH_FROM = 1500.0  # Hz: where breath is heard (Klatt & Klatt 1990: noise from the third formant up)
_NOISE_GAIN = float(np.sqrt(4 / 1.5))
"""Windows of noise overlap without adding up: Σ w² is 2 where they overlap fourfold, Σ w⁴ only 1.5."""
_KNEE, _CEILING = 0.7, 0.97  # of full scale


def coloured(samples: Floats, rate: int, tilt: Floats, breath: Floats, random: np.random.Generator) -> Floats:
    """Tilt and breath laid on a sound; its level stays.

    Parameters
    ----------
    samples : ndarray, shape (samples,)
    rate : int
    tilt : ndarray, shape (samples,)
        dB an octave, between 300 Hz and 6 kHz; above 0: brighter, as under effort.
    breath : ndarray, shape (samples,)
        0 to 1: the share of what sounds above 1.5 kHz that is noise.
    random : numpy.random.Generator

    Examples
    --------
    >>> sound = np.random.default_rng(1).normal(0, 0.1, 8000)
    >>> flat = np.zeros(8000)
    >>> bool(np.allclose(coloured(sound, 8000, flat, flat, np.random.default_rng(2)), sound))
    True
    """
    if not tilt.any() and not breath.any():
        return samples
    window = 2 * round(_WINDOW * rate / 2)
    hop = window // 4
    shape = np.sqrt(0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(window) + 0.5) / window))
    hertz = np.fft.rfftfreq(window, 1 / rate)
    octaves = np.log2(np.clip(hertz, _LOW, _HIGH) / _PIVOT)
    airy = np.clip((hertz - 0.7 * _BREATH_FROM) / (0.6 * _BREATH_FROM), 0, 1)
    padded = np.pad(samples, (window, 2 * window))
    starts = np.arange(0, len(samples) + window, hop)
    middles = np.clip(starts - window // 2, 0, len(samples) - 1)
    result = np.zeros(len(padded))
    for first in range(0, len(starts), _BLOCK):
        block = starts[first : first + _BLOCK]
        spectra = np.fft.rfft(padded[block[:, None] + np.arange(window)] * shape, axis=1)
        tilted = spectra * 10 ** (tilt[middles[first : first + _BLOCK], None] * octaves / 20)
        before, after = ((np.abs(some) ** 2).sum(axis=1, keepdims=True) for some in (spectra, tilted))
        tilted *= np.sqrt(np.clip((before + 1e-12) / (after + 1e-12), 0.05, 20))
        share = breath[middles[first : first + _BLOCK], None] * airy
        noise = _NOISE_GAIN * np.abs(tilted) * np.exp(2j * np.pi * random.random(spectra.shape))
        spectra = np.sqrt(1 - share) * tilted + np.sqrt(share) * noise
        for start, piece in zip(block, np.fft.irfft(spectra, window, axis=1) * shape, strict=True):
            result[start : start + window] += piece
    return np.asarray(result[window : window + len(samples)] / 2)


def limited(samples: Floats) -> Floats:
    """Peaks bent in so that nothing lies beyond full scale; what is under 0.7 stays as it is.

    Examples
    --------
    >>> limited(np.array([0.5, -2.0])).round(3).tolist()
    [0.5, -0.97]
    """
    over = np.abs(samples) - _KNEE
    room = _CEILING - _KNEE
    bent = _KNEE + room * np.tanh(np.maximum(over, 0) / room)
    return np.where(over > 0, np.sign(samples) * bent, samples)
