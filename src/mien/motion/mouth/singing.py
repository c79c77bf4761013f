"""What singing adds to the mouth: the jaw follows the voice in vowels, and breath is taken in rests. Hand-made.

A singer opens the jaw further the higher and louder a vowel is (Sundberg and Skoog 1997, Journal of Voice 11: from
about where the pitch reaches the vowel's first formant). Here the jaw opens by a share of what the vowel itself asks
plus an amount that grows with level and pitch; lips that must be shut stay shut.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE, Utterance
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.speech.pitch import level_contour, pitch_contour
from mien.text.phones import is_vowel

__all__ = ["sing"]

Floats = NDArray[np.float64]

WIDER = 0.35  # share by which a vowel's own opening grows at full voice
OPENING = 0.12  # jawOpen that is added at full voice
LOUD_RANGE = 15.0  # decibels under the loudest vowel at which a voice adds nothing
HIGH_RANGE = 9.0  # semitones over the song's middle pitch at which a voice adds most
EASE = 0.07  # seconds over which the jaw comes to a vowel
BREATH = 0.34  # seconds before a line at which breath is taken
SHORTEST_REST = 0.4  # seconds of rest in which it is
BREATH_JAW = 0.16
_JAW = channels.ALL.index("jawOpen")
_PARTED = [channels.ALL.index(f"mouth{part}{side}") for part in ("LowerDown", "UpperUp") for side in ("Left", "Right")]


def sing(mouth: MouthMotion, utterance: Utterance, rate: FrameRate) -> MouthMotion:
    """The mouth of a song from that of its words, spoken at its pace."""
    times = rate.times(len(mouth.values))
    values = mouth.values.copy()
    free = 1 - mouth.seal
    effort = _effort(utterance, times) * free
    values[:, _JAW] = np.clip(values[:, _JAW] * (1 + WIDER * effort) + OPENING * effort, 0, 1)
    breath = _breaths(utterance, times) * free
    values[:, _JAW] = np.maximum(values[:, _JAW], BREATH_JAW * breath)
    values[:, _PARTED] = np.maximum(values[:, _PARTED], 0.10 * breath[:, None])
    return replace(mouth, values=values)


def _effort(utterance: Utterance, times: Floats) -> Floats:
    """0 outside vowels, up to 1 in high and loud ones."""
    vowels = [phone for phone in utterance.phones if is_vowel(phone.label)]
    if not vowels:
        return np.zeros(len(times))
    level, pitch = level_contour(utterance.audio, window=0.1), pitch_contour(utterance.audio, highest=1000.0)
    semitones = np.nan_to_num(12 * np.log2(pitch.hertz_at(times) / pitch.median))
    decibels = level.decibels_at(times)
    loudest = max(float(level.decibels_at(phone.middle)) for phone in vowels)
    loud = np.clip(1 + (decibels - loudest) / LOUD_RANGE, 0, 1)
    high = np.clip(0.5 + 0.5 * semitones / HIGH_RANGE, 0, 1)
    inside = np.zeros(len(times))
    for phone in vowels:
        ramp = np.clip(np.minimum(times - phone.start, phone.end - times) / EASE + 0.5, 0, 1)
        inside = np.maximum(inside, (1 - np.cos(np.pi * ramp)) / 2)
    return np.asarray(inside * (0.6 * loud + 0.4 * high))


def _breaths(utterance: Utterance, times: Floats) -> Floats:
    """A breath before each line: in over most of the rest's end, out of the way when the line begins."""
    found = np.zeros(len(times))
    for phone in utterance.phones:
        if phone.label == PAUSE and phone.duration >= SHORTEST_REST and phone.end < utterance.duration - 1e-6:
            passed = np.clip((times - (phone.end - BREATH)) / BREATH, 0, 1)
            found = np.maximum(found, np.sin(np.pi * passed) ** 2)
    return found
