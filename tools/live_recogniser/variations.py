"""One recording as other voices, microphones and rooms would have it, with its phone times moved along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import soxr
from numpy.typing import NDArray
from scipy.signal import butter, fftconvolve, firwin2, lfilter, sosfilt

RATE = 16_000
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """Sound at 16 kHz with its phones (labels, starts and ends in seconds) and who speaks."""

    samples: Floats
    labels: tuple[str, ...]
    starts: Floats
    ends: Floats
    speaker: str


def varied(line: Line, others: Sequence[Line], random: np.random.Generator, semitones: float) -> Line:
    """A variation.

    A quarter stay as they are but for the level. Otherwise pitch, resonances and pace move together by
    up to ``semitones`` (resampling); a filter colours the sound,
    one in six goes through a telephone, one in three has a room; noise (white, pink, hum or others' speech) lies 0 to
    40 dB below, below 20 in three of five; peaks lie at full scale and below, 12 dB in the mean; one in ten is clipped.
    """
    if random.random() < 0.25:
        sound = line.samples / max(np.abs(line.samples).max(), 1e-6) * 10 ** (-random.uniform(0, 30) / 20)
        return replace(line, samples=sound)
    factor = 2 ** (random.uniform(-semitones, semitones) / 12)
    sound = soxr.resample(line.samples, RATE, RATE * factor) if semitones else line.samples.copy()
    before, after = (int(RATE * random.uniform(0.1, 1.2)) for _ in range(2))
    size = max(float(np.sqrt((sound**2).mean())), 1e-6)
    sound = np.concatenate([np.zeros(before), sound, np.zeros(after)])
    sound = coloured(sound, random)
    if random.random() < 0.35:
        sound = echoing(sound, random)
    decibels = random.uniform(0, 20) if random.random() < 0.6 else random.uniform(20, 40)
    sound = sound + noise(len(sound), others, random) * size * 10 ** (-decibels / 20)
    if random.random() < 0.16:
        sound = sosfilt(
            butter(4, (random.uniform(200, 350), random.uniform(3000, 3800)), "band", fs=RATE, output="sos"), sound
        )
    sound = sound / max(np.abs(sound).max(), 1e-6) * 10 ** (-random.exponential(12) / 20)
    if random.random() < 0.1:
        sound = np.clip(sound * random.uniform(1.5, 6), -1, 1)
    sound = np.round((sound + random.uniform(-0.02, 0.02)) * 32767) / 32767
    starts, ends = (times * factor + before / RATE for times in (line.starts, line.ends))
    return Line(sound, line.labels, starts, ends, line.speaker)


def coloured(sound: Floats, random: np.random.Generator) -> Floats:
    """Through a random smooth filter."""
    hertz = np.array([0, 100, 300, 1000, 3000, 5000, 8000])
    gains = np.concatenate(([-random.uniform(0, 20)], random.normal(-2.5, 3, 1), random.normal(0, 3, 5)))
    return np.asarray(lfilter(firwin2(129, hertz / 8000, 10 ** (gains / 20)), [1.0], sound))[64:].copy()


def echoing(sound: Floats, random: np.random.Generator) -> Floats:
    """In a room of up to half a second; the direct sound keeps its time."""
    length = round(RATE * random.uniform(0.08, 0.5))
    tail = random.normal(size=length) * np.exp(-6.9 * np.arange(length) / length)
    tail *= random.uniform(0.05, 0.6) / np.sqrt((tail**2).sum())
    tail[0] = 1.0
    return np.asarray(fftconvolve(sound, tail)[: len(sound)])


def noise(length: int, others: Sequence[Line], random: np.random.Generator) -> Floats:
    """White, pink, humming or babbling, with a mean power of 1."""
    kind = random.choice(["white", "pink", "hum", "babble"], p=[0.2, 0.35, 0.05, 0.4])
    if kind == "babble":
        made = np.zeros(length)
        for place in random.integers(0, len(others), random.integers(3, 8)):
            made += np.resize(np.roll(others[place].samples, int(random.integers(0, RATE))), length)
    elif kind == "hum":
        made = np.sin(2 * np.pi * random.choice([50, 60]) * np.arange(length) / RATE) ** 3 + random.normal(
            0, 0.1, length
        )
    else:
        made = random.normal(size=length)
        if kind == "pink":
            spectrum = np.fft.rfft(made)
            made = np.fft.irfft(spectrum / np.sqrt(np.maximum(np.arange(len(spectrum)), 5)), length)
    return np.asarray(made / max(np.sqrt((made**2).mean()), 1e-9))
