"""RASTA-PLP: what is heard of speech, without the channel it came through.

Perceptual linear prediction (Hermansky 1990, "Perceptual linear predictive (PLP) analysis of speech") on spectra that
were filtered over time (Hermansky, Morgan 1994, "RASTA processing of speech"): the sound features C of an anime node
(Cao et al. 2005, section 4.1). The steps, one function each:

1. power spectra of Hamming windows, 25 ms long, one every 10 ms; frame k is centred at k x 10 ms, and the sound is
   mirrored at its ends to fill the first and last windows;
2. `bark_weights`: energy in critical bands, one Bark apart;
3. RASTA: each band's logarithm passes H(z) = 0.1 (2 + z^-1 - z^-3 - 2 z^-4) / (1 - 0.94 z^-1), which lets changes of
   1 to 12 Hz through, as articulation makes them. A constant factor in a band (loudness, microphone, line, room tone)
   is a constant in the logarithm and is gone. The filter starts settled on the first frame. Its advance z^4 is
   left out: features come about 20 ms late, in all sounds alike;
4. equal loudness (the 40 phon curve) and intensity to loudness (cube root);
5. an all-pole model of that spectrum, by Levinson's recursion on its inverse Fourier transform (the autocorrelation);
6. `cepstrum_of`: its cepstrum, c0 the logarithm of the gain, the others lifted by k^0.6, as the ICSI tools give them.

Plain numpy, over all frames at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.long_arrays import let_go

__all__ = ["CEPSTRA", "RATE", "STEP", "WINDOW", "RastaPLP", "all_pole", "bark_weights", "cepstrum_of", "rasta_plp"]

RATE = 16_000
"""Samples per second at which is listened; other sounds are resampled first."""
WINDOW, STEP = 0.025, 0.010
"""Seconds of a window, and from one to the next."""
CEPSTRA = 9
"""Parameters of a frame: c0 to c8, of a model with eight poles."""
POLE = 0.94
LIFT = 0.6
QUIETEST = 1e-7
"""Share of the loudest band's energy under which a band counts as silent: keeps digital silence off the logarithm."""
_FFT = 512
_BLOCK = 1024  # frames per Fourier transform, so that an hour of sound needs little memory

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RastaPLP:
    """Features of a sound.

    Attributes
    ----------
    values : ndarray, shape (frames, 9)
    """

    values: Floats

    @property
    def times(self) -> Floats:
        """Seconds at the middle of each window, shape (frames,)."""
        return np.asarray(STEP * np.arange(len(self.values)), dtype=np.float64)

    def place(self, seconds: float) -> int:
        """The frame whose middle lies nearest to an instant; the first or last one beyond the ends.

        Examples
        --------
        >>> RastaPLP(np.zeros((101, 9))).place(0.5)
        50
        """
        return int(np.clip(round(seconds / STEP), 0, len(self.values) - 1))


def rasta_plp(audio: Audio, *, rasta: bool = True) -> RastaPLP:
    """First nine RASTA-PLP cepstra of a sound.

    Parameters
    ----------
    audio : Audio
        Of any rate.
    rasta : bool
        False leaves the filter over time out: plain PLP.

    Returns
    -------
    RastaPLP
        A frame every 10 ms, from the start of the sound up to its end.

    Examples
    --------
    >>> tone = Audio(0.1 * np.sin(np.arange(16000) * 0.3), 16000)
    >>> rasta_plp(tone).values.shape
    (101, 9)
    """
    energies = _band_energies(audio.resampled(RATE).samples)
    logs = np.log(energies, out=energies)
    if rasta:
        _filter(logs)
    values = np.empty((len(logs), CEPSTRA))
    for first in range(0, len(logs), _BLOCK):  # an hour is not held many times over
        here = slice(first, first + _BLOCK)
        heard = np.exp((logs[here] + np.log(_equal_loudness())) / 3)  # equal loudness, then the cube root
        heard[:, [0, -1]] = heard[:, [1, -2]]  # the outermost bands reach past the spectrum: their neighbours stand in
        values[here] = cepstrum_of(*all_pole(heard, CEPSTRA - 1))
    return RastaPLP(values)


