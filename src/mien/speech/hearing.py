"""A whole sound as the live network hears it: how likely each phone is in each row of 10 ms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.long_arrays import let_go
from mien.core.one_thread import one_thread
from mien.core.utterance import PAUSE
from mien.speech.frame_classifier import FrameClassifier, FrameStream, default_classifier
from mien.speech.streaming_features import HOP, RATE, WINDOW, StreamingFeatures

__all__ = ["Hearing", "hear", "loudness_spread"]

SHARE = 0.5
"""How far the answers are freed of how often each phone was heard in learning, 0..1."""
FUTURE, STEP = 60, 200
"""As in `mien.speech.frame_classifier`: here all of a sound is known."""
QUIET_SPREAD, NOISY_SPREAD = 26.0, 16.0
"""Decibels from the quiet to the loud of a sound (`loudness_spread`): noise 20 dB below a voice leaves the first."""
PAUSE_IN_NOISE = 2.0
"""What a row of pause costs more in noise: the network takes what it cannot hear for a pause (natural logarithm)."""
_BLOCK = 20 * RATE

Single = NDArray[np.float32]


class Hearing:
    """Log likelihoods of the labels in each row of a sound.

    Parameters
    ----------
    labels : tuple of str
    rows : ndarray, shape (rows, labels)
    """

    def __init__(self, labels: tuple[str, ...], rows: Single) -> None:
        self.labels, self.rows = labels, rows
        self._best = rows.max(axis=1, initial=-np.inf)
        self._index = {label: number for number, label in enumerate(labels)}

    def score(self, label: str, first: int, last: int) -> float:
        """How much less likely a label is than the likeliest one, mean over some rows: natural logarithm, 0 at best."""
        return float((self.rows[first:last, self._index[label]] - self._best[first:last]).mean())

    def edge(self, row: int, before: str, after: str) -> float:
        """Seconds at which one label gives way to the next, whose first row it is: where both are equally likely."""
        here = row * HOP / RATE
        if not 0 < row < len(self.rows):
            return here - HOP / RATE / 2
        lead = self.rows[row - 1 : row + 1, self._index[before]] - self.rows[row - 1 : row + 1, self._index[after]]
        share = float(np.clip(lead[0] / max(float(lead[0] - lead[1]), 1e-6), 0.0, 1.0))
        return here - (1 - share) * HOP / RATE


@one_thread
def hear(audio: Audio, classifier: FrameClassifier | None = None) -> Hearing:
    """Listen to a sound once, in blocks.

    Parameters
    ----------
    audio : Audio
        Any rate and level.
    classifier : FrameClassifier or None
        None takes the one that ships.
    """
    network = classifier or default_classifier()
    samples, count = audio.resampled(RATE).samples, 0
    rows = np.empty((len(samples) // HOP + 2, len(network.labels)), np.float32)
    for answer in _answers(samples, network):
        rows[count : count + len(answer)] = answer - SHARE * network.log_share
        count += len(answer)
    rows = rows[:count]
    noise = (QUIET_SPREAD - loudness_spread(audio)) / (QUIET_SPREAD - NOISY_SPREAD)
    rows[:, network.labels.index(PAUSE)] -= np.float32(PAUSE_IN_NOISE * min(max(noise, 0.0), 1.0))
    return Hearing(network.labels, rows)


def loudness_spread(audio: Audio) -> float:
    """Decibels from the tenth to the ninety-fifth percentile of the power of frames of 20 ms.

    Examples
    --------
    >>> round(loudness_spread(Audio([0.1, -0.1] * 4000 + [0.01, -0.01] * 4000, 16000)))
    20
    """
    size = max(1, round(0.02 * audio.rate))
    frames = audio.samples[: len(audio.samples) // size * size].reshape(-1, size)
    if not len(frames):
        return QUIET_SPREAD
    powers = np.empty(len(frames))
    for start in range(0, len(frames), 1000):
        part = frames[start : start + 1000]
        powers[start : start + 1000] = np.einsum("ij,ij->i", part, part, dtype=np.float64)
        let_go(audio.samples)
    powers = 10 * np.log10(powers / size + 1e-10)
    low, high = np.percentile(powers, [10, 95])
    return float(high - low)


def _answers(samples: NDArray[np.floating], network: FrameClassifier) -> Iterator[Single]:
    features, frames = StreamingFeatures(), FrameStream(network, FUTURE, STEP)
    for start in range(0, len(samples), _BLOCK):
        yield frames.push(features.push(samples[start : start + _BLOCK]))
        let_go(samples)
    yield frames.push(features.push(np.zeros(WINDOW // 2, np.float32)))
    yield frames.pending()
