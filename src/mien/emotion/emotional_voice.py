"""What is felt given to a voice that was spoken without it: rate, pauses, pitch, accents, level, tilt and breath.

The figures stand in the emotions' tables (``[voice]``), with the studies that they come from. A voice does not have to
know how: its sound is shaped after it was spoken (`mien.speech.pitch_synchronous`, `mien.speech.timbre_shaping`), and
words and phones keep to the sound.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.emotions import emotions
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.pitch import PitchContour, level_contour, pitch_contour
from mien.speech.pitch_synchronous import pitch_marks, repitched
from mien.speech.stressed_vowels import stressed_words
from mien.speech.timbre_shaping import coloured, limited
from mien.text.score import UNDIRECTED, EmotionSpan, Score

__all__ = ["FIGURES", "Kept", "with_feeling"]

Floats = NDArray[np.float64]
_STEP = 0.01  # seconds between two instants at which figures are kept
_ROUNDS = 4  # how often times of the result are looked up anew
_END = 0.4  # seconds at the end of a phrase over which pitch rises or falls
_MOST_SEMITONES = 12.0
_EDGE = 0.04  # seconds over which an accent comes and goes
_TREMOR = 6.5  # Hz
_LEVEL_WINDOW, _SILENT, _MOST_LOST = 0.2, -55.0, 6.0  # seconds, dBFS, dB
FIGURES = {
    "rate": 1.0,
    "pauses": 1.0,
    "pitch": 0.0,
    "range": 1.0,
    "end": 0.0,
    "accents": 0.0,
    "level": 0.0,
    "stress": 0.0,
    "tilt": 0.0,
    "breath": 0.0,
    "tremor": 0.0,
}
"""What an emotion changes, and what it is without one."""
_ALL: Mapping[str, float] = MappingProxyType({})
_OF_THE_USER = {
    "rate": ("rate", "pauses"),
    "pitch": ("pitch", "range", "end", "accents"),
    "volume": ("level", "stress"),
}


@dataclass(frozen=True)
class Kept:
    """A stretch whose ``rate``, ``pitch`` or ``volume`` the user has set: there no emotion changes it.

    Attributes
    ----------
    start, end : float
        Seconds.
    names : frozenset of str
    """

    start: float
    end: float
    names: frozenset[str]


def with_feeling(
    utterance: Utterance,
    at_words: Score,
    at_seconds: Score = UNDIRECTED,
    amount: float = 1.0,
    kept: Sequence[Kept] = (),
    seed: int = 0,
    carried: Mapping[str, float] = _ALL,
) -> Utterance:
    """An utterance spoken with what is felt; the same one where nothing is.

    Parameters
    ----------
    utterance : Utterance
    at_words : Score
        Emotions whose times are those of the utterance, and move with its words.
    at_seconds : Score
        Emotions whose times are seconds of the result.
    amount : float
        0 (the voice stays as it is) to 1 (as the table has it).
    kept : sequence of Kept
    seed : int
        Of breath and tremor.
    carried : mapping of str to float
        Of a figure, the share that this voice carries (`mien.speech.voices.Voice.feeling`); 1 for what is not there.

    Examples
    --------
    >>> phones = Tier("phones", (Interval(0.0, 1.0, "AA"),))
    >>> said = Utterance("ah", Audio.silence(1.0, 8000), Tier("words", ()), phones, "en-US", "aligned")
    >>> with_feeling(said, Score((EmotionSpan("sad"),))).duration
    1.25
    """
    spans = (*at_words.emotions, *at_seconds.emotions)
    if amount == 0 or not utterance.duration or not any(span.name in _table() for span in spans):
        return utterance
    old = np.append(np.arange(0.0, utterance.duration, _STEP), utterance.duration)
    pause = _pauses(utterance.phones, old)
    new = old
    for _ in range(_ROUNDS):
        figures = _figures(at_words.emotions, at_seconds.emotions, old, new, amount)
        for name, share in carried.items():
            figures[name] = FIGURES[name] + share * (figures[name] - FIGURES[name])
        for stretch in kept:
            _keep(figures, old, stretch)
        new = _moved(old, figures, pause)
    if all((figures[name] == usual).all() for name, usual in FIGURES.items()):
        return utterance
    random = np.random.default_rng([seed, 6])
    sound = _shaped(utterance, old, new, figures, random)
    return _retimed(utterance, Audio(sound, utterance.audio.rate), old, new)


@cache
def _table() -> dict[str, dict[str, float]]:
    return {
        emotion: {name: float(value) for name, value in row["voice"].items()}
        for emotion, row in emotions().items()
        if "voice" in row
    }


def _figures(
    at_words: Sequence[EmotionSpan], at_seconds: Sequence[EmotionSpan], old: Floats, new: Floats, amount: float
) -> dict[str, Floats]:
    """Every figure at the instants ``old``, which lie at ``new`` in the result; multiples mix as their logarithms."""
    asked = [span.asked_at(old) for span in at_words] + [span.asked_at(new) for span in at_seconds]
    share = amount / np.maximum(np.sum(asked, axis=0), 1.0)
    found = {name: np.zeros(len(old)) for name in FIGURES}
    for span, weight in zip((*at_words, *at_seconds), asked, strict=True):
        for name, value in _table().get(span.name, {}).items():
            found[name] += weight * share * (np.log(value) if FIGURES[name] == 1.0 else value)
    return {name: np.exp(curve) if FIGURES[name] == 1.0 else curve for name, curve in found.items()}


def _keep(figures: dict[str, Floats], old: Floats, stretch: Kept) -> None:
    inside = (old >= stretch.start) & (old <= stretch.end)
    for asked in stretch.names:
        for name in _OF_THE_USER[asked]:
            figures[name][inside] = FIGURES[name]


def _pauses(phones: Tier, old: Floats) -> NDArray[np.bool_]:
    """Where the line pauses, after its first and before its last sound; shape (instants,)."""
    spoken = [number for number, phone in enumerate(phones) if phone.label != PAUSE]
    inside = phones.intervals[spoken[0] : spoken[-1]] if spoken else ()
    pause = np.zeros(len(old), dtype=bool)
    for phone in inside:
        if phone.label == PAUSE:
            pause |= (old >= phone.start) & (old < phone.end)
    return pause


def _moved(old: Floats, figures: dict[str, Floats], pause: NDArray[np.bool_]) -> Floats:
    longer = np.where(pause, figures["pauses"], 1 / figures["rate"])[:-1]
    return np.concatenate([[0.0], np.cumsum(np.diff(old) * longer)])


def _shaped(
    utterance: Utterance, old: Floats, new: Floats, figures: dict[str, Floats], random: np.random.Generator
) -> Floats:
    """The sound of the result."""
    audio = utterance.audio
    samples = audio.samples.astype(np.float64)
    pitch = pitch_contour(audio)
    accent = _accents(utterance, old) if figures["accents"].any() or figures["stress"].any() else np.zeros(len(old))
    factor = 2 ** (_semitones(utterance, pitch, old, figures, accent, random) / 12)
    marks = pitch_marks(samples, audio.rate, pitch)
    moved = repitched(samples, audio.rate, marks, old, new, factor)
    times = np.arange(len(moved)) / audio.rate

    def over(curve: Floats) -> Floats:
        return np.interp(times, new, curve)

    tilt = figures["tilt"] * _voicing(pitch, old)
    moved = coloured(moved, audio.rate, over(tilt), over(figures["breath"]), random)
    moved *= 10 ** (over(_lost_level(audio, Audio(moved, audio.rate), old, new)) / 20)
    gain = figures["level"] + figures["stress"] * (accent - _at_words(utterance, accent, old))
    return limited(moved * 10 ** (over(gain) / 20))


def _voicing(pitch: PitchContour, old: Floats) -> Floats:
    """1 where the voice sounds, 0 elsewhere, straight between frames: effort brightens the voice, not a hiss."""
    return np.interp(old, pitch.times, pitch.voiced.astype(np.float64)) if len(pitch) else np.zeros(len(old))


def _lost_level(before: Audio, after: Audio, old: Floats, new: Floats) -> Floats:
    """By how many dB shaping made the voice softer at each instant, over a fifth of a second."""
    was = level_contour(before, window=_LEVEL_WINDOW).decibels_at(old)
    lost = was - level_contour(after, window=_LEVEL_WINDOW).decibels_at(new)
    return np.asarray(np.where(was > _SILENT, np.clip(lost, -_MOST_LOST, _MOST_LOST), 0.0))


def _semitones(
    utterance: Utterance,
    pitch: PitchContour,
    old: Floats,
    figures: dict[str, Floats],
    accent: Floats,
    random: np.random.Generator,
) -> Floats:
    """By how much pitch is raised at each instant."""
    if not pitch.voiced.any():
        return np.zeros(len(old))
    height = 12 * np.log2(pitch.hertz_at(old) / pitch.median)
    ends = _phrase_ends(utterance, old)
    trembling = np.interp(old, _grid(old), _tremor(_grid(old), random))
    raised = (figures["range"] - 1) * height + figures["pitch"] + figures["accents"] * accent
    raised = raised + figures["end"] * ends + figures["tremor"] * trembling
    return np.asarray(np.clip(raised, -_MOST_SEMITONES, _MOST_SEMITONES))


def _grid(old: Floats) -> Floats:
    return np.arange(0.0, np.ceil(old[-1]) + 0.5, 1 / (8 * _TREMOR))


def _tremor(grid: Floats, random: np.random.Generator) -> Floats:
    """An uneven trembling, spread 1."""
    phase = 2 * np.pi * _TREMOR * grid + np.cumsum(random.normal(0, 0.4, len(grid)))
    return np.asarray(np.sin(phase) * np.sqrt(2))


def _phrase_ends(utterance: Utterance, old: Floats) -> Floats:
    """0 up to the last `_END` seconds of each phrase, 1 at its end and through the pause after it."""
    spoken, found = [p for p in utterance.phones if p.label != PAUSE], np.zeros(len(old))
    for number, phone in enumerate(spoken):
        after = spoken[number + 1].start if number + 1 < len(spoken) else utterance.duration
        if after - phone.end > _EDGE or number + 1 == len(spoken):
            rise = np.clip((old - phone.end + _END) / _END, 0, 1)
            found = np.maximum(found, np.where(old <= after, rise, 0))
    return found


def _accents(utterance: Utterance, old: Floats) -> Floats:
    """1 in stressed vowels of words that can be stressed, 0 elsewhere."""
    found = np.zeros(len(old))
    for word in stressed_words(utterance):
        if not word.weak:
            flank = np.minimum(old - word.vowel_start, word.vowel_end - old) / _EDGE + 1
            found = np.maximum(found, np.clip(flank, 0, 1))
    return found


def _at_words(utterance: Utterance, accent: Floats, old: Floats) -> float:
    """The mean of the accents over all that is said, so that stress does not make the whole louder."""
    said = np.zeros(len(old), dtype=bool)
    for word in utterance.words:
        said |= (old >= word.start) & (old <= word.end)
    return float(accent[said].mean()) if said.any() else 0.0


def _retimed(utterance: Utterance, sound: Audio, old: Floats, new: Floats) -> Utterance:
    def moved(tier: Tier, covers: bool) -> Tier:
        ends = [np.minimum(np.interp([item.start, item.end], old, new), sound.duration) for item in tier]
        found = [Interval(float(a), float(b), i.label) for (a, b), i in zip(ends, tier, strict=True)]
        if found and covers:
            found[-1] = replace(found[-1], end=sound.duration)
        return Tier(tier.name, tuple(found))

    return replace(
        utterance,
        audio=sound,
        words=moved(utterance.words, False),
        phones=moved(utterance.phones, True),
        native=None if utterance.native is None else moved(utterance.native, True),
    )
