"""Songs whose phone times are known: a synthetic voice made to sing over a synthetic band.

Each vowel is held and moved to a note (WSOLA, `mien.speech.sound_reshaping`), lines are separated by rests, and a band
of chords (eight harmonics each, decaying), a bass and a brushed drum plays behind it at a given level below the
voice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.speech.pitch import pitch_contour
from mien.speech.sound_reshaping import Change, reshape
from mien.speech.synthesis import synthesise
from mien.text.phones import is_vowel

__all__ = ["SONGS", "Song", "make_song"]

SONGS = {
    "river": "Down by the river the water runs slow,\nI carry your memory wherever I go.\nThe moon on the mountain, "
    "the stars in the sea,\nthey whisper a promise between you and me.",
    "morning": "Wake up my darling, the morning is bright,\nthe birds in the garden have finished the night.\n"
    "Open the window and let in the day,\nnobody ever will take it away.",
    "home": "Home is the place where the people are kind,\nwhere nobody hurries and nobody minds.\n"
    "Bring me a blanket and bring me some bread,\nand sing me to sleep in my very own bed.",
}
_SCALE = (0, 2, 4, 5, 7, 9, 12)
_BEATS = (2.2, 1.3, 3.0, 1.6, 2.6)  # how many times as long vowels become, in turn
_REST = 0.8
_CHORDS = ((0, 4, 7), (5, 9, 12), (7, 11, 14), (0, 4, 7))


@dataclass(frozen=True)
class Song:
    """A song: what is heard, and who sings what when (the truth)."""

    name: str
    lyrics: str
    audio: Audio
    truth: Utterance


def make_song(name: str, voice: str, snr: float | None, seed: int = 0) -> Song:
    """Let a voice sing one of `SONGS`; ``snr`` is the level of voice over band in dB, None without a band."""
    random = np.random.default_rng(seed)
    lines = [_sung(synthesise(line, voice=voice), random) for line in SONGS[name].splitlines()]
    samples, words, phones, now = [np.zeros(lines[0].audio.rate)], [], [], 1.0
    rate = lines[0].audio.rate
    for line in lines:
        words += line.words.shifted(now).intervals
        phones += line.phones.shifted(now).intervals
        samples += [line.audio.samples.astype(float), np.zeros(round(_REST * rate))]
        now = sum(map(len, samples)) / rate
    voice_alone = np.concatenate(samples)
    sound = voice_alone
    if snr is not None:
        band = _band(len(voice_alone), rate, random)
        loud = voice_alone[np.abs(voice_alone) > 0.02]
        band *= np.sqrt(np.mean(loud**2) / np.mean(band**2)) * 10 ** (-snr / 20)
        sound = voice_alone + band
    sound = sound / np.abs(sound).max() * 0.7
    truth = Utterance(
        SONGS[name],
        Audio(voice_alone, rate),
        Tier("words", tuple(words)),
        _filled(phones, len(sound) / rate),
        "en-US",
        "voice",
    )
    return Song(name, SONGS[name], Audio(sound, rate), truth)


def _sung(said: Utterance, random: np.random.Generator) -> Utterance:
    """Vowels held on notes of a major scale, consonants a little longer."""
    contour = pitch_contour(said.audio)
    base = 12 * np.log2(contour.median / 440.0)
    changes, note = [], 2
    for number, phone in enumerate(said.phones):
        if phone.label == "SIL":
            continue
        if is_vowel(phone.label):
            note = int(np.clip(note + random.integers(-2, 3), 0, len(_SCALE) - 1))
            now = 12 * np.log2(float(contour.hertz_at(phone.middle)) / 440.0)
            wanted = base + _SCALE[note] - now
            changes.append(
                Change(
                    phone.start, phone.end, rate=1 / _BEATS[number % len(_BEATS)], pitch=float(np.clip(wanted, -10, 10))
                )
            )
        else:
            changes.append(Change(phone.start, phone.end, rate=0.85))
    return reshape(said, changes)


def _band(count: int, rate: int, random: np.random.Generator) -> np.ndarray:
    """Chords changing every two seconds, a bass on every beat of half a second, a brush on the off-beats."""
    time = np.arange(count) / rate
    sound = np.zeros(count)
    for start in np.arange(0, count / rate, 2.0):
        chord = _CHORDS[int(start / 2) % len(_CHORDS)]
        here = time - start
        inside = (here >= 0) & (here < 2.2)
        t = here[inside]
        for step in chord:
            hertz = 220.0 * 2 ** (step / 12)
            for k in range(1, 9):
                sound[inside] += np.exp(-1.2 * t) / k**1.3 * np.sin(2 * np.pi * hertz * k * t)
    for beat in np.arange(0, count / rate, 0.5):
        here = time - beat
        inside = (here >= 0) & (here < 0.4)
        t = here[inside]
        root = 55.0 * 2 ** (_CHORDS[int(beat / 2) % len(_CHORDS)][0] / 12)
        sound[inside] += 1.5 * np.exp(-5 * t) * np.sin(2 * np.pi * root * t)
        off = (here >= 0.25) & (here < 0.33)
        sound[off] += 0.5 * np.exp(-40 * (here[off] - 0.25)) * random.standard_normal(int(off.sum()))
    return sound


def _filled(phones: list[Interval], duration: float) -> Tier:
    """Neighbouring pauses made one, gaps filled."""
    out: list[Interval] = []
    for phone in [*phones, Interval(duration, duration, "SIL")]:
        end = out[-1].end if out else 0.0
        if phone.start > end + 1e-6:
            phone_gap = Interval(end, phone.start, "SIL")
            out = _added(out, phone_gap)
        if phone.end > phone.start:
            out = _added(out, phone)
    return Tier("phones", tuple(out))


def _added(out: list[Interval], phone: Interval) -> list[Interval]:
    if out and out[-1].label == phone.label == "SIL":
        return [*out[:-1], replace(out[-1], end=phone.end)]
    return [*out, phone]
