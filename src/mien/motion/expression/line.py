"""How the strength of an emotion goes with the line that is spoken.

Nobody is equally angry for forty seconds: a felt emotion swells on the words that carry it, ebbs where the voice rests,
and opens the mouth while there is speech. Both curves multiply what is asked for; the figures are hand-made
(``[line]`` in ``assets/performance/emotions.toml``). That facial movement strengthens on stressed syllables is measured
by Cvejic, Kim & Davis 2010 (Speech Communication 52(6)) and by Swerts & Krahmer 2008 (Journal of Phonetics 36(2)). At a
sibilant the teeth stay close however loud one speaks (Mooshammer, Hoole & Geumann 2007, Language and Speech 50(2)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.emotions import emotion_table
from mien.core.time_spans import places_within, seconds_away
from mien.core.timeline import FrameRate, Interval
from mien.core.utterance import PAUSE, Utterance
from mien.speech.stressed_vowels import StressedWord

__all__ = ["Line", "line_of"]

Floats = NDArray[np.float64]
_FAR = 6.5  # times its reach: an accent has less than 1e-18 left there
_SIBILANTS = frozenset({"S", "Z", "SH", "ZH", "CH", "JH"})
_JAW = channels.ALL.index("jawOpen")


@dataclass(frozen=True, eq=False)
class Line:
    """What a line asks of an emotion, frame by frame.

    Attributes
    ----------
    strength : ndarray, shape (frames,)
        Multiplies the emotion: about 1, more on accents, less in pauses.
    speaking : ndarray, shape (frames,)
        Multiplies what the emotion adds to a speaking mouth: 0 in pauses, about 1 in speech, more on open phones.
    """

    strength: Floats
    speaking: Floats


def line_of(utterance: Utterance, words: Sequence[StressedWord], mouth: Floats, rate: FrameRate) -> Line:
    """The line of an utterance.

    Parameters
    ----------
    utterance : Utterance
    words : sequence of StressedWord
        Its words (`mien.speech.stressed_vowels.stressed_words`).
    mouth : ndarray, shape (frames, channels)
        What the phones ask of the mouth, `mien.core.channels.ALL`.
    rate : FrameRate

    Returns
    -------
    Line
        Of as many frames as ``mouth`` has.

    Examples
    --------
    >>> from mien.core.audio import Audio
    >>> from mien.core.timeline import Interval, Tier
    >>> phones = Tier("phones", (Interval(0.0, 1.0, "SIL"), Interval(1.0, 2.0, "AA")))
    >>> silent = Utterance("", Audio.silence(2.0, 1000), Tier("words", ()), phones, "en", "none")
    >>> line = line_of(silent, (), np.zeros((50, len(channels.ALL))), FrameRate.of(25))
    >>> float(line.speaking[0]), bool(line.speaking[40] > 0.4), float(line.strength[0].round(2))
    (0.0, True, 0.85)
    """
    table = emotion_table()["line"]
    times = rate.times(len(mouth))
    heard = _heard(utterance, times, table["settle"])
    strength = table["pause"] + (1 - table["pause"]) * _heard(utterance, times, table["ebb"])
    if words:
        levels = np.array([word.level for word in words])
        over = np.clip(np.nan_to_num((levels - np.median(levels)) / table["level_unit"]), -1.0, 1.0) * [
            not w.weak for w in words
        ]
        for word, share in zip(words, over, strict=True):
            middle, far = (word.vowel_start + word.vowel_end) / 2, _FAR * table["reach"]
            here = places_within(times, middle - far, middle + far)
            near = (times[here] - middle) / table["reach"]
            strength[here] += table["accent"] * share * np.exp(-(near**2))
    jaw = mouth[:, _JAW]
    typical = float(jaw[heard > 0.5].mean()) if (heard > 0.5).any() else 0.0
    openness = np.clip(jaw / typical, 0.0, table["widest"]) if typical > 0 else np.ones(len(jaw))
    hissing = _near([p for p in utterance.phones if p.label in _SIBILANTS], times, table["glide"])
    speaking = heard * (1 - table["with_jaw"] + table["with_jaw"] * openness) * (1 - (1 - table["sibilant"]) * hissing)
    return Line(np.asarray(strength), np.asarray(speaking))


def _heard(utterance: Utterance, times: Floats, settle: float) -> Floats:
    """1 in speech and 0 in pauses."""
    return _near([phone for phone in utterance.phones if phone.label != PAUSE], times, settle)


def _near(phones: Sequence[Interval], times: Floats, settle: float) -> Floats:
    """1 in these phones and 0 away from them, half a cosine of ``settle`` seconds between."""
    away = seconds_away(phones, times)
    return np.asarray((1 + np.cos(np.pi * np.clip(away / settle, 0.0, 1.0))) / 2)