def _band_energies(samples: NDArray[np.float32]) -> Floats:
    """Energy in each critical band, shape (frames, bands), never 0."""
    width, hop = round(WINDOW * RATE), round(STEP * RATE)
    half, mode = width // 2, "reflect" if len(samples) > width else "constant"
    shape, weights = np.hamming(width), bark_weights()
    energies = np.empty((1 + (len(samples) + 2 * half - width) // hop, len(weights)))
    for first in range(0, len(energies), _BLOCK):
        begin = first * hop - half
        end = begin + (min(_BLOCK, len(energies) - first) - 1) * hop + width
        more = min(max(begin, 0), width)  # so that there is enough to reflect at the end
        heard = samples[max(begin, 0) - more : min(end, len(samples))]
        beyond = max(-begin, 0), max(end - len(samples), 0)
        heard = np.pad(heard, beyond, mode=mode)[more:]  # type: ignore[call-overload]
        windows = np.lib.stride_tricks.sliding_window_view(heard, width)[::hop]
        energies[first : first + _BLOCK] = np.abs(np.fft.rfft(windows * shape, _FFT, axis=1)) ** 2 @ weights.T
        let_go(samples)
    least = max(QUIETEST * float(energies.max()), np.finfo(np.float64).tiny)
    return np.asarray(np.maximum(energies, least, out=energies))


def _bark(hertz: Floats) -> Floats:
    return np.asarray(6 * np.arcsinh(hertz / 600))


def _centres() -> Floats:
    """Middles of the critical bands in Bark, from 0 to half the rate, about one apart."""
    top = float(_bark(np.array(RATE / 2)))
    return np.linspace(0, top, round(top) + 1)


@cache
def bark_weights() -> Floats:
    """Critical bands as weights of power spectra, shape (bands, frequencies).

    Flat for half a Bark to each side of the middle, falling by 25 dB per Bark above and 10 dB per Bark below (Hermansky
    1990, Eq. 5).
    """
    off = _bark(np.asarray(np.fft.rfftfreq(_FFT, 1 / RATE), dtype=np.float64)) - _centres()[:, None]
    weights: Floats = 10 ** np.minimum(0, np.minimum(-2.5 * (off - 0.5), off + 0.5))
    return np.where((off >= -1.3) & (off <= 2.5), weights, 0.0)


def _equal_loudness() -> Floats:
    """Sensitivity of hearing at 40 phon in the middle of each band (Hermansky 1990, Eq. 6 up to 5 kHz)."""
    squared = (600 * np.sinh(_centres() / 6)) ** 2
    curve = (squared / (squared + 1.6e5)) ** 2 * (squared + 1.44e6) / (squared + 9.61e6)
    curve[0] = curve[1]  # at 0 Hz nothing is heard; the band is replaced by its neighbour in the end
    return np.asarray(curve)


def _filter(logs: Floats) -> None:
    """Filter over time, in place, as if the first frame had always lasted.

    0.1 (2 + z^-1 - z^-3 - 2 z^-4) / (1 - pole z^-1).

    Written out: importing scipy.signal for it takes longer than all else that a short sound needs.
    """
    past = np.repeat(logs[:1], 4, axis=0)
    held = np.zeros_like(logs[0])  # what a constant leaves behind: the numerator's terms add up to nothing
    for first in range(0, len(logs), _BLOCK):
        before = np.concatenate([past, logs[first : first + _BLOCK]])
        driven, past = 0.1 * (2 * before[4:] + before[3:-1] - before[1:-3] - 2 * before[:-4]), before[-4:]
        for place, now in enumerate(driven, start=first):
            held = now + POLE * held
            logs[place] = held


def all_pole(spectrum: Floats, order: int) -> tuple[Floats, Floats]:
    """All-pole models of power spectra given at equal steps from 0 to half the rate.

    Parameters
    ----------
    spectrum : ndarray, shape (frames, bands)
        Above 0.
    order : int
        Number of poles, below the number of bands.

    Returns
    -------
    poles : ndarray, shape (frames, order + 1)
        Coefficients a of the polynomial 1 + a_1 z^-1 + ..., a_0 = 1.
    gain : ndarray, shape (frames,)
        Power of the prediction error.

    Examples
    --------
    >>> poles, gain = all_pole(np.ones((1, 9)), 2)
    >>> bool(np.allclose(poles, [[1, 0, 0]])), bool(np.allclose(gain, 1))
    (True, True)
    """
    steps = 2 * (spectrum.shape[1] - 1)
    correlation = np.fft.irfft(spectrum, steps, axis=1)[:, : order + 1]
    poles = np.zeros((len(spectrum), order + 1))
    poles[:, 0] = 1.0
    error = correlation[:, 0].copy()
    for place in range(1, order + 1):  # Levinson and Durbin
        reflection = -(poles[:, :place] * correlation[:, place:0:-1]).sum(axis=1) / error
        poles[:, 1 : place + 1] += reflection[:, None] * poles[:, place - 1 :: -1][:, :place]
        error *= 1 - reflection**2
    return poles, error


def cepstrum_of(poles: Floats, gain: Floats) -> Floats:
    """Cepstrum of all-pole models, shape (frames, order + 1), lifted: c_k k^0.6.

    Examples
    --------
    >>> one_pole = np.array([[1.0, -0.5, 0.0]])        # its cepstrum is 0.5^k / k
    >>> (cepstrum_of(one_pole, np.ones(1)) / [1, 1, 2**0.6]).round(6).tolist()
    [[0.0, 0.5, 0.125]]
    """
    order = poles.shape[1] - 1
    values = np.zeros_like(poles)
    values[:, 0] = np.log(gain)
    for place in range(1, order + 1):
        before = np.arange(1, place)
        earlier = (before / place * values[:, 1:place] * poles[:, place - before]).sum(axis=1)
        values[:, place] = -poles[:, place] - earlier
    lift = np.arange(order + 1, dtype=np.float64) ** LIFT
    lift[0] = 1.0
    return np.asarray(values * lift)
