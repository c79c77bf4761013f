"""The mouth one frame at a time, from phones that are still being revised.

A performer's own mouth model (learned curves, or the hand-made mouth) is asked for the few frames about an instant,
with the phones that are known by then, and a guess at what follows (`expected`). Where phones were revised, the
motion would jump from one answer to another: the difference between what was shown and what is answered now for the
same instant is carried over and dies away within `HAND_OVER`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.mouth.learned_mouth import LearnedMouth
from mien.motion.performer import MouthModel
from mien.text.phones import is_vowel

__all__ = ["HAND_OVER", "StreamingMouth", "expected", "without_sound"]

Floats = NDArray[np.float64]

HAND_OVER = 0.035
"""Seconds in which a difference from revised phones falls to 37 %."""
_BEFORE = 3  # frames asked for besides the one that is shown: the models hold neighbouring frames together
_GOES_ON = 0.35  # seconds of what is guessed
_TYPICAL_VOWEL, _TYPICAL_CONSONANT = 0.11, 0.07
_AFTER_VOWEL, _AFTER_CONSONANT = "T", "AH"  # phones that ask little of the lips
_QUIET = 1000  # Hz of the silence that stands in for the sound


def without_sound(mouth: MouthModel) -> MouthModel:
    """The same performer's mouth with the speech model that needs the phones alone."""
    return LearnedMouth(mouth.learned, speech_model="coarticulation") if isinstance(mouth, LearnedMouth) else mouth


def expected(phones: Tier) -> Tier:
    """The phones with what may come: the last one lasts as such a phone usually does, then a neutral one follows.

    Without it the models would take it that a pause follows, and shut the mouth.

    Examples
    --------
    >>> known = Tier("phones", (Interval(0.0, 0.2, "SIL"), Interval(0.2, 0.22, "M")))
    >>> [(round(phone.end, 2), phone.label) for phone in expected(known)]
    [(0.2, 'SIL'), (0.27, 'M'), (0.62, 'AH')]
    """
    if not len(phones):
        return phones
    *before, last = phones.intervals
    if last.label == PAUSE:
        return Tier(phones.name, (*before, Interval(last.start, last.end + _GOES_ON, PAUSE)))
    vowel = is_vowel(last.label)
    end = max(last.end, last.start + (_TYPICAL_VOWEL if vowel else _TYPICAL_CONSONANT))
    following = Interval(end, end + _GOES_ON, _AFTER_VOWEL if vowel else _AFTER_CONSONANT)
    return Tier(phones.name, (*before, Interval(last.start, end, last.label), following))


class StreamingMouth:
    """Frames of a mouth in order of time.

    Parameters
    ----------
    mouth : MouthModel
        Asked with phones and without sound; see `without_sound`.
    rate : FrameRate
        Of the frames.
    """

    def __init__(self, mouth: MouthModel, rate: FrameRate) -> None:
        self.mouth, self.rate = mouth, rate
        self._shown: tuple[float, Floats] | None = None

    def frame(self, seconds: float, phones: Tier) -> tuple[Floats, float]:
        """The mouth at an instant.

        Parameters
        ----------
        seconds : float
            On the clock of the phones; later than that of the frame before, or the same.
        phones : Tier
            What is known of the phones about the instant, up to the last sound heard.

        Returns
        -------
        values : ndarray, shape (channels,)
            In the order of `mien.core.channels.ALL`.
        seal : float
            0..1, as in `MouthMotion`.
        """
        motion = self._asked(seconds, expected(phones))
        values, seal = motion.values[_BEFORE], float(motion.seal[_BEFORE])
        if self._shown is not None:
            passed = max(0.0, seconds - self._shown[0])
            back = min(_BEFORE, round(passed * self.rate.fps))
            missing = self._shown[1] - motion.values[_BEFORE - back]
            values = values + missing * math.exp(-passed / HAND_OVER) * (1 - seal)
        values[: len(channels.WEIGHTS)] = np.clip(values[: len(channels.WEIGHTS)], 0.0, 1.0)
        self._shown = (seconds, values)
        return values.copy(), seal

    def _asked(self, seconds: float, phones: Tier) -> MouthMotion:
        start = seconds - self.rate.time_of(_BEFORE)
        known = phones.shifted(-start)
        sound = Audio.silence(self.rate.time_of(_BEFORE + 2), _QUIET)
        utterance = Utterance("", sound, Tier("words", ()), known, "und", "recognised")
        return self.mouth.perform(utterance, self.rate)
