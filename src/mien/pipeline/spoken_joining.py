"""Segments that were spoken one by one, joined into one utterance with real silence between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.text.spoken_text import SpokenText

__all__ = ["Joined", "Joiner", "WordPlace", "over_longer_sound", "with_pauses"]

_MARGIN = 0.03  # seconds of an engine's own edge that stay, since the sound fades there


@dataclass(frozen=True)
class WordPlace:
    """Which characters of which segment a spoken word stands for."""

    segment: int
    start: int
    end: int


@dataclass(frozen=True)
class Joined:
    """An utterance whose words know their places in the script: word ``i`` of the tier is ``places[i]``."""

    utterance: Utterance
    places: tuple[WordPlace, ...]


class Joiner:
    """Takes pieces in order; each knows how much silence is to be before its first word."""

    def __init__(self, rate: int) -> None:
        self.rate = rate
        self.samples: list[NDArray[np.float32]] = []
        self.words: list[Interval] = []
        self.phones: list[Interval] = []
        self.native: list[Interval] = []
        self.shapes: list[tuple[str, ...]] = []
        self.foreign = False
        self.places: list[WordPlace] = []
        self.length = 0
        self.last = 0.0

    @property
    def now(self) -> float:
        """Seconds so far."""
        return self.length / self.rate

    def add(self, piece: Utterance, spoken: SpokenText, segment: int, silence: float | None) -> None:
        """One segment; ``silence`` in seconds from the last sound so far to its first, None as the voice has it."""
        audio = piece.audio.resampled(self.rate)
        said = [phone for phone in piece.phones if phone.label != PAUSE]
        lead = said[0].start if said else 0.0
        tail = self.now - self.last
        skip = 0.0
        if silence is not None:
            surplus = tail + lead - silence
            if surplus > 0:
                cut = min(surplus, max(0.0, tail - _MARGIN))
                self._shorten(cut)
                skip = min(surplus - cut, max(0.0, lead - _MARGIN))
            else:
                self._append(np.zeros(round(-surplus * self.rate), dtype=np.float32))
        first = round(skip * self.rate)
        shift = self.now - first / self.rate
        self._append(audio.samples[first:])
        self.phones += [Interval(p.start + shift, p.end + shift, p.label) for p in said]
        own = [phone for phone in piece.spelled_phones if phone.label != PAUSE]
        self.native += [Interval(p.start + shift, p.end + shift, p.label) for p in own]
        self.shapes += spoken_shapes(piece)
        self.foreign = self.foreign or piece.native is not None
        self.words += [Interval(w.start + shift, w.end + shift, w.label) for w in piece.words]
        self.places += _places(piece, spoken, segment)
        self.last = said[-1].end + shift if said else self.now

    def silence(self, seconds: float) -> None:
        """Silence from the last sound so far to the end of what there is."""
        wanted = seconds - (self.now - self.last)
        if wanted > 0:
            self._append(np.zeros(round(wanted * self.rate), dtype=np.float32))
        else:
            self._shorten(min(-wanted, max(0.0, self.now - self.last - _MARGIN)))

    def _append(self, samples: NDArray[np.float32]) -> None:
        self.samples.append(samples)
        self.length += len(samples)

    def _shorten(self, seconds: float) -> None:
        drop = min(round(seconds * self.rate), self.length)
        whole = np.concatenate([*self.samples, np.zeros(0, dtype=np.float32)])
        self.samples = [whole[: len(whole) - drop]]
        self.length = len(self.samples[0])

    def finish(self, like: Utterance, text: str) -> Utterance:
        """All of it as one utterance that takes language, timing and notes from ``like``."""
        audio = Audio(np.concatenate([*self.samples, np.zeros(0, dtype=np.float32)]), self.rate)
        phones = with_pauses(self.phones, audio.duration)
        return replace(
            like,
            text=text,
            audio=audio,
            words=Tier("words", tuple(self.words)),
            phones=phones,
            native=with_pauses(self.native, audio.duration) if self.foreign else None,
            shapes=shapes_of(phones, self.shapes) if self.foreign else (),
        )


def spoken_shapes(utterance: Utterance) -> list[tuple[str, ...]]:
    """Key shapes of its own of each phone that is no pause."""
    shapes = utterance.shapes or ((),) * len(utterance.phones)
    return [names for phone, names in zip(utterance.phones, shapes, strict=True) if phone.label != PAUSE]


def shapes_of(phones: Tier, spoken: Sequence[tuple[str, ...]]) -> tuple[tuple[str, ...], ...]:
    """Key shapes for each phone of a tier, from those of its phones that are no pauses."""
    following = iter(spoken)
    return tuple(() if phone.label == PAUSE else next(following) for phone in phones)


def over_longer_sound(utterance: Utterance, audio: Audio) -> Utterance:
    """The same over a sound that goes on in silence."""

    def longer(tier: Tier) -> Tier:
        return with_pauses([phone for phone in tier if phone.label != PAUSE], audio.duration)

    phones = longer(utterance.phones)
    shapes = shapes_of(phones, spoken_shapes(utterance)) if utterance.shapes else ()
    native = None if utterance.native is None else longer(utterance.native)
    return replace(utterance, audio=audio, phones=phones, native=native, shapes=shapes)


def _places(piece: Utterance, spoken: SpokenText, segment: int) -> list[WordPlace]:
    """A place for each word of the tier; where voice and text do not count alike, by their share of the text."""
    if len(piece.words) == len(spoken.words):
        return [WordPlace(segment, word.start, word.end) for word in spoken.words]
    shares = np.linspace(0, len(spoken.words) - 1, max(1, len(piece.words))).round().astype(int)
    chosen = [spoken.words[int(share)] for share in shares[: len(piece.words)]]
    return [WordPlace(segment, word.start, word.end) for word in chosen]


def with_pauses(phones: Sequence[Interval], duration: float) -> Tier:
    """Phones with every gap filled by a pause, up to ``duration``."""
    filled: list[Interval] = []
    end = 0.0
    for phone in phones:
        start, stop = min(phone.start, duration), min(phone.end, duration)
        if start > end + 1e-6:
            filled.append(Interval(end, start, PAUSE))
        filled.append(Interval(max(start, end) if start < end else start, max(stop, start), phone.label))
        end = max(end, stop)
    if duration > end + 1e-6 or not filled:
        filled.append(Interval(end, duration, PAUSE))
    return Tier("phones", tuple(filled))
