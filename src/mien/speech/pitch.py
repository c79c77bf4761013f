"""Pitch (fundamental frequency) and level of a voice over time.

Pitch by swift-f0, a small network (MIT) that comes with its wheel: nothing is fetched, nothing is kept in the home
folder. It answers differently to a quiet recording than to the same one louder: sound is brought to one level first.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.long_arrays import LONG, let_go, trim
from mien.speech.onnx_runtime import forbid_telemetry

if TYPE_CHECKING:
    import swift_f0

__all__ = ["QUIETEST", "LevelContour", "PitchContour", "level_contour", "pitch_contour"]

QUIETEST = -120.0
"""The level given to digital silence, dBFS."""

_RATE, _HOP = 16_000, 256
_LOWEST, _HIGHEST = 46.875, 2093.75
_VOICED = 0.5
_FRAMES_AT_ONCE = 2000
_BLOCK = 8 * _RATE  # samples that the network sees at once: more at once are no faster and take more memory
_PEAK, _MOST_GAIN = 0.5, 100.0


@dataclass(frozen=True, eq=False)
class PitchContour:
    """The pitch of a voice, frame by frame.

    Attributes
    ----------
    times : ndarray, shape (frames,)
        Centres of the frames, seconds from the start of the sound, 16 ms apart, the first at 0.
    hertz : ndarray, shape (frames,)
        Fundamental frequency; NaN where there is no voice.
    confidence : ndarray, shape (frames,)
        0 to 1: how sure it is that a voice sounds. A frame of 0.5 or more is voiced.

    Examples
    --------
    >>> hum = Audio(0.2 * np.sin(2 * np.pi * 220 * np.arange(16000) / 16000), 16000)
    >>> round(pitch_contour(hum).median)
    220
    """

    times: NDArray[np.float64]
    hertz: NDArray[np.float64]
    confidence: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.times)

    @property
    def voiced(self) -> NDArray[np.bool_]:
        """Where a voice sounds; shape (frames,)."""
        return np.isfinite(self.hertz)

    @property
    def median(self) -> float:
        """The middle pitch of the voiced frames in Hz; NaN where nothing is voiced."""
        return float(np.median(self.hertz[self.voiced])) if self.voiced.any() else float("nan")

    def semitones(self, reference: float | None = None) -> NDArray[np.float64]:
        """Semitones above a reference in Hz (None: the contour's own median); NaN where there is no voice."""
        base = self.median if reference is None else reference
        with np.errstate(invalid="ignore"):
            return np.asarray(12 * np.log2(self.hertz / base), dtype=np.float64)

    def hertz_at(self, times: ArrayLike) -> NDArray[np.float64]:
        """The pitch at any times in Hz, without gaps.

        Interpolated in semitones through what is unvoiced, held before the first and after the last voiced frame; NaN
        everywhere where nothing is voiced.
        """
        when = np.asarray(times, dtype=np.float64)
        if not self.voiced.any():
            return np.full(when.shape, np.nan)
        return np.exp(np.interp(when, self.times[self.voiced], np.log(self.hertz[self.voiced])))


@dataclass(frozen=True, eq=False)
class LevelContour:
    """How loud a sound is, frame by frame.

    Attributes
    ----------
    times : ndarray, shape (frames,)
        Centres of the windows, seconds from the start of the sound, evenly apart, the first at 0.
    decibels : ndarray, shape (frames,)
        Root of the mean square, dBFS (0 is full scale), not under `QUIETEST`.
    """

    times: NDArray[np.float64]
    decibels: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.times)

    def decibels_at(self, times: ArrayLike) -> NDArray[np.float64]:
        """The level at any times in dBFS, interpolated and held at the ends."""
        return np.asarray(np.interp(np.asarray(times, dtype=np.float64), self.times, self.decibels))


