"""How a voice sounds, apart from its words: numbers about pitch, level, rhythm and timbre of one stretch of speech.

Made to mean the same on recordings of other microphones, levels and sample rates: sound is taken to 16 kHz, silence
around the speech is cut off, and every frame that counts is one with speech. Names begin with their group: ``pitch``,
``rhythm``, ``timbre`` (mean and spread of what the spectrum is like), ``change`` (how fast it changes: a microphone's
colour, which stays, is not in it) and ``modulation``.

What was tried and left out, because neutral speech of other corpora (grid-s1, timit-sample) lay more than 1.5 standard
deviations off neutral speech of EmoDB: spread and range of the level, shares and lengths of voiced and unvoiced
stretches, and four means of the spectrum. Without them as much EmoDB of unseen speakers is told,
and far more of neutral grid-s1 is heard as neutral.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.speech.pitch import PitchContour, level_contour, pitch_contour

__all__ = ["SpeechFrames", "analyse", "voice_features"]

RATE, HOP, WINDOW = 16_000, 256, 512
STEP = HOP / RATE
_BLOCK = 1024  # frames
_BANDS, _CEPSTRA = 26, 14
_BAND_LOW, _BAND_HIGH = 80.0, 6500.0
_SPEECH_RANGE_DB = 32.0
_FLOOR_DB = -80.0
_FEWEST = 8
_LEAST_VOICED = 0.05  # share of what is loud enough to be speech
_OF_THE_ROOM = ("mfcc3", "centroid", "low", "air")  # whose means differ more between two studios than between moods
_Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpeechFrames:
    """One sound, frame by frame (16 ms), from the first frame with speech to the last.

    Attributes
    ----------
    start : float
        Seconds from the start of the sound to the first frame.
    level : ndarray, shape (frames,)
        dB relative to the middle level of the frames with speech.
    loudness : float
        That middle level, dBFS.
    active : ndarray of bool, shape (frames,)
        Where there is speech.
    semitones : ndarray, shape (frames,)
        Pitch above 55 Hz; NaN where there is no voice.
    confidence : ndarray, shape (frames,)
        Of the voicing, 0 to 1.
    power : ndarray, shape (frames, 257)
        Spectrum of each frame, 0 to 8 kHz, of the sound brought to one level.
    """

    start: float
    level: _Array
    loudness: float
    active: NDArray[np.bool_]
    semitones: _Array
    confidence: _Array
    power: NDArray[np.floating]

    def __len__(self) -> int:
        return len(self.level)

    @property
    def seconds_of_speech(self) -> float:
        """Seconds with speech; none where next to nothing is voiced: noise, a hum, clicks (and a whisper)."""
        voiced = float((np.isfinite(self.semitones) & self.active).sum())
        active = float(self.active.sum())
        return active * STEP if voiced > _LEAST_VOICED * active else 0.0

    def between(self, start: float, end: float) -> SpeechFrames:
        """The frames from ``start`` to ``end`` seconds of the sound; levels stay relative to the whole."""
        times = self.start + STEP * np.arange(len(self))
        first, after = np.searchsorted(times, [start, end])
        cut = slice(int(first), int(after))
        return SpeechFrames(
            float(times[first]) if first < len(times) else end,
            self.level[cut],
            self.loudness,
            self.active[cut],
            self.semitones[cut],
            self.confidence[cut],
            self.power[cut],
        )


def analyse(audio: Audio, spectra: float = np.inf) -> SpeechFrames:
    """Frames of a sound, from the first with speech to the last; none where there is no speech.

    Parameters
    ----------
    audio : Audio
    spectra : float
        Seconds from the first speech on whose spectra are wanted, if not all: an hour of them is a quarter gigabyte.
    """
    sound = audio.resampled(RATE)
    level = level_contour(sound).decibels
    pitch = pitch_contour(audio)
    frames = min(len(level), len(pitch))
    level = level[:frames]
    active = level > max(np.percentile(level, 95) - _SPEECH_RANGE_DB, _FLOOR_DB)
    if not active.any():
        return SpeechFrames(0.0, *_nothing())
    first, after = int(np.argmax(active)), frames - int(np.argmax(active[::-1]))
    cut = slice(first, after)
    loudness = float(np.median(level[active]))
    wanted = slice(first, min(after, first + math.ceil(min(spectra, audio.duration) / STEP)))
    power = _spectra(sound.samples, wanted, 10 ** (-(loudness + 20) / 20))
    return SpeechFrames(
        first * STEP,
        level[cut] - loudness,
        loudness,
        active[cut],
        _semitones(pitch)[cut],
        pitch.confidence[cut],
        power,
    )


def _nothing() -> tuple[_Array, float, NDArray[np.bool_], _Array, _Array, NDArray[np.floating]]:
    empty = np.zeros(0)
    return empty, _FLOOR_DB, np.zeros(0, dtype=bool), empty, empty, np.zeros((0, WINDOW // 2 + 1))


def _semitones(pitch: PitchContour) -> _Array:
    """Pitch above 55 Hz with stray octaves left out: what is more than 14 semitones off the middle."""
    semitones = pitch.semitones(55.0)
    with np.errstate(invalid="ignore"):
        stray = np.abs(semitones - np.nanmedian(semitones)) > 14 if pitch.voiced.any() else False
    return np.where(stray, np.nan, semitones)


def _spectra(samples: NDArray[np.floating], frames: slice, gain: float) -> NDArray[np.float32]:
    """Power spectra of Hann windows centred on some frames, in single precision and made in blocks."""
    found = np.empty((frames.stop - frames.start, WINDOW // 2 + 1), np.float32)
    for first in range(0, len(found), _BLOCK):
        count = min(_BLOCK, len(found) - first)
        begin = HOP * (frames.start + first) - WINDOW // 2
        heard = samples[max(begin, 0) : max(begin + HOP * count + WINDOW, 0)] * samples.dtype.type(gain)
        padded = np.pad(heard.astype(np.float32), (max(-begin, 0), 2 * WINDOW))
        windows = padded[HOP * np.arange(count)[:, None] + np.arange(WINDOW)] * np.hanning(WINDOW)
        found[first : first + _BLOCK] = np.abs(np.fft.rfft(windows, axis=1)) ** 2
    return found


def voice_features(frames: SpeechFrames) -> dict[str, float]:
    """Name and value of every feature of some frames; the same names in the same order for every sound.

    Parameters
    ----------
    frames : SpeechFrames

    Examples
    --------
    >>> hum = Audio(0.1 * np.sin(2 * np.pi * 220 * np.arange(16000) / 16000), 16000)
    >>> found = voice_features(analyse(hum))
    >>> round(found["pitch.middle"]), round(found["pitch.spread"], 1)
    (24, 0.0)
    """
    if len(frames) < _FEWEST:
        frames = _padded(frames)
    voiced = np.isfinite(frames.semitones) & frames.active
    heard = voiced if voiced.sum() >= _FEWEST else frames.active
    heard = heard if heard.sum() >= 2 else np.ones(len(frames), dtype=bool)
    found = {
        **_pitch(frames, voiced),
        **_rhythm(frames, voiced),
        **_timbre(frames, heard),
    }
    return {name: float(value) if np.isfinite(value) else 0.0 for name, value in found.items()}


def _padded(frames: SpeechFrames) -> SpeechFrames:
    """Too few frames to say anything: quiet, unvoiced ones are added, so that every feature has a value."""
    more = _FEWEST - len(frames)
    return SpeechFrames(
        frames.start,
        np.pad(frames.level, (0, more), constant_values=-_SPEECH_RANGE_DB),
        frames.loudness,
        np.pad(frames.active, (0, more)),
        np.pad(frames.semitones, (0, more), constant_values=np.nan),
        np.pad(frames.confidence, (0, more)),
        np.pad(frames.power, ((0, more), (0, 0))),
    )


def _pitch(frames: SpeechFrames, voiced: NDArray[np.bool_]) -> dict[str, float]:
    height = frames.semitones[voiced]
    if len(height) < _FEWEST:
        height = np.full(_FEWEST, 20.0)
    low, quarter, middle, three, high = np.percentile(height, [5, 25, 50, 75, 95])
    slopes = _within_runs(frames.semitones, voiced)
    rising, falling = slopes[slopes > 0], slopes[slopes < 0]
    where = np.flatnonzero(voiced) * STEP
    trend = np.polyfit(where, frames.semitones[voiced], 1)[0] if len(where) >= _FEWEST else 0.0
    centred = height - middle
    return {
        "pitch.middle": middle,
        "pitch.spread": height.std(),
        "pitch.low": low - middle,
        "pitch.high": high - middle,
        "pitch.quarters": three - quarter,
        "pitch.lean": np.mean(centred**3) / max(height.std(), 0.5) ** 3,
        "pitch.trend": trend,
        "pitch.rise": rising.mean() if len(rising) else 0.0,
        "pitch.fall": falling.mean() if len(falling) else 0.0,
        "pitch.speed": np.abs(slopes).mean() if len(slopes) else 0.0,
        "pitch.unrest": slopes.std() if len(slopes) else 0.0,
        "pitch.tremble": _second(frames.semitones, voiced),
    }


def _within_runs(values: _Array, where: NDArray[np.bool_]) -> _Array:
    """Differences between neighbours that both count."""
    both = where[1:] & where[:-1]
    return np.asarray(np.diff(values)[both])


def _second(values: _Array, where: NDArray[np.bool_]) -> float:
    three = where[2:] & where[1:-1] & where[:-2]
    bends = np.abs(values[2:] - 2 * values[1:-1] + values[:-2])[three]
    return float(np.median(bends)) if len(bends) else 0.0


def _rhythm(frames: SpeechFrames, voiced: NDArray[np.bool_]) -> dict[str, float]:
    smooth = np.convolve(np.maximum(frames.level, -_SPEECH_RANGE_DB), np.hanning(9)[1:-1] / 4, "same")
    peak = (smooth[1:-1] > smooth[:-2]) & (smooth[1:-1] >= smooth[2:]) & (smooth[1:-1] > -15)
    spoken = max(frames.active.sum() * STEP, 0.1)
    runs = _runs(voiced)
    return {
        "rhythm.peaks": peak.sum() / spoken,
        "rhythm.voiced_run": runs.mean() if len(runs) else 0.0,
        "rhythm.voiced_run_spread": runs.std() if len(runs) else 0.0,
    }


def _runs(where: NDArray[np.bool_]) -> _Array:
    """Lengths of the runs of True, seconds."""
    edges = np.diff(np.concatenate(([0], where.astype(int), [0])))
    return np.asarray((np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)) * STEP)


def _timbre(frames: SpeechFrames, heard: NDArray[np.bool_]) -> dict[str, float]:
    bands = 10 * np.log10(frames.power @ _mel_filters().T + 1e-7)
    cepstra = bands @ _cosines().T
    rows = {**{f"mfcc{i}": cepstra[:, i] for i in range(1, _CEPSTRA)}, **_shape_of_spectrum(frames)}
    found: dict[str, float] = {}
    for name, row in rows.items():
        values = row[heard]
        low, high = np.percentile(values, [10, 90])
        steps = _within_runs(row, heard)
        if name not in _OF_THE_ROOM:
            found[f"timbre.{name}.mean"] = values.mean()
        found[f"timbre.{name}.spread"] = values.std()
        found[f"timbre.{name}.range"] = high - low
        found[f"change.{name}"] = np.abs(steps).mean() if len(steps) else 0.0
        found[f"timbre.{name}.on_level"] = _slope(frames.level[heard], values)
    return {**found, **_flux(bands, frames.active), **_modulation(bands)}


def _shape_of_spectrum(frames: SpeechFrames) -> dict[str, _Array]:
    """One number per frame and measure, in dB or octaves."""
    power = frames.power + 1e-9
    hertz = np.fft.rfftfreq(WINDOW, 1 / RATE)

    def band(low: float, high: float) -> _Array:
        return np.asarray(10 * np.log10(power[:, (hertz >= low) & (hertz < high)].sum(axis=1)))

    def peak(low: float, high: float) -> _Array:
        return np.asarray(10 * np.log10(power[:, (hertz >= low) & (hertz < high)].max(axis=1)))

    inside = (hertz >= _BAND_LOW) & (hertz < _BAND_HIGH)
    octave = np.log2(hertz[inside] / 1000)
    share = power[:, inside] / power[:, inside].sum(axis=1, keepdims=True)
    centroid = share @ octave
    return {
        "alpha": band(50, 1000) - band(1000, 5000),
        "hammarberg": peak(50, 2000) - peak(2000, 5000),
        "low": band(50, 500) - band(500, 1500),
        "middle": band(500, 1500) - band(1500, 3500),
        "air": band(1500, 3500) - band(3500, 6500),
        "centroid": centroid,
        "width": np.sqrt(np.maximum(share @ octave**2 - centroid**2, 0)),
        "flatness": np.log(power[:, inside]).mean(axis=1) - np.log(power[:, inside].mean(axis=1)),
        "harmonic": -10 * np.log10(np.clip(1 - frames.confidence, 1e-3, 1)),
    }


def _slope(x: _Array, y: _Array) -> float:
    spread = x.var()
    return float(((x - x.mean()) * (y - y.mean())).mean() / spread) if spread > 1 else 0.0


def _flux(bands: _Array, active: NDArray[np.bool_]) -> dict[str, float]:
    centred = bands - bands.mean(axis=1, keepdims=True)
    flux = np.sqrt((np.diff(centred, axis=0) ** 2).mean(axis=1))
    both = active[1:] & active[:-1]
    flux = flux[both] if both.any() else flux
    return {"change.flux": flux.mean(), "change.flux_spread": flux.std()}


def _modulation(bands: _Array) -> dict[str, float]:
    """How fast the level of four wide bands goes up and down: shares of 1-2, 2-4, 4-8, 8-16 and 16-30 Hz, dB."""
    found: dict[str, float] = {}
    for number, group in enumerate(np.array_split(np.maximum(bands, bands.max() - 50), 4, axis=1)):
        curve = group.mean(axis=1)
        size = max(64, len(curve))
        spectrum = np.abs(np.fft.rfft((curve - curve.mean()) * np.hanning(len(curve)), size)) ** 2
        hertz = np.fft.rfftfreq(size, STEP)
        whole = spectrum[(hertz >= 1) & (hertz < 30)].sum() + 1e-9
        for low, high in ((1, 2), (2, 4), (4, 8), (8, 16), (16, 30)):
            part = spectrum[(hertz >= low) & (hertz < high)].sum()
            found[f"modulation.band{number}.from{low}"] = 10 * np.log10(part / whole + 1e-3)
    return found


@lru_cache(maxsize=1)
def _mel_filters() -> _Array:
    """Triangles on the mel scale, each summing to one; shape (bands, 257)."""
    mel = np.linspace(_to_mel(_BAND_LOW), _to_mel(_BAND_HIGH), _BANDS + 2)
    edges = 700 * (10 ** (mel / 2595) - 1)
    hertz = np.fft.rfftfreq(WINDOW, 1 / RATE)
    up = (hertz - edges[:-2, None]) / (edges[1:-1] - edges[:-2])[:, None]
    down = (edges[2:, None] - hertz) / (edges[2:] - edges[1:-1])[:, None]
    filters = np.clip(np.minimum(up, down), 0, None)
    return np.asarray(filters / filters.sum(axis=1, keepdims=True))


def _to_mel(hertz: float) -> float:
    return float(2595 * np.log10(1 + hertz / 700))


@lru_cache(maxsize=1)
def _cosines() -> _Array:
    """The discrete cosine transform's first rows; shape (cepstra, bands)."""
    phase = np.pi * (np.arange(_BANDS) + 0.5) / _BANDS
    return np.asarray(np.sqrt(2 / _BANDS) * np.cos(np.arange(_CEPSTRA)[:, None] * phase))
