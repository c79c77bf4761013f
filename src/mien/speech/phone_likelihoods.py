"""What Gaussian mixtures learned from many speakers say of each row: the acoustic model that pocketsphinx brings.

Its mixtures of context-independent phones (128 densities of each phone, three streams: mel cepstra, their slopes, and
the slopes of these) are read from pocketsphinx's files and evaluated on a stream. They know hundreds of real voices;
the network of `mien.speech.frame_classifier`, which was learned from few, takes their scores as a part of what it
sees.
Features as CMU Sphinx makes them: 25 mel bands from 130 to 6800 Hz, noise removed (`noise_floor`), 13 liftered cepstra,
minus their running mean.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import MissingPartError
from mien.core.utterance import PAUSE
from mien.speech.noise_floor import NoiseFloor
from mien.text.phones import phone_table
from mien.text.pronunciation import pocketsphinx_model

__all__ = ["LAG", "PhoneLikelihoods", "PhoneMixtures", "likelihood_labels", "mixtures"]

LAG = 3
"""Rows by which the scores come late: slopes need three rows after the one that they belong to."""

_BANDS, _CEPSTRA, _LIFTER = 25, 13, 22
_LOWEST, _HIGHEST = 130.0, 6800.0
_STATES = 3
_LOG_STEP = 1024 * np.log(1.0001)  # one step of a stored weight
_DEEPEST = 60.0  # scores lie at most so far below the best (natural logarithm)
_SCALE = 32768.0
_MEAN_TIME, _MEAN_TRUST = 300.0, 30.0  # rows
_USUAL = np.array([41.0, -5.29, -0.12, 5.09, 2.48, -4.07, -1.37, -1.78, -5.08, -2.05, -6.45, -1.42, 1.17])
_AUDIBLE = 0.5  # share of a row's power that lies above the noise for the row to count for the mean

Floats = NDArray[np.float64]
Single = NDArray[np.float32]


@cache
def likelihood_labels() -> tuple[str, ...]:
    """The pause and the 39 phones, in the order of the columns."""
    return (PAUSE, *sorted(phone_table()))


@dataclass(frozen=True, eq=False)
class PhoneMixtures:
    """Diagonal Gaussians of each phone, as two products need them."""

    densities: Single
    """Coefficients of squares, values and 1, shape (streams, 2 * 13 + 1, phones * densities)."""
    weights: Single
    """Of the densities in the states, shape (streams, phones, densities, states)."""

    def scores(self, features: Single) -> Single:
        """Log likelihood of each phone's likeliest state, shape (rows, phones); features (rows, streams, 13)."""
        phones, number = self.weights.shape[1:3]
        total = np.zeros((phones, len(features), _STATES), np.float32)
        for stream, (densities, weights) in enumerate(zip(self.densities, self.weights, strict=True)):
            value = features[:, stream]
            seen = np.concatenate([value * value, value, np.ones((len(value), 1), np.float32)], axis=1)
            near = (seen @ densities).reshape(len(value), phones, number)
            best = near.max(axis=2, keepdims=True)
            near -= best
            np.exp(near, out=near)
            total += best.swapaxes(0, 1) + np.log(near.swapaxes(0, 1) @ weights + np.float32(1e-30))
        return np.asarray(total.max(axis=2).T)


@cache
def mixtures() -> PhoneMixtures:
    """The mixtures of the installed pocketsphinx.

    Raises
    ------
    MissingPartError
        If it is not installed, or its model is not of the form that is known.
    """
    folder = pocketsphinx_model() / "en-us"
    try:
        means, variances = (_densities(folder / name) for name in ("means", "variances"))
        names = _phone_names(folder / "mdef")
        stored = (folder / "sendump").read_bytes()
    except (OSError, ValueError, struct.error) as problem:
        raise MissingPartError(
            f"the acoustic model of pocketsphinx cannot be read ({problem}): install 5.1"
        ) from problem
    streams, densities = means.shape[1:3]
    senones = np.frombuffer(stored, np.uint8)
    count = _senones(folder / "mdef")
    senones = senones[-count * streams * densities :].reshape(streams, densities, count)
    order = np.array([names.index(label) for label in likelihood_labels()])
    states = order[:, None] * _STATES + np.arange(_STATES)
    weights = np.exp(-_LOG_STEP * senones[:, :, states].transpose(0, 2, 1, 3).astype(np.float64))
    mean, variance = (values[order].transpose(1, 3, 0, 2) for values in (means, np.maximum(variances, 1e-4)))
    constant = -0.5 * ((mean**2 / variance) + np.log(2 * np.pi * variance)).sum(axis=1, keepdims=True)
    found = np.concatenate([-0.5 / variance, mean / variance, constant], axis=1).reshape(streams, 2 * _CEPSTRA + 1, -1)
    return PhoneMixtures(found.astype(np.float32), weights.astype(np.float32))