def pitch_contour(audio: Audio, lowest: float = 60.0, highest: float = 700.0) -> PitchContour:
    """The pitch of a voice over time (swift-f0).

    Parameters
    ----------
    audio : Audio
        At any rate and level.
    lowest, highest : float
        Where pitch is looked for, Hz; within 46.9 to 2093. A singer may need more than the default.

    Raises
    ------
    InputError
        If the range does not fit.
    """
    if not _LOWEST <= lowest < highest <= _HIGHEST:
        raise InputError(f"pitch is found from {_LOWEST:.1f} to {_HIGHEST:.1f} Hz, not from {lowest:g} to {highest:g}")
    global _last
    kept = _last
    if kept is not None and kept[0]() is audio and kept[1] == (lowest, highest):
        return kept[2]
    found = _contour(audio, lowest, highest)
    _last = (weakref.ref(audio), (lowest, highest), found)
    return found


_last: tuple[weakref.ref[Audio], tuple[float, float], PitchContour] | None = None
"""The sound that was asked for last: brows and head ask for the same one."""


def _contour(audio: Audio, lowest: float, highest: float) -> PitchContour:
    samples = audio.resampled(_RATE).samples
    loudest = max((float(np.abs(block).max()) for block in _blocks(samples)), default=0.0)
    if loudest == 0.0:
        times = _HOP / _RATE * np.arange(max(1, len(samples) // _HOP), dtype=np.float64)
        return PitchContour(times, np.full(len(times), np.nan), np.zeros(len(times)))
    gain, stream = np.float32(min(_PEAK / loudest, _MOST_GAIN)), _detector().stream(lowest, highest)
    found = [stream.push(block * gain, _RATE) for block in _blocks(samples)]
    found.append(stream.flush())
    hertz, confidence = (np.concatenate([getattr(part, name) for part in found]) for name in ("pitch_hz", "confidence"))
    hertz = np.where(confidence >= _VOICED, hertz, np.nan)
    if audio.duration >= LONG:  # what follows needs the room, and a network is loaded again in a tenth of a second
        del stream
        _detector.cache_clear()
        trim()
    return PitchContour(np.concatenate([part.timestamps for part in found]), hertz, confidence)


def _blocks(samples: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
    """A sound block by block; of a long one no more than that is in memory."""
    for start in range(0, len(samples), _BLOCK):
        yield samples[start : start + _BLOCK]
        let_go(samples)


def level_contour(audio: Audio, step: float = 0.016, window: float = 0.032) -> LevelContour:
    """The level of a sound over time.

    Parameters
    ----------
    audio : Audio
    step : float
        Seconds from one frame to the next; the default falls on the frames of `pitch_contour`.
    window : float
        Seconds that one frame looks at, centred on it. Samples outside the sound do not count.

    Examples
    --------
    >>> level_contour(Audio([0.5, -0.5] * 4000, 8000)).decibels.round(1)[:3].tolist()
    [-6.0, -6.0, -6.0]
    """
    if step <= 0 or window <= 0:
        raise InputError(f"a step and a window are longer than 0 s, not {step:g} and {window:g}")
    frames = max(1, int(np.floor(audio.duration / step + 1e-9)))
    times = step * np.arange(frames, dtype=np.float64)
    first = np.clip(np.round((times - window / 2) * audio.rate).astype(int), 0, len(audio))
    after = np.clip(np.round((times + window / 2) * audio.rate).astype(int), 0, len(audio))
    energy = np.empty(frames)
    for start in range(0, frames, _FRAMES_AT_ONCE):
        here = slice(start, start + _FRAMES_AT_ONCE)
        begin = first[here][0]
        total = np.concatenate(([0.0], np.cumsum(audio.samples[begin : after[here][-1]].astype(np.float64) ** 2)))
        energy[here] = total[after[here] - begin] - total[first[here] - begin]
        let_go(audio.samples)
    power = energy / np.maximum(after - first, 1)
    return LevelContour(times, 10 * np.log10(np.maximum(power, 10 ** (QUIETEST / 10))))


@lru_cache(maxsize=1)
def _detector() -> swift_f0.SwiftF0:
    forbid_telemetry()
    import swift_f0

    return swift_f0.SwiftF0(threads=1, spin=False)
