"""Phones out of sound that is still coming in: the likeliest row of phones, revised as more is heard.

Viterbi's algorithm over the answers of `frame_classifier`, one step for each row of 10 ms. A phone lasts `SHORTEST`
rows or longer, and what follows what is weighed by how often it does. The last rows, which the network judged without
all of the sound that it could use, are judged anew each time; only rows older than that are settled. What is older than
`MEMORY` is forgotten: a stream of any length takes the same space.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.speech.frame_classifier import FrameClassifier, FrameStream, default_classifier
from mien.speech.streaming_features import HOP, RATE, StreamingFeatures

__all__ = ["DecodingSettings", "PhoneStream"]

SHORTEST = 3
"""Rows that a phone lasts at least."""
_BILABIALS = ("P", "B", "M")
MEMORY = 1.2
"""Seconds of phones that are kept."""

Floats = NDArray[np.float64]
_Step = tuple[NDArray[np.int16], NDArray[np.bool_]]


@dataclass(frozen=True)
class DecodingSettings:
    """How the row of phones is chosen.

    Attributes
    ----------
    share : float
        How far the answers are freed of how often each phone was heard in learning, 0..1.
    change : float
        What a new phone costs (natural logarithm).
    follow : float
        How much counts what usually follows what.
    shut : float
        What a row of /p b m/ costs (natural logarithm): lips that are shut and should not be are seen more than lips
        that should be shut and are not quite, and in learning these phones counted for more than they are heard.
    """

    share: float = 0.3
    change: float = 1.5
    follow: float = 0.6
    shut: float = 0.6


@dataclass
class _Paths:
    """Scores of the best rows of phones by how long the last phone has lasted, shape (SHORTEST, labels)."""

    scores: Floats

    def step(self, heard: Floats, follow: Floats) -> tuple[_Paths, _Step]:
        """One row on; for each label which one it came from if it is new, and whether its last stage was stayed in."""
        entering = self.scores[-1][:, None] + follow
        source = entering.argmax(axis=0)
        new = np.empty_like(self.scores)
        new[0] = entering[source, np.arange(len(source))]
        new[1:] = self.scores[:-1]
        stayed = self.scores[-1] >= new[-1]
        new[-1] = np.maximum(new[-1], self.scores[-1])
        new += heard
        new -= new.max()
        return _Paths(new), (source.astype(np.int16), stayed)


class PhoneStream:
    """Hears 16 kHz sound in pieces and tells the phones of the last second.

    Parameters
    ----------
    classifier : FrameClassifier or None
        None takes the one that ships.
    settings : DecodingSettings or None

    Examples
    --------
    >>> stream = PhoneStream()
    >>> stream.push(np.zeros(16000))
    >>> [phone.label for phone in stream.phones()]
    ['SIL']
    """

    def __init__(self, classifier: FrameClassifier | None = None, settings: DecodingSettings | None = None) -> None:
        self.classifier = classifier or default_classifier()
        self.settings = settings or DecodingSettings()
        self._features = StreamingFeatures()
        self._frames = FrameStream(self.classifier)
        labels = len(self.classifier.labels)
        shut = [self.settings.shut * (label in _BILABIALS) for label in self.classifier.labels]
        self._prior = self.settings.share * self.classifier.log_share + np.array(shut)
        self._follow = np.asarray(self.settings.follow * self.classifier.log_follow - self.settings.change, np.float64)
        np.fill_diagonal(self._follow, -np.inf)
        start = np.full((SHORTEST, labels), -1e3)
        start[-1, self.classifier.labels.index(PAUSE)] = 0.0
        self._paths = _Paths(start)
        self._steps: deque[_Step] = deque(maxlen=round(MEMORY * RATE / HOP))
        self._samples = 0

    @property
    def heard(self) -> float:
        """Seconds of sound that came in."""
        return self._samples / RATE

    def push(self, samples: NDArray[np.floating]) -> None:
        """Take samples (16 kHz, -1..1)."""
        self._samples += len(samples)
        for heard in self._freed(self._frames.push(self._features.push(samples))):
            self._paths, step = self._paths.step(heard, self._follow)
            self._steps.append(step)

    def _freed(self, answers: NDArray[np.float32]) -> Floats:
        return np.asarray(answers - self._prior, dtype=np.float64)

    def phones(self, whole: bool = True) -> Tier:
        """The likeliest phones, from at most `MEMORY` before the settled rows up to the last row.

        ``whole`` False leaves out the rows that are not settled yet. Times are seconds from the start of the sound.
        """
        paths, steps = self._paths, list(self._steps)
        last = self._frames.settled
        for heard in self._freed(self._frames.pending() if whole else self._frames.pending()[:0]):
            paths, step = paths.step(heard, self._follow)
            steps.append(step)
            last += 1
        begin = last - len(steps)
        spans = _traced(paths.scores, steps)
        to_seconds = HOP / RATE
        edge = -to_seconds / 2
        labels = self.classifier.labels
        intervals = [
            Interval(edge + (begin + start) * to_seconds if begin + start else 0.0,
                     edge + (begin + end) * to_seconds, labels[label])
            for start, end, label in spans
        ]  # fmt: skip
        return Tier("phones", tuple(intervals))


def _traced(scores: Floats, steps: list[_Step]) -> list[tuple[int, int, int]]:
    """First row, row after the last, and label of each phone on the best way through the steps."""
    stage, label = (int(place) for place in np.unravel_index(int(scores.argmax()), scores.shape))
    spans: list[tuple[int, int, int]] = []
    end = row = len(steps)
    while row > 0:
        row -= 1
        source, stayed = steps[row]
        if stage == len(scores) - 1 and stayed[label]:
            continue
        if stage > 0:
            stage -= 1
            continue
        spans.append((row, end, label))
        end, stage, label = row, len(scores) - 1, int(source[label])
    if end > 0:
        spans.append((0, end, label))
    return spans[::-1]
