"""Speech made slower or faster, higher or lower, louder or softer over stretches, after it was spoken.

No engine has to know how: the sound is stretched by WSOLA (Verhelst & Roelands 1993: windows are moved to where they
continue the last one best), pitch is changed by stretching and playing at another speed, so formants move along. Words
and phones keep to the sound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance

__all__ = ["Change", "reshape", "stretched"]

Floats = NDArray[np.float64]
_WINDOW, _SEARCH = 0.030, 0.008  # seconds
_RAMP = 0.015  # seconds over which a gain sets in
_FINER = 4  # times over-sampled before playing at another speed


@dataclass(frozen=True)
class Change:
    """How a stretch of speech is to differ.

    Attributes
    ----------
    start, end : float
        Seconds.
    rate : float
        2: twice as fast.
    pitch : float
        Semitones.
    volume : float
        Decibels.
    """

    start: float
    end: float
    rate: float = 1.0
    pitch: float = 0.0
    volume: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.start <= self.end:
            raise InputError(f"a stretch of speech runs forward in time, not from {self.start:g} to {self.end:g} s")
        if not 0.2 <= self.rate <= 5 or not -24 <= self.pitch <= 24:
            raise InputError(f"a rate lies in 0.2..5, a pitch in -24..24 semitones, not {self.rate:g}, {self.pitch:g}")


def reshape(utterance: Utterance, changes: Sequence[Change]) -> Utterance:
    """An utterance with changes made to it; stretches that overlap multiply.

    Examples
    --------
    >>> from mien.core.timeline import Interval, Tier
    >>> phones = Tier("phones", (Interval(0.0, 1.0, "AA"),))
    >>> said = Utterance("ah", Audio.silence(1.0, 8000), Tier("words", ()), phones, "en-US", "aligned")
    >>> reshape(said, [Change(0.5, 1.0, rate=0.5)]).duration
    1.5
    """
    changes = [change for change in changes if change.end > change.start]
    if not changes:
        return utterance
    audio = utterance.audio
    edges = sorted({0.0, audio.duration, *(min(t, audio.duration) for c in changes for t in (c.start, c.end))})
    middles = (np.array(edges[:-1]) + edges[1:]) / 2
    rate, pitch = np.ones(len(middles)), np.ones(len(middles))
    for change in changes:
        inside = (middles > change.start) & (middles < change.end)
        rate[inside] *= change.rate
        pitch[inside] *= 2 ** (change.pitch / 12)
    old = np.array(edges)
    new = np.concatenate([[0.0], np.cumsum(np.diff(old) / rate)])
    samples = _gained(audio, changes)
    if (rate != 1).any() or (pitch != 1).any():
        samples = _replayed(samples, audio.rate, old, rate, pitch)
    peak = np.abs(samples).max(initial=0.0)
    sound = Audio(samples / max(1.0, peak / 0.999), audio.rate)

    def moved(tier: Tier) -> Tier:
        times = [np.interp([item.start, item.end], old, new) for item in tier]
        pairs = zip(times, tier, strict=True)
        return Tier(tier.name, tuple(Interval(float(a), min(float(b), sound.duration), i.label) for (a, b), i in pairs))

    phones = _covering(moved(utterance.phones), sound)
    native = None if utterance.native is None else _covering(moved(utterance.native), sound)
    return replace(utterance, audio=sound, words=moved(utterance.words), phones=phones, native=native)


def _covering(phones: Tier, sound: Audio) -> Tier:
    """The phones up to the very end of the sound, which is a whole number of samples."""
    if not phones.intervals:
        return phones
    last = phones.intervals[-1]
    last = Interval(min(last.start, sound.duration), sound.duration, last.label)
    return Tier(phones.name, (*phones.intervals[:-1], last))


def _gained(audio: Audio, changes: Sequence[Change]) -> Floats:
    times = np.arange(len(audio)) / audio.rate
    decibels = np.zeros(len(audio))
    for change in changes:
        if change.volume:
            inside = np.clip(np.minimum(times - change.start, change.end - times) / _RAMP + 0.5, 0, 1)
            decibels += change.volume * inside
    return np.asarray(audio.samples.astype(np.float64) * 10 ** (decibels / 20))


def _replayed(samples: Floats, rate_hz: int, edges: Floats, rate: Floats, pitch: Floats) -> Floats:
    """Stretch every stretch by pitch / rate, then play it ``pitch`` times as fast."""
    first = np.concatenate([[0.0], np.cumsum(np.diff(edges) * pitch / rate)])
    longer = stretched(samples, rate_hz, edges, first)
    second = np.concatenate([[0.0], np.cumsum(np.diff(edges) / rate)])
    count = round(second[-1] * rate_hz)
    if (pitch == 1).all():
        return longer[:count] if len(longer) >= count else np.pad(longer, (0, count - len(longer)))
    import soxr

    fine = soxr.resample(longer, rate_hz, rate_hz * _FINER, quality="HQ")
    wanted = np.interp(np.arange(count) / rate_hz, second, first)
    return np.asarray(np.interp(wanted * rate_hz * _FINER, np.arange(len(fine)), fine))


def stretched(samples: Floats, rate_hz: int, old: Floats, new: Floats) -> Floats:
    """Move the instants ``old`` to ``new`` (seconds, rising) without changing pitch: WSOLA.

    Where time is not stretched the sound stays as it is, shifted by at most 8 ms.
    """
    window = 2 * round(_WINDOW * rate_hz / 2)
    hop, search = window // 2, round(_SEARCH * rate_hz)
    count = round(new[-1] * rate_hz)
    shape = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(window) + 0.5) / window)
    padded = np.concatenate([np.zeros(window + search), samples, np.zeros(2 * window + 2 * search)])
    result, weight = np.zeros(count + 2 * window), np.zeros(count + 2 * window)
    last = None
    for start in range(0, count + hop, hop):
        middle = (start + hop - hop) / rate_hz
        ideal = round(float(np.interp(middle, new, old)) * rate_hz) + window + search - hop
        ideal = min(max(ideal, search), len(padded) - window - search - 1)
        place = ideal if last is None else _best(padded, ideal, min(last + hop, len(padded) - window), window, search)
        result[start : start + window] += padded[place : place + window] * shape
        weight[start : start + window] += shape
        last = place
    whole = result / np.maximum(weight, 1e-6)
    return np.asarray(whole[hop : hop + count])


def _best(padded: Floats, ideal: int, natural: int, window: int, search: int) -> int:
    """The place near ``ideal`` that looks most like the natural continuation of the last window."""
    if abs(natural - ideal) <= search // 2:
        return natural
    from scipy.signal import correlate

    target = padded[natural : natural + window]
    area = padded[ideal - search : ideal + search + window]
    likeness = correlate(area, target, mode="valid", method="fft")
    energy = np.sqrt(np.convolve(area**2, np.ones(window), mode="valid")) + 1e-9
    return ideal - search + int(np.argmax(likeness / energy))
