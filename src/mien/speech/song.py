"""A song and its lyrics: who sings what when, with instruments behind the voice.

Speech alignment fails on songs for three reasons, and each is met before the aligner listens:

* *instruments* hold their notes: what lasts in a frequency band over about a second is taken for the band and
  subtracted (a low percentile over time, as in the repeating-background family of methods; Rafii and Pardo 2013);
* *rests* are not silent: where the voice band stays low the sound is turned down, so that no word is laid there;
* *held vowels* outweigh all else, since the aligner counts every frame alike: where the spectrum hardly changes time is
  compressed up to four times, and what was found is brought back to the song's own time.

The voice must be about as loud as the band. Figures: ``docs/tables/song.md``.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.audio import Audio
from mien.speech.align import align
from mien.speech.languages.language import ENGLISH
from mien.speech.reshaping import stretched
from mien.speech.utterance import Utterance
from mien.timeline import Interval, Tier

__all__ = ["align_song", "song_time", "without_band"]

Floats = NDArray[np.float64]

_RATE = 16_000
_WINDOW = 1024  # samples of one spectrum for separating, 64 ms
_HOLD = 1.2  # seconds over which what stays is the band
_STAYS = 30.0  # percentile over that time that counts as staying
_FLOOR = 0.1  # of a spectrum is always left
_REST = 14.0  # decibels under the voice that are a rest
_TURNED_DOWN = 0.003
_STEP = 0.01
_SPREAD = 0.06  # seconds over which change is measured
_MOST = 4.0  # times that held sound is compressed
_LIVELY = 60.0  # percentile of change that is left at its pace
_LOUD = 25.0  # decibels under the loudest in which held sound is looked for
_BANDS, _LOWEST, _HIGHEST = 24, 150.0, 6500.0


def align_song(audio: Audio, lyrics: str, *, language: str | Path = ENGLISH) -> Utterance:
    """Find when each word and phone of a song's lyrics is sung.

    Parameters
    ----------
    audio : Audio
        The song as it is, band and all; the utterance keeps it.
    lyrics : str
    language : str or Path
        As for `mien.speech.align.align`.

    Returns
    -------
    Utterance
        ``sung`` is True.

    Raises
    ------
    InputError
        If the lyrics cannot be read or the sound is too short.
    AlignmentError
        If no alignment was found.
    """
    voice = without_band(audio)
    old, new = song_time(voice)
    quick = stretched(voice, _RATE, old, new)
    loudest = float(np.abs(quick).max(initial=0.0))
    quick = quick * (0.7 / loudest) if loudest > 0 else quick
    found = align(Audio(quick, _RATE), lyrics, language=language)
    if found.timing == "none":
        return replace(
            align(Audio.silence(audio.duration, audio.rate), lyrics, language=language), audio=audio, sung=True
        )

    def back(tier: Tier) -> Tier:
        last = tier.intervals[-1].end if len(tier) else 0.0
        ends = [audio.duration if i.end >= last else float(np.interp(i.end, new, old)) for i in tier]
        starts = [float(np.interp(i.start, new, old)) for i in tier]
        within = [(min(a, audio.duration), min(b, audio.duration)) for a, b in zip(starts, ends, strict=True)]
        return Tier(tier.name, tuple(Interval(a, b, i.label) for (a, b), i in zip(within, tier, strict=True)))

    words = Tier("words", tuple(
        Interval(min(float(np.interp(w.start, new, old)), audio.duration),
                 min(float(np.interp(w.end, new, old)), audio.duration), w.label) for w in found.words
    ))  # fmt: skip
    notes = tuple(note for note in found.notes if "seem" not in note.message)  # limits that hold for speech
    native = None if found.native is None else back(found.native)
    return replace(found, audio=audio, words=words, phones=back(found.phones), native=native, notes=notes, sung=True)


def without_band(audio: Audio) -> Floats:
    """The voice of a song with what lasts behind it subtracted and rests turned down; at 16 kHz, shape (samples,)."""
    from scipy.ndimage import maximum_filter1d, percentile_filter, uniform_filter1d
    from scipy.signal import istft, stft

    samples = audio.resampled(_RATE).samples.astype(np.float64)
    overlap = _WINDOW * 3 // 4
    _, _, spectrum = stft(samples, _RATE, nperseg=_WINDOW, noverlap=overlap)
    size = np.abs(spectrum)
    frames = max(1, round(_HOLD * _RATE / (_WINDOW - overlap)))
    stays = percentile_filter(size, _STAYS, size=(1, frames))
    spectrum = spectrum * np.maximum(1 - stays / np.maximum(size, 1e-9), _FLOOR)
    _, voice = istft(spectrum, _RATE, nperseg=_WINDOW, noverlap=overlap)
    voice = np.pad(voice, (0, max(0, len(samples) - len(voice))))[: len(samples)]
    bands, times = _bands(voice)
    level = 10 * np.log10(uniform_filter1d(bands[4:].sum(axis=0), 15) + 1e-12)
    sings = maximum_filter1d((level > np.percentile(level, 85) - _REST).astype(np.float64), 15)
    gain = np.interp(np.arange(len(voice)) / _RATE, times, uniform_filter1d(sings, 5))
    return np.asarray(voice * np.maximum(gain, _TURNED_DOWN))


def song_time(voice: Floats) -> tuple[Floats, Floats]:
    """Where held sound is compressed: instants of the song, and where they move to; seconds, both rising from 0."""
    from scipy.ndimage import gaussian_filter1d

    bands, times = _bands(voice)
    decibels = gaussian_filter1d(10 * np.log10(bands + bands.max(initial=0.0) * 1e-5 + 1e-12), 1.5, axis=1)
    reach = round(_SPREAD / _STEP / 2)
    padded = np.pad(decibels, ((0, 0), (reach, reach)), mode="edge")
    change = gaussian_filter1d(np.abs(padded[:, 2 * reach :] - padded[:, : -2 * reach]).mean(axis=0), 2.0)
    level = 10 * np.log10(bands.sum(axis=0) + 1e-12)
    loud = level > np.percentile(level, 90) - _LOUD
    lively = np.percentile(change[loud], _LIVELY) if loud.any() else 1.0
    pace = np.where(loud, np.clip(lively / np.maximum(change, 1e-3), 1.0, _MOST), 1.0)
    end = len(voice) / _RATE
    old = np.append(times[times < end], end)
    new = np.concatenate([[0.0], np.cumsum(np.diff(old) / pace[: len(old) - 1])])
    return old, new


def _bands(samples: Floats) -> tuple[Floats, Floats]:
    """Power in mel bands, shape (bands, frames), and the times of the frames."""
    from scipy.signal import stft

    size, hop = 512, round(_STEP * _RATE)
    frequencies, times, spectrum = stft(samples, _RATE, nperseg=size, noverlap=size - hop)
    edges = np.linspace(_mel(np.array(_LOWEST)), _mel(np.array(_HIGHEST)), _BANDS + 2)
    low, middle, high = edges[:-2, None], edges[1:-1, None], edges[2:, None]
    here = _mel(frequencies)[None]
    weights = np.maximum(0, np.minimum((here - low) / (middle - low), (high - here) / (high - middle)))
    return np.asarray(weights @ np.abs(spectrum) ** 2), np.asarray(times)


def _mel(hertz: Floats) -> Floats:
    return np.asarray(2595 * np.log10(1 + hertz / 700))
