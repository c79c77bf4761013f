"""Emotions of a longer recording, stretch by stretch, as spans of a score (Cao et al. 2005: read from the voice).

Windows of 2.5 s, half a second apart, are judged by an `EmotionClassifier`. The likeliest course of emotions, in which
a change has a price (Viterbi 1967), is cut into stretches; a boundary moves to the quietest place nearby. A stretch
whose mean probability stays under the classifier's threshold is neutral. Inside a stretch the intensity follows level
and pitch relative to the whole recording: a rule, not learned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.emotion.emotion_classifier import (
    FEW_TOGETHER,
    FROM_NEUTRAL,
    LEAST_SPEECH,
    LONGEST_WHOLE,
    NEUTRAL,
    WINDOW,
    WINDOW_STEP,
    EmotionClassifier,
    EmotionReading,
    default_classifier,
    windows,
)
from mien.emotion.emotion_samples import VOICE, features_of
from mien.speech.voice_features import STEP, SpeechFrames, analyse
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan

__all__ = ["EmotionStretch", "RunningBaseline", "emotion_spans", "read_over_time"]

CHANGE_PRICE = 3.0
"""Of one change of emotion, in units of log probability of one window."""
_SNAP = 0.6
_POINTS = 0.25
_SMOOTH = 0.3
_LEVEL_UNIT, _PITCH_UNIT = 6.0, 3.0
_SWING = 0.25
_Array = NDArray[np.float64]


@dataclass(frozen=True)
class EmotionStretch:
    """One emotion of a recording.

    Attributes
    ----------
    start, end : float
        Seconds from the start of the sound.
    reading : EmotionReading
    """

    start: float
    end: float
    reading: EmotionReading


def read_over_time(
    audio: Audio, classifier: EmotionClassifier | None = None, baseline: Sequence[Audio] = ()
) -> tuple[EmotionStretch, ...]:
    """The emotions of a recording, one after another, without gaps from its start to its end.

    Parameters
    ----------
    audio : Audio
        A recording with little speech is one stretch.
    classifier : EmotionClassifier, optional
        The default one if none is given.
    baseline : sequence of Audio
        Recordings of the same speaker without emotion; what is calm in this one counts besides.
    """
    classifier = classifier or default_classifier()
    frames = analyse(audio)
    if classifier.features != VOICE or frames.seconds_of_speech <= LONGEST_WHOLE:
        return (EmotionStretch(0.0, audio.duration, classifier.read(audio, baseline)),)
    start = classifier.neutral_baseline(baseline)
    placed = windows(frames)
    features = np.array([features_of(piece, VOICE) for _, piece in placed])
    running = RunningBaseline(classifier, start)
    running.add(features)
    usual = running.value
    probabilities = classifier.probabilities(features, usual)
    activation = classifier.activations(features, usual)
    course = likeliest_course(probabilities)
    edges = [0, *(np.flatnonzero(np.diff(course)) + 1), len(course)]
    bounds = [0.0, *(_quietest(frames, (placed[e - 1][0] + placed[e][0]) / 2) for e in edges[1:-1]), audio.duration]
    stretches = []
    for number, (first, after) in enumerate(pairwise(edges)):
        begin, end = bounds[number], bounds[number + 1]
        spoken = frames.between(begin, end).seconds_of_speech
        reading = classifier.reading(probabilities[first:after], activation[first:after], spoken)
        stretches.append(EmotionStretch(begin, end, reading))
    return tuple(stretches)


def emotion_spans(audio: Audio, classifier: EmotionClassifier | None = None) -> tuple[EmotionSpan, ...]:
    """The emotions of a recording as spans of a score, each with its intensity over time; none where it is neutral.

    Examples
    --------
    >>> emotion_spans(Audio.silence(1.0, 16_000))
    ()
    """
    stretches = read_over_time(audio, classifier)
    frames = analyse(audio)
    spans: list[EmotionSpan] = []
    for stretch in stretches:
        if stretch.reading.emotion == NEUTRAL:
            continue
        start = stretch.start if stretch.start > 0 else None
        end = stretch.end if stretch.end < audio.duration else None
        spans.append(EmotionSpan(stretch.reading.emotion, _intensity(frames, stretch), start, end))
    return tuple(spans)


class RunningBaseline:
    """What is usual for a speaker, from the calm parts of what was heard so far: windows count as they are neutral.

    An angry speech has no calm parts and does not become its own measure.

    Parameters
    ----------
    classifier : EmotionClassifier
    start : ndarray, shape (features,)
        The baseline before anything was heard.
    """

    def __init__(self, classifier: EmotionClassifier, start: _Array) -> None:
        self._classifier, self._start = classifier, start
        self._calm, self._sum = 0.0, np.zeros(len(start))

    def add(self, features: _Array) -> None:
        """Hear windows, shape (windows, features), that lie `WINDOW_STEP` apart."""
        if NEUTRAL not in self._classifier.emotions:
            return
        neutral = self._classifier.probabilities(features, self._start)[:, self._classifier.emotions.index(NEUTRAL)]
        calm = np.maximum(2 * neutral - 1, 0.0)  # only windows that are more neutral than not
        self._calm, self._sum = self._calm + float(calm.sum()), self._sum + calm @ features

    @property
    def value(self) -> _Array:
        """The baseline now, shape (features,)."""
        if self._calm == 0:
            return self._start
        weight = self._calm * WINDOW_STEP / WINDOW  # windows overlap
        middle = self._sum / self._calm + FROM_NEUTRAL * self._classifier.from_neutral_
        return np.asarray((weight * middle + FEW_TOGETHER * self._start) / (weight + FEW_TOGETHER))


def likeliest_course(probabilities: _Array) -> NDArray[np.intp]:
    """The course of classes with the highest sum of log probabilities less `CHANGE_PRICE` per change; shape (windows,).

    Examples
    --------
    >>> likeliest_course(np.array([[0.9, 0.1], [0.4, 0.6], [0.9, 0.1]])).tolist()
    [0, 0, 0]
    """
    logs = np.log(np.maximum(probabilities, 1e-4))
    best, came = logs[0], []
    for row in logs[1:]:
        change = best.max() - CHANGE_PRICE > best
        came.append(np.where(change, best.argmax(), np.arange(len(best))))
        best = np.where(change, best.max() - CHANGE_PRICE, best) + row
    course = [int(best.argmax())]
    for before in reversed(came):
        course.append(int(before[course[-1]]))
    return np.array(course[::-1])


def _quietest(frames: SpeechFrames, when: float) -> float:
    times = frames.start + STEP * np.arange(len(frames))
    near = np.flatnonzero(np.abs(times - when) <= _SNAP)
    smooth = np.convolve(frames.level, np.ones(5) / 5, "same")
    return float(times[near[smooth[near].argmin()]]) if len(near) else when


def _intensity(frames: SpeechFrames, stretch: EmotionStretch) -> float | IntensityCurve:
    """The reading's intensity, up to a quarter more or less where the voice is louder and higher than on the whole."""
    base = stretch.reading.intensity
    times = np.arange(stretch.start, stretch.end, _POINTS)
    if len(times) < 3 or frames.seconds_of_speech < LEAST_SPEECH:
        return base
    middles = frames.start + STEP * np.arange(len(frames))
    height = frames.semitones - np.nanmedian(frames.semitones) if np.isfinite(frames.semitones).any() else frames.level
    stir = np.nan_to_num(frames.level / _LEVEL_UNIT + np.nan_to_num(height) / _PITCH_UNIT)
    weight = frames.active * np.exp(-0.5 * ((middles - times[:, None]) / _SMOOTH) ** 2)
    total = weight.sum(axis=1)
    curve = np.where(total > 1e-3, (weight @ stir) / np.maximum(total, 1e-3), 0.0)
    values = np.clip(base * (1 + _SWING * np.tanh(curve)), 0.0, 1.0)
    return IntensityCurve(tuple(times.round(3).tolist()), tuple(values.round(4).tolist()))
