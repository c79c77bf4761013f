"""Takes whose motion follows a known rule, for tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from tests.utterances import utterance

LAYOUT = load_layout("mediapipe-218")
MOUTH = LAYOUT.groups["mouth"]
UPPER, LOWER = LAYOUT.landmarks[13], LAYOUT.landmarks[14]
OPENINGS = {"SIL": 0.5, "M": 0.2, "AA": 14.0, "T": 5.0, "IY": 7.0}
SYLLABLES = {"ma": ("M", "AA"), "tea": ("T", "IY"), "me": ("M", "IY"), "ta": ("T", "AA")}


def opened(opening: NDArray[np.float64]) -> NDArray[np.float64]:
    """A mouth (48 markers at rest) whose lower lip's middle hangs so far below the upper one's, (frames, 48, 3)."""
    rest = np.array([LAYOUT.place(name) for name in MOUTH])
    positions = np.tile(rest, (len(opening), 1, 1))
    positions[:, MOUTH.index(LOWER)] = positions[:, MOUTH.index(UPPER)]
    positions[:, MOUTH.index(LOWER), 1] -= opening
    return positions


def keyed_opening(phones: Tier, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each phone's opening in its middle, half a cosine wave between."""
    middles = [phone.middle for phone in phones]
    place = np.interp(times, middles, np.arange(len(middles), dtype=float))
    values = np.array([OPENINGS[phone.label] for phone in phones])
    before = np.minimum(place.astype(int), len(values) - 2)
    share = (1 - np.cos(np.pi * (place - before))) / 2
    return (1 - share) * values[before] + share * values[before + 1]


def spoken(name: str, words: tuple[str, ...], *, duration: float = 0.16, noise: float = 0.0, seed: int = 0) -> Take:
    """A take that says the words without pauses between them."""
    phones = [("SIL", 0.4), *((p, duration) for word in words for p in SYLLABLES[word]), ("SIL", 0.4)]
    speech = utterance(*phones, rate=1000)
    rate = FrameRate.of(25)
    times = rate.times(rate.frames_covering(speech.duration))
    positions = opened(keyed_opening(speech.phones, times))
    positions += np.random.default_rng(seed).normal(0, noise, positions.shape)
    starts = 0.4 + 2 * duration * np.arange(len(words))
    tier = Tier("words", tuple(Interval(s, s + 2 * duration, w) for s, w in zip(starts, words, strict=True)))
    return Take(
        name=name,
        audio=speech.audio,
        markers=MarkerTrack(MOUTH, positions, rate),
        text=" ".join(words),
        words=tier,
        phones=speech.phones,
        layout="mediapipe-218",
    )


def takes(number: int = 16, *, noise: float = 0.0) -> list[Take]:
    """Takes of three words each, drawn at random."""
    random = np.random.default_rng(5)
    vocabulary = tuple(SYLLABLES)
    return [
        spoken(
            f"take{i:02d}",
            tuple(vocabulary[w] for w in random.integers(0, len(vocabulary), 3)),
            duration=float(random.choice([0.12, 0.16, 0.2])),
            noise=noise,
            seed=i,
        )
        for i in range(number)
    ]


def corpus(folder: Path, number: int = 16, *, noise: float = 0.05) -> Corpus:
    """The same, on disk."""
    made = Corpus.create(folder, {"layout": "mediapipe-218"})
    for take in takes(number, noise=noise):
        made.add(take)
    return made
