"""How hard somebody articulates, laid on the mouth (docs/effort.md).

With more effort the jaw opens further and the lips move further from the speaker's mean mouth; with less, less far.
How far for how much is learned from a recorded speaker (`assets/effort/jaw.toml`, made by `tools/learn_effort.py`).
Lips that must be shut, or on the teeth, stay exactly so: loud speakers close them as quiet ones do (Schulman 1989,
Journal of the Acoustical Society of America 85: 295-312).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.assets import asset_table
from mien.core.audio import Audio
from mien.core.time_spans import seconds_away
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.performer import MouthModel
from mien.text.phones import is_vowel, phone_table

__all__ = ["DECIBELS", "EffortGains", "MeanMouth", "articulate", "effort_gains", "mean_mouth"]

Floats = NDArray[np.float64]

DECIBELS = 24.0
"""Decibels of the voice that go with a step of 1 in effort. Hand-made: voices vary by about 30 dB between talking to
somebody close by and shouting to somebody 190 m away (Andersson, Eriksson, Traunmüller 1996, TMH-QPSR 2: 127-130)."""
KNEE = 0.7
"""Weight above which what effort adds to a channel is bent towards 1, which it never reaches. Hand-made."""
EASE = 0.12
"""Seconds around speech over which the mouth comes to its scaled motion. Hand-made."""
_BLOCK = 4096  # frames
_JAW = [channels.ALL.index(name) for name in ("jawOpen", "mouthClose")]
_LIPS = [
    channels.ALL.index(name)
    for name in channels.MOUTH
    if name not in (*channels.TONGUE, "tongueOut", "jawOpen", "mouthClose")
]
_LINE = (
    "DH AH N AO R TH W IH N D AH N D DH AH S AH N W ER D IH S P Y UW T IH NG W IH CH AH V DH EH "
    "M W AA Z DH AH S T R AO NG G ER W EH N AH T R AE V L ER K EY M AH L AO NG R AE P T IH N AH W AO R M K L OW K"
)
"""The beginning of "The North Wind and the Sun": what a person's mean mouth is measured on."""
TURN = 0.10
"""Seconds over which a mouth turns from a consonant that keeps it narrow to a vowel that does not."""
OPENS = {"fricative": 0.2, "affricate": 0.2, "stop": 0.35, "nasal": 0.5, "liquid": 0.6, "glide": 0.6}
"""Hand-made: how much of a louder voice's opening consonants take; vowels take all of it."""


@dataclass(frozen=True)
class EffortGains:
    """How much further a mouth moves at which effort; 1 at effort 1.

    Attributes
    ----------
    efforts : tuple of float
        Rising, from 0 to 2; linear between.
    jaw : tuple of float
        Factor of the jaw's opening.
    lips : tuple of float
        Factor of the lips' distance from their mean.
    """

    efforts: tuple[float, ...]
    jaw: tuple[float, ...]
    lips: tuple[float, ...]

    def at(self, effort: Floats) -> tuple[Floats, Floats]:
        """Factors of jaw and lips, shapes like ``effort``."""
        return np.interp(effort, self.efforts, self.jaw), np.interp(effort, self.efforts, self.lips)


@cache
def effort_gains() -> EffortGains:
    """The gains that were learned.

    Examples
    --------
    >>> jaw, lips = effort_gains().at(np.array([1.0]))
    >>> jaw.tolist(), lips.tolist()
    ([1.0], [1.0])
    """
    table = asset_table("effort/jaw.toml")
    return EffortGains(tuple(table["effort"]), tuple(table["jaw"]), tuple(table["lips"]))


@dataclass(frozen=True)
class MeanMouth:
    """Where somebody's mouth is on average while they speak.

    Attributes
    ----------
    values : ndarray, shape (channels,)
        Weights of `mien.channels.ALL`.
    markers : ndarray, shape (markers, 3), or None
        mm, for a mouth that moves markers.
    """

    values: Floats
    markers: Floats | None = None


_measured: WeakKeyDictionary[MouthModel, MeanMouth] = WeakKeyDictionary()


