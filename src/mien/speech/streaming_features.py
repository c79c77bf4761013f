"""What a live recogniser hears, using nothing but the past, however the sound is cut into pieces.

Every 10 ms one row of `COLUMNS` numbers is made of 25 ms of sound at 16 kHz: `BANDS` log energies of mel bands, minus a
running mean over the louder instants (the voice and the microphone; a fifth of it is taken as one number for all
bands, so that a hiss does not become a voice), then the level against the recent loudest and the recent quietest, then
what `phone_likelihoods` says of the sound without its noise, `LAG` rows late.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.speech.phone_likelihoods import LAG, PhoneLikelihoods, likelihood_labels

__all__ = ["BANDS", "CENTRE", "COLUMNS", "HOP", "LAG", "RATE", "WINDOW", "StreamingFeatures", "mel_bank"]

RATE, WINDOW, HOP = 16_000, 400, 160
BANDS = 40
COLUMNS = BANDS + 2 + len(likelihood_labels())
CENTRE = WINDOW / 2 / RATE
"""Seconds from the start of the sound to the middle of row 0; row ``i`` stands at ``CENTRE + i * HOP / RATE``."""

_SIZE = 512
_LOWEST, _HIGHEST = 60.0, 7600.0  # Hz; below lie hum and offset
_EMPHASIS = 0.97
_OFFSET_END = 20.0  # Hz: slower motion is no sound
_CHUNK = 128
_FLOOR = 1e-7  # power of a band below which nothing is heard: about the step of 16-bit sound
# Natural logarithms of power, as speech at a usual level has them; what is believed before anything is heard.
_USUAL_PEAK, _USUAL_FLOOR = -4.0, -12.0
_PEAK_RISE, _PEAK_FALL, _FLOOR_FALL, _FLOOR_RISE, _MEAN_TIME = 0.05, 4.0, 0.1, 8.0, 2.0  # seconds
_PEAK_FIRST_FALL = 0.3  # seconds: the first belief about the level is given up sooner than what was heard
_NEAR_FLOOR, _BELOW_PEAK, _STEEPNESS = 2.0, 2.5, 1.5
_MOST_GAIN = 7.0  # how far a quiet voice is raised (30 dB): else its weak sounds are below the least that is heard
_DEEPEST = 12.0  # the quietest is not believed to lie further below the loudest: sound may begin after true silence
_SHARE = 0.8
_MEAN_TRUST = 20.0  # rows that the first belief about the mean is worth

Floats = NDArray[np.float64]


@cache
def mel_bank(warp: float = 1.0) -> Floats:
    """Triangles on the mel scale, each with sum 1, shape (257, bands); ``warp`` > 1 moves them up: a shorter throat."""
    hertz = np.fft.rfftfreq(_SIZE, 1 / RATE)
    lowest, highest = (2595 * np.log10(1 + f / 700) for f in (_LOWEST, _HIGHEST))
    edges = np.linspace(lowest, highest, BANDS + 2)
    corners = 700 * (10 ** (edges / 2595) - 1) * warp
    rising = (hertz[:, None] - corners[:-2]) / (corners[1:-1] - corners[:-2])
    falling = (corners[2:] - hertz[:, None]) / (corners[2:] - corners[1:-1])
    bank = np.clip(np.minimum(rising, falling), 0, None)
    return np.asarray(bank / np.maximum(bank.sum(axis=0), 1e-9))


class StreamingFeatures:
    """Rows from samples that come in pieces.

    Parameters
    ----------
    warp : float
        Of `mel_bank`; other than 1 to learn from voices that were not recorded.

    Examples
    --------
    >>> sound = np.random.default_rng(1).normal(0, 0.1, 4000)
    >>> whole, pieces = StreamingFeatures(), StreamingFeatures()
    >>> rows = whole.push(sound)
    >>> rows.shape
    (23, 82)
    >>> bool(np.allclose(rows, np.concatenate([pieces.push(part) for part in np.split(sound, 10)])))
    True
    """

    def __init__(self, warp: float = 1.0) -> None:
        self._bank = mel_bank(warp)
        self._likelihoods = PhoneLikelihoods(_SIZE, RATE, warp)
        self._kept = np.zeros(0)
        self._before: Floats | None = None
        self._last = 0.0
        self._peak, self._floor, self._spoken = _USUAL_PEAK, _USUAL_FLOOR, 0.0
        self._sum, self._weight = np.full(BANDS, _USUAL_PEAK - 1.0) * _MEAN_TRUST, _MEAN_TRUST

    def push(self, samples: NDArray[np.floating]) -> Floats:
        """Take samples (16 kHz, -1..1) and give the rows that they complete, shape (rows, columns)."""
        samples = np.asarray(samples, dtype=np.float64)
        if not len(samples):
            return np.zeros((0, COLUMNS))
        held = np.concatenate([self._kept, self._sharpened(samples)])
        count = max(0, (len(held) - WINDOW) // HOP + 1)
        self._kept = held[count * HOP :]
        if not count:
            return np.zeros((0, COLUMNS))
        windows = np.lib.stride_tricks.sliding_window_view(held, WINDOW)[: count * HOP : HOP]
        power = np.abs(np.fft.rfft(windows * _hamming(), _SIZE)) ** 2
        return np.concatenate([self._normalised(power @ self._bank), self._likelihoods.push(power)], axis=1)

    def _sharpened(self, samples: NDArray[np.floating]) -> Floats:
        """Without an offset, and with the high notes lifted: (1 - z^-1) (1 - emphasis z^-1) / (1 - pole z^-1)."""
        if self._before is None:  # as if the first sample had stood there for long
            self._before, self._last = np.repeat(samples[:1], 2), 0.0
        held = np.concatenate([self._before, samples])
        self._before = held[-2:]
        steps = held[2:] - (1 + _EMPHASIS) * held[1:-1] + _EMPHASIS * held[:-2]
        triangle, decay = _recursion()
        found = np.zeros(-(-len(steps) // _CHUNK) * _CHUNK)
        found[: len(steps)] = steps
        found = found.reshape(-1, _CHUNK) @ triangle
        for place in range(len(found)):
            found[place] += self._last * decay
            self._last = float(found[place, -1])
        sharpened = found.reshape(-1)[: len(steps)]
        self._last = float(sharpened[-1])
        return np.asarray(sharpened)

    def _normalised(self, powers: Floats) -> Floats:
        rows = np.empty((len(powers), BANDS + 2))
        levels = np.log(powers + _FLOOR * math.exp(-_MOST_GAIN)).mean(axis=1)
        for row, power, level in zip(rows, powers, levels.tolist(), strict=True):
            self._follow(level)
            gain = min(max(_USUAL_PEAK - self._peak, 0.0), _MOST_GAIN)
            log = np.log(power * math.exp(gain) + _FLOOR)
            loud = 1 / (1 + math.exp(-_STEEPNESS * (level - self._peak + _BELOW_PEAK)))
            self._sum = self._sum * _KEEP_MEAN + loud * log
            self._weight = self._weight * _KEEP_MEAN + loud
            mean = self._sum / self._weight
            row[:BANDS] = log - _SHARE * mean - (1 - _SHARE) * mean.mean()
            row[BANDS:] = level - self._peak, level - max(self._floor, self._peak - _DEEPEST)
        return rows

    def _follow(self, level: float) -> None:
        """Move the recent loudest and quietest levels; the loudest stays where nothing but background is heard."""
        if level > self._peak:
            self._peak += (level - self._peak) * _rate(_PEAK_RISE)
        elif level > self._floor + _NEAR_FLOOR:
            self._spoken += HOP / RATE
            self._peak += (level - self._peak) * _rate(min(_PEAK_FIRST_FALL + self._spoken, _PEAK_FALL))
        self._floor += (level - self._floor) * _rate(_FLOOR_FALL if level < self._floor else _FLOOR_RISE)


@cache
def _recursion() -> tuple[Floats, Floats]:
    """What each of `_CHUNK` inputs adds to each output after it, and what the last output before them adds."""
    pole = math.exp(-2 * math.pi * _OFFSET_END / RATE)
    after = np.arange(_CHUNK) - np.arange(_CHUNK)[:, None]
    decay = pole ** np.arange(1.0, _CHUNK + 1)
    return np.asarray(np.where(after >= 0, pole ** np.maximum(after, 0.0), 0.0)), np.asarray(decay)


@cache
def _hamming() -> Floats:
    return np.hamming(WINDOW)


def _rate(seconds: float) -> float:
    return 1 - math.exp(-HOP / RATE / seconds)


_KEEP_MEAN = math.exp(-HOP / RATE / _MEAN_TIME)