def _densities(path: Path) -> Floats:
    """A Sphinx-3 file of means or variances, shape (phones, streams, densities, 13)."""
    content = path.read_bytes()
    place = content.index(b"endhdr\n") + 7
    order, phones, streams, densities, *lengths = struct.unpack_from("<4i3i", content, place)
    if order != 0x11223344 or streams != 3 or lengths != [_CEPSTRA] * 3:
        raise ValueError(f"{path.name} is of an unknown form")
    values = np.frombuffer(content, "<f4", phones * streams * densities * _CEPSTRA, place + 32)
    return values.reshape(phones, streams, densities, _CEPSTRA).astype(np.float64)


def _definition(path: Path) -> tuple[bytes, int]:
    content = path.read_bytes()
    if content[:4] != b"BMDF":
        raise ValueError(f"{path.name} is of an unknown form")
    return content, 12 + struct.unpack_from("<i", content, 8)[0]


def _senones(path: Path) -> int:
    content, place = _definition(path)
    return int(struct.unpack_from("<5i", content, place)[4])


def _phone_names(path: Path) -> list[str]:
    content, place = _definition(path)
    count = struct.unpack_from("<i", content, place)[0]
    return [name.decode("ascii") for name in content[place + 40 :].split(b"\0", count)[:count]]


@cache
def _bank(size: int, rate: int, warp: float) -> Floats:
    """Triangles of unit area whose corners lie on bins, shape (size // 2 + 1, bands)."""
    hertz = np.fft.rfftfreq(size, 1 / rate)
    step = rate / size
    lowest, highest = (2595 * np.log10(1 + f / 700) for f in (_LOWEST, _HIGHEST))
    corners = 700 * (10 ** (np.linspace(lowest, highest, _BANDS + 2) / 2595) - 1) * warp
    corners = np.floor(corners / step + 0.5) * step
    low, middle, high = corners[:-2], corners[1:-1], corners[2:]
    rising, falling = (hertz[:, None] - low) / (middle - low), (high - hertz[:, None]) / (high - middle)
    return np.asarray(np.clip(np.minimum(rising, falling), 0, None) * 2 / (high - low))


@cache
def _cosines() -> Floats:
    """The cosine transform from bands to liftered cepstra, shape (bands, cepstra)."""
    numbers, places = np.arange(_CEPSTRA), np.arange(_BANDS)[:, None] + 0.5
    size = np.where(numbers == 0, np.sqrt(1 / _BANDS), np.sqrt(2 / _BANDS))
    lift = 1 + _LIFTER / 2 * np.sin(np.pi * numbers / _LIFTER)
    return np.asarray(np.cos(np.pi * numbers * places / _BANDS) * size * lift)


class PhoneLikelihoods:
    """Scores of the phones from rows of power spectra that come in pieces.

    Parameters
    ----------
    size, rate : int
        Of the Fourier transforms, and the sound's samples a second.
    warp : float
        > 1 hears a shorter throat.
    """

    def __init__(self, size: int, rate: int, warp: float = 1.0) -> None:
        self._bank = _bank(size, rate, warp)
        self.floor = NoiseFloor(_BANDS)
        self._sum, self._weight = _USUAL * _MEAN_TRUST, _MEAN_TRUST
        self._cepstra = np.zeros((0, _CEPSTRA))

    def push(self, powers: Floats) -> Single:
        """Scores below the best of each row, `LAG` rows late: shape (rows, phones), 0 down to -60.

        Parameters
        ----------
        powers : ndarray, shape (rows, size // 2 + 1)
            Of windows of sound in -1..1, its high notes lifted.
        """
        bands = powers @ (self._bank * _SCALE**2)
        clean = self.floor.push(bands)
        heard = clean.sum(axis=1) > _AUDIBLE * bands.sum(axis=1)
        cepstra = np.log(clean + 1e-4) @ _cosines()
        for row, counts in zip(cepstra, heard.tolist(), strict=True):
            if counts:
                keep = 1 - 1 / _MEAN_TIME
                self._sum, self._weight = self._sum * keep + row, self._weight * keep + 1
            row -= self._sum / self._weight
        if not len(self._cepstra):
            self._cepstra = np.repeat(cepstra[:1], 2 * LAG, axis=0)
        held = np.concatenate([self._cepstra, cepstra])
        self._cepstra = held[-2 * LAG :]
        at = [held[place : len(cepstra) + place] for place in range(2 * LAG + 1)]
        features = np.stack([at[3], at[5] - at[1], (at[6] - at[2]) - (at[4] - at[0])], axis=1)
        scores = mixtures().scores(features.astype(np.float32))
        return np.asarray(np.maximum(scores - scores.max(axis=1, keepdims=True), -_DEEPEST))