def mean_mouth(mouth: MouthModel) -> MeanMouth:
    """A person's mean mouth: of a standing line that their model speaks, frames in which the lips are shut left out."""
    if mouth not in _measured:
        lengths = np.array([0.11 if is_vowel(phone) else 0.075 for phone in _LINE.split()])
        ends = 0.3 + np.cumsum(lengths)
        told = zip(ends, lengths, _LINE.split(), strict=True)
        spoken = [Interval(float(end - length), float(end), phone) for end, length, phone in told]
        last = float(ends[-1])
        phones = Tier("phones", (Interval(0.0, spoken[0].start, PAUSE), *spoken, Interval(last, last + 0.3, PAUSE)))
        line = Utterance("", Audio.silence(last + 0.3, 16_000), Tier("words", ()), phones, "en-US", "voice")
        rate = FrameRate.of(30)
        made = mouth.perform(line, rate)
        times = rate.times(len(made.values))
        counted = ((times >= spoken[0].start) & (times < last)) * (1 - made.seal)
        markers = None if made.markers is None else np.average(made.markers.positions, axis=0, weights=counted)
        _measured[mouth] = MeanMouth(np.average(made.values, axis=0, weights=counted), markers)
    return _measured[mouth]


def articulate(
    mouth: MouthMotion, effort: Floats, phones: Tier, rate: FrameRate, mean: MeanMouth, gains: EffortGains | None = None
) -> MouthMotion:
    """A mouth's motion with more or less effort.

    Parameters
    ----------
    mouth : MouthMotion
    effort : ndarray, shape (frames,)
        0 to 2; where it is 1 the motion stays as it is, bit for bit.
    phones : Tier
        Between them, in pauses, the mouth comes to rest as ever.
    rate : FrameRate
    mean : MeanMouth
    gains : EffortGains, optional
        The learned ones if none are given.

    Returns
    -------
    MouthMotion
        Weights in [0, 1]; where ``seal`` is 1 nothing has changed.
    """
    jaw, lips = (gains or effort_gains()).at(effort)
    times = rate.times(len(mouth.values))
    free = (1 - mouth.seal) * _speaking(phones, times)
    grown = _free_to_open(phones, times, rate)
    jaw = 1 + np.where(jaw > 1, (jaw - 1) * grown, jaw - 1) * free
    lips = 1 + (lips - 1) * free
    values = mouth.values.copy()
    for first in range(0, len(values), _BLOCK):  # a long line is not held many times over
        here, after = slice(first, first + _BLOCK), values[first : first + _BLOCK]
        before, same = mouth.values[here], effort[here] == 1
        after[:, _JAW] = _bounded(before[:, _JAW] * jaw[here, None], before[:, _JAW])
        moved = mean.values[_LIPS] + (before[:, _LIPS] - mean.values[_LIPS]) * lips[here, None]
        after[:, _LIPS] = _bounded(moved, before[:, _LIPS])
        after[same] = before[same]
    return replace(mouth, values=values, markers=_moved_markers(mouth.markers, lips, mean))


def _bounded(wanted: Floats, before: Floats) -> Floats:
    """Weights not below 0; those that have grown bend towards 1 above `KNEE`, but are not less than before."""
    bent = KNEE + (1 - KNEE) * np.tanh((wanted - KNEE) / (1 - KNEE))
    grown = np.maximum(before, np.where(wanted > KNEE, bent, wanted))
    return np.asarray(np.where(wanted > before, grown, np.maximum(wanted, 0)))


def _speaking(phones: Tier, times: Floats) -> Floats:
    """1 in speech, 0 in pauses, half a cosine of `EASE` outside the speech, shape (times,)."""
    away = seconds_away([phone for phone in phones if phone.label != PAUSE], times)
    return np.asarray((1 + np.cos(np.pi * np.clip(away / EASE, 0, 1))) / 2)


def _free_to_open(phones: Tier, times: Floats, rate: FrameRate) -> Floats:
    """How much of a greater opening each moment takes, 0 to 1, shape (times,): a hiss keeps its narrow gap.

    Shares by manner (`OPENS`, hand-made), eased over `TURN`.
    """
    share = np.ones(len(times))
    manners = phone_table()
    for phone in phones:
        if phone.label in manners:
            first, after = np.searchsorted(times, (phone.start, phone.end))
            share[first:after] = OPENS.get(manners[phone.label].manner, 1.0)
    width = max(1, round(TURN * rate.fps)) | 1
    window = np.hanning(width + 2)[1:-1]
    padded = np.pad(share, width // 2, mode="edge")
    return np.asarray(np.convolve(padded, window / window.sum(), mode="valid"))


def _moved_markers(markers: MarkerTrack | None, lips: Floats, mean: MeanMouth) -> MarkerTrack | None:
    """Markers as far from their mean as the lips are from theirs."""
    if markers is None or mean.markers is None:
        return markers
    positions = mean.markers + (markers.positions - mean.markers) * lips[:, None, None]
    return replace(markers, positions=np.where((lips == 1)[:, None, None], markers.positions, positions))
