"""The emotion of a voice while it speaks, read every half second against what was calm so far, and shown softly."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.emotion.emotion_classifier import (
    LEAST_SPEECH,
    NEUTRAL,
    WINDOW,
    WINDOW_STEP,
    EmotionClassifier,
    default_classifier,
)
from mien.emotion.emotion_over_time import RunningBaseline
from mien.emotion.emotion_samples import VOICE, features_of
from mien.motion.expression.endless_motion import EndlessMotion, endless_expression
from mien.motion.performer import ExpressionModel
from mien.speech.streaming_features import RATE
from mien.speech.voice_features import analyse
from mien.text.score import EmotionSpan, Score

__all__ = ["HeardEmotion", "HeardExpression"]

Floats = NDArray[np.float64]
TOGETHER = 3
"""Windows that are judged as one: 3.5 s of sound."""
EASE = 0.35
"""Seconds in which two thirds of the way to another emotion are gone."""


class HeardEmotion:
    """Which emotion a voice has had, as it is heard.

    A window of 2.5 s is read every half second, beside the sound: what it says counts from the next half second on, so
    that the same sound gives the same readings on any machine. What was calm so far is the measure of the rest.

    Parameters
    ----------
    classifier : EmotionClassifier, optional
        One of `VOICE` features; the default one if none is given.

    Attributes
    ----------
    asked : tuple of (str, float)
        The emotion that a face acts on, and its intensity; neutral where that is not sure.
    """

    def __init__(self, classifier: EmotionClassifier | None = None) -> None:
        self._classifier = classifier or default_classifier()
        self._baseline = RunningBaseline(self._classifier, self._classifier.usual_)
        self._sound, self._heard, self._due = np.zeros(0, np.float32), 0, round(WINDOW_STEP * RATE)
        self._rows: deque[tuple[Floats, Floats, float]] = deque(maxlen=TOGETHER)
        self._worker = ThreadPoolExecutor(1, "emotion")
        self._running: Future[tuple[str, float]] | None = None
        self.asked = (NEUTRAL, 0.0)

    def hear(self, samples: NDArray[np.floating]) -> None:
        """Take sound, 16 kHz, -1..1."""
        for part in np.split(samples, range(self._due - self._heard, len(samples), round(WINDOW_STEP * RATE))):
            self._sound = np.concatenate([self._sound, part.astype(np.float32)])[-round(WINDOW * RATE) :]
            self._heard += len(part)
            if self._heard >= self._due:
                self._due += round(WINDOW_STEP * RATE)
                if self._running is not None:
                    self.asked = self._running.result()
                self._running = self._worker.submit(self._read, Audio(self._sound.astype(np.float64), RATE))

    def _read(self, audio: Audio) -> tuple[str, float]:
        frames = analyse(audio)
        spoken = frames.seconds_of_speech
        if spoken < LEAST_SPEECH:
            self._rows.clear()
            return NEUTRAL, 0.0
        features = features_of(frames, VOICE)[None]
        self._baseline.add(features)
        usual = self._baseline.value
        found = self._classifier.probabilities(features, usual), self._classifier.activations(features, usual)
        self._rows.append((*found, spoken))
        probabilities, activations, seconds = zip(*self._rows, strict=True)
        reading = self._classifier.reading(np.concatenate(probabilities), np.concatenate(activations), max(seconds))
        return reading.emotion, reading.intensity


class HeardExpression:
    """The expression of a stream, in the emotion that is heard; one frame after another.

    Parameters
    ----------
    expression : ExpressionModel
    rate : FrameRate
    random : numpy.random.Generator
    heard : HeardEmotion
    """

    def __init__(
        self, expression: ExpressionModel, rate: FrameRate, random: np.random.Generator, heard: HeardEmotion
    ) -> None:
        self.heard, self._expression, self._rate = heard, expression, rate
        self._pull = 1 - float(np.exp(-rate.time_of(1) / EASE))
        self._draws = dict(zip(expression.names, random.spawn(len(expression.names)), strict=True))
        self._moving: dict[str, EndlessMotion] = {}
        self._shares: dict[str, float] = {}

    def next(self) -> Floats:
        """The next frame, shape (channels,)."""
        emotion, intensity = self.heard.asked
        self._shares.setdefault(emotion, 0.0)
        for name, share in self._shares.items():
            goal = intensity if name == emotion else 0.0
            self._shares[name] = share + self._pull * (goal - share)
        felt = {name: share for name, share in self._shares.items() if name != NEUTRAL and share > 1e-3}
        values = (1 - min(sum(felt.values()), 1.0)) * self._motion(NEUTRAL)
        for name, share in felt.items():
            values = values + share / max(sum(felt.values()), 1.0) * self._motion(name)
        return np.asarray(values)

    def _motion(self, name: str) -> Floats:
        if name not in self._expression.names:
            return np.zeros(len(channels.ALL))
        if name not in self._moving:
            score = Score(() if name == NEUTRAL else (EmotionSpan(name),))
            self._moving[name] = endless_expression(self._expression, score, self._rate, self._draws[name])
        return self._moving[name].next()
