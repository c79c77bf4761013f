"""From what an engine made of each sentence to one sound with its times."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.long_arrays import GrowingSound, let_go
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.speech.voices.sentences import Sentence
from mien.speech.voices.voice import Break, Speech

__all__ = ["LEVEL", "Piece", "join_pieces"]

LEVEL = 10 ** (-3 / 20)
"""Peak of every voice's sound: -3 dBFS."""
_EDGE_SECONDS = 0.2
_PAUSE_SECONDS = {".": 0.4, "?": 0.4, "!": 0.4, ";": 0.3, ":": 0.3, ",": 0.2, "-": 0.2, "": 0.1}
_QUIET = 10 ** (-50 / 20)
_MARGIN_SECONDS = 0.03
_FADE_SECONDS = 0.005
_SHORTEST = 1e-4
_BLOCK = 2**20  # samples


@dataclass(frozen=True)
class Piece:
    """The sound of one sentence, as the engine gave it.

    Attributes
    ----------
    samples : ndarray, shape (n,)
        Any level.
    rate : int
        Samples per second, the same for all pieces of one sound.
    phones, words : sequence of Interval
        Seconds from the piece's start; pauses may be left out. Empty if the engine has no times.
    sentence : Sentence
        What is said; the mark at its end sets the pause after it.
    """

    samples: NDArray[np.floating]
    rate: int
    phones: Sequence[Interval]
    words: Sequence[Interval]
    sentence: Sentence


def join_pieces(pieces: Iterable[Piece]) -> Speech:
    """Put sentences one after another: silence at both ends trimmed to 0.2 s, pauses by punctuation, peak -3 dBFS.

    There are times only where the engine gave them for every sentence.
    """
    remaining = iter(pieces)
    first = next(remaining)
    rate = first.rate
    sound, pause = GrowingSound(rate), _EDGE_SECONDS
    phones: list[Interval] = []
    words: list[Interval] = []
    breaks: list[Break] = []
    complete = True
    for piece in chain([first], remaining):
        complete = complete and bool(piece.phones)
        sound.add(np.zeros(round(pause * rate)))
        samples, before = _trimmed(np.asarray(piece.samples, dtype=np.float64), rate)
        shift = len(sound) / rate - before / rate
        low, high = shift + before / rate, shift + (before + len(samples)) / rate
        phones += _moved(piece.phones, shift, low, high)
        words += _moved(piece.words, shift, low, high)
        sound.add(samples)
        pause = _PAUSE_SECONDS[piece.sentence.mark]
        said = len(piece.sentence.words) + (breaks[-1].words if breaks else 0)
        breaks.append(Break(high + pause / 2, said))
    sound.add(np.zeros(round(_EDGE_SECONDS * rate)))
    audio = Audio.taking(_levelled(sound.taken()), rate)  # ten thousand words are not held three times
    if not complete or not phones:
        return Speech(audio, None, None, tuple(breaks[:-1]))
    tiers = _with_pauses(phones, audio.duration), Tier("words", tuple(words))
    return Speech(audio, *tiers, tuple(breaks[:-1]))


def _trimmed(samples: NDArray[np.float64], rate: int) -> tuple[NDArray[np.float64], int]:
    """Without the silence at its ends (a margin stays), faded in and out; and how many samples went in front."""
    loud = np.flatnonzero(np.abs(samples) > _QUIET * np.abs(samples).max(initial=0.0))
    if not len(loud):
        return samples[:0], 0
    margin, fade = round(_MARGIN_SECONDS * rate), round(_FADE_SECONDS * rate)
    first, last = max(0, int(loud[0]) - margin), min(len(samples), int(loud[-1]) + margin)
    body = samples[first:last].copy()
    ramp = np.linspace(0.0, 1.0, min(fade, len(body)))
    body[: len(ramp)] *= ramp
    body[len(body) - len(ramp) :] *= ramp[::-1]
    return body, first


def _moved(intervals: Sequence[Interval], shift: float, low: float, high: float) -> list[Interval]:
    """Later by ``shift`` and inside ``low``..``high``; what falls outside goes."""
    moved = [
        Interval(min(max(i.start + shift, low), high), min(max(i.end + shift, low), high), i.label) for i in intervals
    ]
    return [interval for interval in moved if interval.duration > _SHORTEST]


def _with_pauses(phones: Sequence[Interval], duration: float) -> Tier:
    """Fill every gap with a pause, and make one pause of neighbours."""
    filled: list[Interval] = []
    end = 0.0
    for phone in [*phones, Interval(duration, duration, PAUSE)]:
        if phone.start > end + _SHORTEST:
            _append(filled, Interval(end, phone.start, PAUSE))
        if phone.duration > 0:
            _append(filled, Interval(end if phone.start < end + _SHORTEST else phone.start, phone.end, phone.label))
        end = max(end, phone.end)
    return Tier("phones", tuple(filled))


def _append(phones: list[Interval], phone: Interval) -> None:
    if phones and phone.label == PAUSE == phones[-1].label:
        phones[-1] = Interval(phones[-1].start, phone.end, PAUSE)
    else:
        phones.append(phone)


def _levelled(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """In place."""
    parts = [samples[start : start + _BLOCK] for start in range(0, len(samples), _BLOCK)]
    mean, peak = np.float32(sum(float(part.sum(dtype=np.float64)) for part in parts) / max(len(samples), 1)), 0.0
    for part in parts:
        part -= mean
        peak = max(peak, float(np.abs(part).max()))
        let_go(samples)
    for part in parts if peak > 0 else ():
        part *= np.float32(LEVEL / peak)
        let_go(samples)
    return samples
