"""A song and its lyrics: who sings what when, with instruments behind the voice.

Speech alignment fails on songs for three reasons, and each is met before the aligner listens:

* *instruments* hold their notes: what lasts in a frequency band over about a second is taken for the band and
  subtracted (a low percentile over time, as in the repeating-background family of methods; Rafii and Pardo 2013);
* *rests* are not silent: where the voice band stays low the sound is turned down, so that no word is laid there;
* *held vowels* outweigh all else, since the aligner counts every frame alike: where the spectrum hardly changes time is
  compressed up to four times, and what was found is brought back to the song's own time.
* *notes die away*, which the aligner takes for pauses: a pause in which the voice goes on is given to its neighbours.

The voice must be about as loud as the band. Figures: ``docs/tables/song.md``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align
from mien.speech.sound_reshaping import stretched
from mien.text.languages.language import ENGLISH

__all__ = ["align_song", "held_notes", "note_on_singing", "song_time", "without_band"]

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
_LISTENED = 60.0  # seconds in which notes are looked for
_NOTE = 0.4  # seconds that a note is held at least
_SMOOTHED = 9  # frames of pitch, 144 ms: vibrato
_SUNG = 0.1  # of the voice in notes, and at least so many of them, make a song
_NOTES = 3
_SINGS = 20.0  # decibels under the loud parts in which a voice goes on
_DIP = 6  # frames of less than that which do not end a note
_LEFT = 0.02  # seconds that are left of a pause that is sung through
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

    last = found.phones.intervals[-1].end

    def song_instant(instant: float) -> float:
        return audio.duration if instant >= last else min(float(np.interp(instant, new, old)), audio.duration)

    moved = _sung_through(_moved(found.phones, song_instant), voice)

    def back(tier: Tier) -> Tier:
        return _moved(_moved(tier, song_instant), lambda instant: moved.get(instant, instant))

    notes = tuple(note for note in found.notes if "seem" not in note.message)  # limits that hold for speech
    native = None if found.native is None else back(found.native)
    words, phones = back(found.words), back(found.phones)
    return replace(found, audio=audio, words=words, phones=phones, native=native, notes=notes, sung=True)


def _moved(tier: Tier, place: Callable[[float], float]) -> Tier:
    return Tier(tier.name, tuple(Interval(place(i.start), place(i.end), i.label) for i in tier))


def _sung_through(phones: Tier, voice: Floats) -> dict[float, float]:
    """New places of the edges of pauses in which the voice goes on, as in the tail of a note."""
    bands, times = _bands(voice)
    level = 10 * np.log10(np.convolve(bands[2:20].sum(axis=0), np.ones(5) / 5, mode="same") + 1e-12)
    sings, moved = level > np.percentile(level, 90) - _SINGS, dict[float, float]()
    for number, pause in enumerate(phones):
        if pause.label != PAUSE or pause.end - pause.start < 3 * _LEFT:
            continue
        inside = sings[(times >= pause.start) & (times <= pause.end)]
        after = _STEP * _run(inside) if number else 0.0
        before = _STEP * _run(inside[::-1]) if number < len(phones) - 1 else 0.0
        end = min(pause.start + after, pause.end - _LEFT)
        moved[pause.start], moved[pause.end] = end, max(pause.end - before, end + _LEFT)
    return moved


def _run(sings: NDArray[np.bool_]) -> int:
    """For how many frames it goes on from the first."""
    length = 0
    for number, here in enumerate(sings.tolist(), start=1):
        if here:
            length = number
        elif number - length > _DIP:
            break
    return length


def held_notes(audio: Audio) -> tuple[float, int]:
    """Which part of what is voiced lies in notes, and how many there are.

    A note is pitch within a semitone for 0.4 s or more, vibrato smoothed out; only the first minute is listened to.

    Examples
    --------
    >>> note = Audio(0.2 * np.sin(2 * np.pi * 220 * np.arange(32000) / 16000), 16000)
    >>> share, count = held_notes(note)
    >>> share > 0.9, count
    (True, 1)
    """
    from scipy.ndimage import uniform_filter1d

    from mien.speech.pitch import pitch_contour

    contour = pitch_contour(audio)  # of the whole sound, since the head and the brows will ask for it again
    heard = contour.times < _LISTENED
    voiced, size = contour.voiced[heard], round(_NOTE / 0.016)
    pitch = np.where(voiced, contour.semitones()[heard], 0.0)
    weight = uniform_filter1d(voiced.astype(np.float64), _SMOOTHED)
    smooth = uniform_filter1d(pitch, _SMOOTHED) / np.maximum(weight, 1e-9)
    held = np.zeros(len(pitch), dtype=bool)
    for first in range(len(pitch) - size + 1):
        here = slice(first, first + size)
        if voiced[here].all() and np.ptp(smooth[here]) < 1.0:
            held[here] = True
    starts = int(np.count_nonzero(np.diff(held.astype(int), prepend=0) == 1))
    return float(held.sum() / max(voiced.sum(), 1)), starts


def note_on_singing(audio: Audio) -> tuple[Note, ...]:
    """A note if a sound that is taken for speech seems to be sung; nothing is switched."""
    share, count = held_notes(audio)
    if share < _SUNG or count < _NOTES:
        return ()
    return (Note("note", f"{share:.0%} of the voice is held on notes: if it is sung, give its lyrics with --song"),)


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
