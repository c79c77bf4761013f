"""Made-up recordings of a whole face, neutral and with a known expression, for tests of learned expressions."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take
from mien.face.library import load_face
from mien.motion.drift import smooth_drift
from mien.motion.expression.hand_made_performance import marker_basis
from mien.motion.maps.emotion_maps import EmotionMaps, learn_emotion_maps

LAYOUT = "mediapipe-218"
RATE = FrameRate.of(60)
VOWELS = {"AA": 0.5, "IY": 0.15, "UW": 0.1, "AE": 0.4, "M": 0.0, "S": 0.05, "T": 0.1, "SIL": 0.0}
KNOWN = {"happy": ("mouthSmileLeft", "mouthSmileRight"), "surprised": ("browInnerUp", "eyeWideLeft", "eyeWideRight")}


@cache
def basis() -> NDArray[np.float64]:
    return marker_basis(load_face("default"), LAYOUT, load_layout(LAYOUT).markers)


def speech(phones: Tier, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Channels of the speaking mouth: the jaw opens as far as each phone asks, smoothly."""
    values = np.zeros((len(times), len(channels.ALL)))
    middles = [phone.middle for phone in phones]
    values[:, channels.ALL.index("jawOpen")] = np.interp(times, middles, [VOWELS[phone.label] for phone in phones])
    return values


def expression(emotion: str, times: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
    """A known expression: held at 0.5, wandering by 0.1."""
    values = np.zeros((len(times), len(channels.ALL)))
    weight = 0.5 + 0.1 * smooth_drift(times, 0.4, np.random.default_rng(seed))
    for name in KNOWN.get(emotion, ()):
        values[:, channels.ALL.index(name)] = weight
    return values


def take(sentence: int, emotion: str, stretch: float = 0.0, noise: float = 0.0) -> Take:
    """One sentence of made-up phones; ``stretch`` is how unevenly the phones of this take are lengthened."""
    random = np.random.default_rng(sentence)
    labels = ["SIL", *random.choice([name for name in VOWELS if name != "SIL"], 20).tolist(), "SIL"]
    lengths = random.uniform(0.08, 0.14, len(labels))
    uneven = np.random.default_rng([sentence, *emotion.encode()])
    lengths *= np.exp(stretch * uneven.standard_normal(len(labels)))
    ends = np.cumsum(lengths)
    phones = Tier("phones", tuple(Interval(e - n, e, x) for e, n, x in zip(ends, lengths, labels, strict=True)))
    times = RATE.times(RATE.frames_covering(float(ends[-1])))
    weights = speech(phones, times) + expression(emotion, times, sentence)
    moved = (weights @ basis()).reshape(len(times), -1, 3)
    positions = load_layout(LAYOUT).places + moved + noise * uneven.standard_normal(moved.shape)
    words = Tier("words", (Interval(lengths[0], ends[-2], f"sentence{sentence}"),))
    return Take(
        name=f"s{sentence}-{emotion}",
        audio=Audio.silence(float(ends[-1]), 8000),
        markers=MarkerTrack(load_layout(LAYOUT).markers, positions, RATE),
        text=f"sentence {sentence}",
        words=words,
        phones=phones,
        layout=LAYOUT,
        emotion=emotion,
        sentence=f"s{sentence}",
        speaker="made-up",
    )


@cache
def emotion_maps() -> EmotionMaps:
    """Maps between the three, from four sentences."""
    maps = learn_emotion_maps(takes(4, stretch=0.1))
    assert maps is not None
    return maps


def takes(sentences: int = 4, stretch: float = 0.25, noise: float = 0.05) -> list[Take]:
    """Each sentence neutral, happy and surprised."""
    return [
        take(sentence, emotion, 0.0 if emotion == "neutral" else stretch, noise)
        for sentence in range(sentences)
        for emotion in ("neutral", *KNOWN)
    ]
