"""`Audio`: one channel of sound; reading it from nearly anything, resampling and writing it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError
from mien.core.long_arrays import LONG, let_go, long_array, trim

__all__ = ["MAX_RATE", "MIN_RATE", "Audio"]

MIN_RATE, MAX_RATE = 1000, 384_000
_STEP = 2.0**-23
_BLOCK = 2**20


@dataclass(frozen=True, eq=False)
class Audio:
    """One channel of sound.

    Samples are float32 in [-1, 1) on the grid of 24-bit sound, so that every lossless format keeps them exactly.

    Parameters
    ----------
    samples : array_like, shape (n,)
        Rounded to the 24-bit grid; values outside [-1, 1) are clipped.
    rate : int
        Samples per second.

    Examples
    --------
    >>> Audio([0.0, 0.5, -0.5, 0.0], 8000).duration
    0.0005
    """

    samples: NDArray[np.float32]
    rate: int

    def __init__(self, samples: ArrayLike, rate: int) -> None:
        array = np.asarray(samples)
        if array.dtype != np.float32:
            array = array.astype(np.float64, copy=False)
        if array.ndim != 1:
            raise InputError(f"sound has one channel here, got an array of shape {array.shape}")
        if not MIN_RATE <= rate <= MAX_RATE:
            raise InputError(f"a sample rate lies between {MIN_RATE} and {MAX_RATE} Hz, not {rate}")
        self._take(array, rate, np.empty(len(array), dtype=np.float32))

    def _take(self, array: NDArray[Any], rate: int, grid: NDArray[np.float32]) -> None:
        for start in range(0, len(array), _BLOCK):  # an hour at once would need a gigabyte besides
            block = array[start : start + _BLOCK].astype(np.float64)
            if not np.isfinite(block).all():
                bad = start + _first_bad(block)
                raise InputError(f"sound holds numbers that are not finite, first at sample {bad}")
            grid[start : start + _BLOCK] = np.clip(np.round(block / _STEP) * _STEP, -1.0, 1.0 - _STEP)
            let_go(grid)
        grid.setflags(write=False)
        object.__setattr__(self, "samples", grid)
        object.__setattr__(self, "rate", int(rate))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Audio) and self.rate == other.rate and np.array_equal(self.samples, other.samples)

    def __len__(self) -> int:
        return len(self.samples)

    @property
    def duration(self) -> float:
        """Length in seconds."""
        return len(self.samples) / self.rate

    @classmethod
    def taking(cls, samples: NDArray[np.float32], rate: int) -> Audio:
        """A sound that takes an array over, rounding it in place: an hour is not held twice.

        Examples
        --------
        >>> own = np.array([0.0, 0.5], np.float32)
        >>> Audio.taking(own, 8000).samples is own
        True
        """
        found = cls.__new__(cls)
        found._take(samples, rate, samples)
        return found

    @classmethod
    def silence(cls, seconds: float, rate: int) -> Audio:
        """Nothing to hear for a while."""
        return cls(np.zeros(round(seconds * rate)), rate)

    @classmethod
    def join(cls, pieces: Sequence[Audio]) -> Audio:
        """Pieces of one rate, one after another."""
        rates = {piece.rate for piece in pieces}
        if len(rates) != 1:
            raise InputError(f"sounds to be joined share one sample rate, got {sorted(rates)}")
        return cls(np.concatenate([piece.samples for piece in pieces]), rates.pop())

    def resampled(self, rate: int) -> Audio:
        """The same sound at another rate (band-limited, soxr's high quality)."""
        if rate == self.rate:
            return self
        import soxr

        if self.duration < LONG:
            return Audio.taking(soxr.resample(self.samples, self.rate, rate, quality="HQ"), rate)
        stream, done = soxr.ResampleStream(self.rate, rate, 1, quality="HQ"), 0
        found = long_array(math.ceil(len(self.samples) * rate / self.rate) + 1)
        for start in range(0, len(self.samples), _BLOCK):
            last = start + _BLOCK >= len(self.samples)
            made = stream.resample_chunk(self.samples[start : start + _BLOCK], last=last)[: len(found) - done]
            found[done : done + len(made)] = made
            done += len(made)
            let_go(found)
            self.rest()
        return Audio.taking(found[:done], rate)

    def rest(self) -> None:
        """Say that a long sound is not looked at for now, and give back what memory is free; others stay as they are.

        Examples
        --------
        >>> Audio([0.0, 0.5], 8000).rest()
        """
        if self.duration >= LONG:
            let_go(self.samples)
            trim()

    def is_silent(self, threshold_db: float = -72.0) -> bool:
        """Whether no 20 ms stretch is louder than ``threshold_db`` dBFS (RMS)."""
        window = max(1, self.rate // 50)
        blocks = len(self.samples) // window
        body = self.samples[: blocks * window].reshape(blocks, window) if blocks else self.samples[None, :]
        power = 0.0
        for start in range(0, len(body) if self.samples.size else 0, 1000):
            power = max(power, (body[start : start + 1000].astype(np.float64) ** 2).mean(axis=1).max())
            let_go(self.samples)
        return bool(np.sqrt(power) < 10 ** (threshold_db / 20))

    def write(self, path: str | Path) -> None:
        """Write to a lossless file; the suffix (.wav or .flac) picks the format. 24 bit."""
        import soundfile

        soundfile.write(str(path), self.samples, self.rate, subtype="PCM_24")


def _first_bad(array: NDArray[np.float64]) -> int:
    return int(np.argmin(np.isfinite(array)))
