"""How what is felt changes glances, blinks and the head, over time.

The figures stand in the emotions' tables (``[manner]``), each with its source or as hand-made. Emotions mix by the
weights that the face mixes them by (`weights_of`): what the face shows half, the eyes do half.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.emotions import emotions
from mien.motion.expression.expression import NEUTRAL, weights_of
from mien.text.score import Score

__all__ = ["HEAD_SPEED", "Manner", "steady_head"]

Floats = NDArray[np.float64]
HEAD_SPEED = 45.0
"""Degrees a second that no head of ours exceeds by itself."""
_STEP = 0.05  # seconds between two of the moments at which figures are kept


class Manner:
    """Figures of the emotions' tables over time.

    Parameters
    ----------
    score : Score
        What is felt when.
    seconds : float
        How long a stretch, from 0.

    Examples
    --------
    >>> from mien.text.score import EmotionSpan
    >>> sad = Manner(Score((EmotionSpan("sad", 0.5),)), 2.0)
    >>> sad.at("down", 1.0), Manner(Score(), 2.0).at("down", 1.0)
    (2.25, 0.0)
    """

    def __init__(self, score: Score, seconds: float) -> None:
        self._times = np.arange(0.0, seconds + _STEP, _STEP)
        weights = weights_of(score, self._times)
        names = (NEUTRAL, *(span.name for span in score.emotions))
        usual = _figures(NEUTRAL)
        self._curves = {
            figure: sum((w * _figures(name)[figure] for name, w in zip(names, weights, strict=True)), np.zeros(1))
            for figure in usual
        }
        self.is_usual = all(_figures(name) == usual for name in names)

    def at(self, figure: str, seconds: float) -> float:
        """One figure at a moment."""
        return float(np.interp(seconds, self._times, self._curves[figure]))

    def over(self, figure: str, times: Floats) -> Floats:
        """One figure at several moments, shape (times,)."""
        return np.interp(times, self._times, self._curves[figure])


@cache
def _figures(emotion: str) -> dict[str, float]:
    usual, felt = emotions()[NEUTRAL]["manner"], emotions().get(emotion, {}).get("manner", {})
    return {name: float(value) for name, value in (usual | felt).items()}


def steady_head(angles: Floats, fps: float, most: float = HEAD_SPEED) -> Floats:
    """Yaw, pitch and roll, shape (frames, 3), that never turn faster than ``most`` degrees a second.

    A head that may turn no faster follows the asked one forwards in time, another backwards; their mean neither lags
    nor leads. What is slow enough stays as it is, bit for bit.

    Examples
    --------
    >>> jump = np.array([[0.0, 0, 0], [0, 0, 0], [6, 0, 0], [6, 0, 0]])
    >>> steady_head(jump, fps=10, most=40)[:, 0].tolist()
    [0.0, 1.0, 5.0, 6.0]
    """
    step = most / fps
    if not (np.linalg.norm(np.diff(angles, axis=0), axis=1) > step).any():
        return angles
    return np.asarray((_following(angles, step) + _following(angles[::-1], step)[::-1]) / 2)


def _following(angles: Floats, step: float) -> Floats:
    followed = angles.copy()
    for frame in range(1, len(angles)):
        turn = angles[frame] - followed[frame - 1]
        size = float(np.sqrt(turn @ turn))
        followed[frame] = followed[frame - 1] + turn * (step / size) if size > step else angles[frame]
    return followed
