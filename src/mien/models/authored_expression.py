"""The authored expression: one pose per emotion, weighed by an intensity that ramps and drifts.

Authored, not learned (`assets/performance/emotions.toml`); intensity is a continuous curve in [0, 1] (SPEC A13).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien import channels
from mien.errors import unknown_name
from mien.models.drift import smooth_drift
from mien.models.poses import pose_vector, read_table
from mien.script.score import EmotionSpan, Score
from mien.timeline import FrameRate

__all__ = ["AuthoredExpression"]

Floats = NDArray[np.float64]

RAMP = 0.35  # seconds over which an expression comes and goes where a span starts or ends inside the line
DRIFT_TIME = 0.7  # seconds over which the held intensity wanders


class AuthoredExpression:
    """Expression channels from the emotions of a score.

    Examples
    --------
    >>> AuthoredExpression().names
    ('afraid', 'angry', 'contempt', 'disgusted', 'frustrated', 'happy', 'neutral', 'sad', 'surprised')
    """

    def __init__(self, table: str = "emotions.toml") -> None:
        content = read_table(table)
        self._poses = {
            name: pose_vector(entry["pose"], f"{table}, emotion {name}") for name, entry in content["emotion"].items()
        }
        self._wander = {name: float(entry["wander"]) for name, entry in content["emotion"].items()}
        self.sealed_share = np.ones(len(channels.ALL))
        for name, share in content["sealed_share"].items():
            self.sealed_share[channels.ALL.index(name)] = share

    @property
    def names(self) -> tuple[str, ...]:
        """Emotions that can be asked for."""
        return tuple(sorted(self._poses))

    def pose(self, name: str) -> Floats:
        """The full pose of an emotion, shape (channels,), in the order of `mien.channels.ALL`."""
        if name not in self._poses:
            raise unknown_name("emotion", name, self.names)
        return self._poses[name].copy()

    def check(self, score: Score) -> None:
        """Refuse a score that asks for an emotion this performer does not have.

        Raises
        ------
        InputError
            Naming the nearest emotion that exists.
        """
        for span in score.emotions:
            self.pose(span.name)

    def perform(self, score: Score, duration: float, rate: FrameRate, random: np.random.Generator) -> Floats:
        """Expression channels, shape (frames, channels), for every frame that covers ``duration`` seconds."""
        self.check(score)
        times = rate.times(rate.frames_covering(duration))
        values = np.zeros((len(times), len(channels.ALL)))
        for span in score.emotions:
            intensity = span.intensity_at(times) * _ramp(times, span)
            drift = 1 + self._wander[span.name] * smooth_drift(times, DRIFT_TIME, random)
            values += np.clip(intensity * drift, 0.0, 1.0)[:, None] * self._poses[span.name]
        return values


def _ramp(times: Floats, span: EmotionSpan) -> Floats:
    """1 inside the span, 0 outside, half a cosine over `RAMP` at each end that lies inside the line."""
    weight = np.ones(len(times))
    if span.start is not None:
        weight *= _ease((times - span.start) / RAMP + 0.5)
    if span.end is not None:
        weight *= _ease((span.end - times) / RAMP + 0.5)
    return weight


def _ease(passed: Floats) -> Floats:
    return (1 - np.cos(np.pi * np.clip(passed, 0.0, 1.0))) / 2
