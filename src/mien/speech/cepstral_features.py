"""The features of Cao et al. 2005 (section 6): mean, variance, RMS and the real cepstrum of the whole sound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio

__all__ = ["cepstral_features"]

_RATE = 16_000
_SMALLEST = 1e-10


def cepstral_features(audio: Audio, coefficients: int = 500) -> NDArray[np.float64]:
    """Mean, variance, RMS, and the first coefficients of the real cepstrum, at 16 kHz; shape (3 + coefficients,).

    The real cepstrum is the inverse Fourier transform of the logarithm of the spectrum's size, here of the whole sound
    at once, as the paper has it.

    Parameters
    ----------
    audio : Audio
    coefficients : int
        A sound with fewer has zeros for the rest.

    Examples
    --------
    >>> cepstral_features(Audio([0.5, -0.5] * 400, 16000), 50)[:3].tolist()
    [0.0, 0.25, 0.5]
    """
    samples = audio.resampled(_RATE).samples.astype(np.float64)
    found = np.zeros(3 + coefficients)
    if not len(samples):
        return found
    found[:3] = samples.mean(), samples.var(), np.sqrt((samples**2).mean())
    cepstrum = np.fft.irfft(np.log(np.abs(np.fft.rfft(samples)) + _SMALLEST), len(samples))[:coefficients]
    found[3 : 3 + len(cepstrum)] = cepstrum
    return found
