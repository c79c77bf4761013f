"""How hard a voice works: its effort over time, from spectrum, pitch and level (docs/effort.md).

A recording's level says nothing about the voice, since a nearer microphone is louder too. What a hard-working voice
cannot hide is its spectrum, in which the upper part grows more than the lower, and its pitch, which rises by about .4
semitones for a decibel (Andersson, Eriksson, Traunmüller 1996, TMH-QPSR 2: 127-130; Traunmüller, Eriksson 2000, Journal
of the Acoustical Society of America 107: 3438-3451). From these the effort of the recording as a whole is judged, by a
regression learned from acted and ordinary speech of several microphones (`assets/effort/voice.toml`, made by
`tools/learn_vocal_effort.py`). *Within* a recording level does count: there it is the voice that changes.

The same sound at another level has the same effort, bit for bit or nearly so.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.audio import Audio
from mien.speech.voice_features import RATE, STEP, WINDOW, SpeechFrames, analyse

__all__ = ["FEATURES", "VocalEffort", "effort_features", "read_effort", "voice_decibels"]

Floats = NDArray[np.float64]
FEATURES = ("tilt", "pitch", "high")
"""In dB, the energy of 1 to 4 kHz over that of 100 Hz to 1 kHz in the louder half of the voiced frames; in semitones
above 55 Hz, the middle pitch; the same as far as it lies above what either sex speaks at (softly from `HIGH`)."""
HIGH, SOFTLY = 24.0, 2.0
_LISTENED = 600.0  # seconds from the first speech on by which a voice as a whole is judged
FEWEST = 8
"""Voiced frames with speech (16 ms) below which nothing is judged."""
WHISPERED = 0.06
"""Share of voiced frames in speech below which it is whispered."""
WHISPER = -8.0
"""Decibels of a whisper. Hand-made."""
SMOOTH = 2.5
"""Seconds over which level is taken: syllables, words and falls at the end are in the mouth's motion already."""
SWING = 0.4
"""Share of a level's rise within a recording that counts. Hand-made, and small for a reason: on 60 takes of GRID
speaker 1 that the mouth had not learned from, levels of half seconds counted at .65 took the lip opening's correlation
from .895 to .882 and its spread from .99 to 1.21 of the recorded one; this leaves .892 and 1.04."""
MOST_SWING = 12.0
"""Decibels by which effort may rise or fall within a recording."""
POINTS = 0.1
"""Seconds between the points of the curve."""


@dataclass(frozen=True)
class VocalEffort:
    """The effort of a voice over time.

    Attributes
    ----------
    times : tuple of float
        Seconds from the start of the sound.
    levels : tuple of float
        0 to 2; ordinary speech is 1.
    decibels : float
        Of the recording as a whole, above an ordinary voice.
    told : str
        What was read, in one line.
    """

    times: tuple[float, ...]
    levels: tuple[float, ...]
    decibels: float
    told: str


def read_effort(audio: Audio, decibels_per_step: float) -> VocalEffort:
    """The effort of a recorded voice.

    Parameters
    ----------
    audio : Audio
        Speech of one person.
    decibels_per_step : float
        Decibels that go with a step of 1 in effort.
    """
    frames = analyse(audio, _LISTENED)
    if not frames.active.any():
        return VocalEffort((0.0,), (1.0,), 0.0, "effort read from the voice: no speech in it, so 1")
    whole, why = voice_decibels(frames.between(0.0, frames.start + _LISTENED))
    swing = _swing(frames)
    times = np.arange(0.0, audio.duration + POINTS, POINTS)
    inside = np.interp(times, frames.start + STEP * np.arange(len(frames)), swing)
    levels = np.clip(1 + (whole + inside) / decibels_per_step, 0.0, 2.0).round(3)
    low, high = np.percentile(levels, [5, 95])
    told = f"effort read from the voice: {1 + whole / decibels_per_step:.2f} ({why}), over time {low:.2f} to {high:.2f}"
    return VocalEffort(tuple(times.round(3).tolist()), tuple(levels.tolist()), whole, told)


def voice_decibels(frames: SpeechFrames) -> tuple[float, str]:
    """Decibels of a recording as a whole above an ordinary voice, 0 where that is not sure, and how that was seen."""
    voiced = frames.active & np.isfinite(frames.semitones)
    if voiced.sum() < max(FEWEST, WHISPERED * frames.active.sum()):
        return (WHISPER, "whispered") if frames.active.sum() >= 4 * FEWEST else (0.0, "too little voice to judge")
    table = _table()
    features = effort_features(frames)
    standard = (np.array([features[name] for name in FEATURES]) - table["mean"]) / table["scale"]
    strained = 1 / (1 + np.exp(-(standard @ np.array(table["weights"]) + table["bias"])))
    over = max(0.0, (strained - table["ordinary"]) / (1 - table["ordinary"]))
    decibels = min(table["decibels"] * over, table["most"])
    return float(decibels), "ordinary" if decibels < 1 else f"{decibels:.0f} dB above an ordinary voice"


def effort_features(frames: SpeechFrames) -> dict[str, float]:
    """What of a voice rises with its effort, whatever the level of the recording; `FEATURES`.

    Parameters
    ----------
    frames : SpeechFrames
        With at least one voiced frame.
    """
    voiced = frames.active & np.isfinite(frames.semitones)
    loud = voiced & (frames.level >= np.percentile(frames.level[voiced], 50))
    hertz = np.fft.rfftfreq(WINDOW, 1 / RATE)
    low = frames.power[loud][:, (hertz >= 100) & (hertz < 1000)].sum(axis=1)
    upper = frames.power[loud][:, (hertz >= 1000) & (hertz < 4000)].sum(axis=1)
    pitch = float(np.median(frames.semitones[voiced]))
    return {
        "tilt": float((10 * np.log10((upper + 1e-12) / (low + 1e-12))).mean()),
        "pitch": pitch,
        "high": float(SOFTLY * np.logaddexp(0, (pitch - HIGH) / SOFTLY)),
    }


def _swing(frames: SpeechFrames) -> Floats:
    """Decibels of each frame's surroundings above the middle of the recording, 0 far from speech, shape (frames,)."""
    width = round(SMOOTH / STEP) | 1
    window = np.hanning(width + 2)[1:-1]
    power = np.where(frames.active, 10 ** (frames.level / 10), 0.0)
    heard = _about(frames.active.astype(np.float64), window)
    level = 10 * np.log10(_about(power, window) / np.maximum(heard, 1e-9) + 1e-12)
    level -= level[frames.active].mean()
    sure = np.clip(heard / (0.5 * window.sum()), 0, 1)
    return np.asarray(SWING * np.clip(level, -MOST_SWING, MOST_SWING) * sure)


@cache
def _table() -> dict[str, Any]:
    found: dict[str, Any] = asset_table("effort/voice.toml")
    return found | {name: np.array(found[name]) for name in ("mean", "scale", "weights")}


def _about(values: Floats, window: Floats) -> Floats:
    """Weighted sum of what lies about each frame, shape like ``values``, however long the window is."""
    half = len(window) // 2
    return np.convolve(values, window, "full")[half : half + len(values)]
