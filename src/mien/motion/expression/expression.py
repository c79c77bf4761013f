"""`Expression`: what the emotions of a score ask of the face, sampled from expressive motion.

Each emotion of the score is a stretch of new motion from an `ExpressionSpace`, weighed by its intensity over time
(Deng et al. 2006). Emotions that overlap share the face: where their intensities add up to more than one, each gets
its part. What is left below one is neutral: a face at rest is not a still face.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.errors import Note, unknown_name
from mien.core.timeline import FrameRate
from mien.motion.expression.expression_space import ExpressionSpace
from mien.motion.expression.line import Line
from mien.text.score import EmotionSpan, Score

__all__ = ["NEUTRAL", "Expression", "weights_of"]

_BLOCK = 4096  # frames

Floats = NDArray[np.float64]
NEUTRAL = "neutral"
UNKNOWN_SPEECH = 0.5
"""Share of what an emotion adds to a speaking mouth where it is not known whether anything is said."""


class Expression:
    """Expression channels from the emotions of a score.

    Parameters
    ----------
    names : sequence of str
        Emotions that can be asked for.
    space_of : callable
        The space in which an emotion has its curves; its carried columns are `mien.core.channels.ALL`. Called when the
        emotion is performed.
    sealed_share : ndarray, shape (channels,)
        Share of each channel that remains while the lips must be shut.
    hand-made : collection of str
        Emotions whose motion is hand-made rather than recorded; asking for one leaves a note on a recorded performer.
    efforts : mapping of str to float, optional
        How hard the words are articulated at full intensity, for emotions where that is not 1 (docs/effort.md).
    spoken : mapping of str to ndarray, shape (channels,), optional
        What an emotion adds to the mouth while it speaks; recorded motion holds that already.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        space_of: Callable[[str], ExpressionSpace],
        sealed_share: Floats,
        hand_made: frozenset[str] = frozenset(),
        efforts: Mapping[str, float] | None = None,
        spoken: Mapping[str, Floats] | None = None,
    ) -> None:
        self.names, self.sealed_share, self.hand_made = tuple(sorted(names)), sealed_share, hand_made
        self.space_of, self.efforts, self.spoken = space_of, dict(efforts or {}), dict(spoken or {})

    def check(self, score: Score) -> None:
        """Refuse a score that asks for an emotion this performer does not have.

        Raises
        ------
        InputError
            Naming the nearest emotion that exists.
        """
        for span in score.emotions:
            if span.name not in self.names:
                raise unknown_name("emotion", span.name, self.names)

    def notes(self, score: Score) -> tuple[Note, ...]:
        """What should be known about the emotions asked for: which were not recorded, if others were."""
        if self.hand_made.issuperset(set(self.names) - {NEUTRAL}):
            return ()
        made = sorted({span.name for span in score.emotions} & self.hand_made - {NEUTRAL})
        return tuple(
            Note("note", f"{name} was not recorded for this performer: its motion is hand-made") for name in made
        )

    def effort(self, score: Score, times: Floats) -> Floats:
        """How hard the emotions of a score let the words be articulated, shape (times,); 1 as recorded."""
        asked = np.array([self.efforts.get(span.name, 1.0) - 1 for span in score.emotions])
        return np.asarray(1 + asked @ weights_of(score, times)[1:])

    def perform(
        self,
        score: Score,
        duration: float,
        rate: FrameRate,
        random: np.random.Generator,
        *,
        neutral: bool = True,
        line: Line | None = None,
    ) -> Floats:
        """Expression channels, shape (frames, channels), for every frame that covers ``duration`` seconds.

        ``neutral`` False leaves out the neutral face's own small motion, for motion that is alive already. Without a
        ``line`` the strength stands still, and half of what the emotion adds to a speaking mouth is there.
        """
        self.check(score)
        times = rate.times(rate.frames_covering(duration))
        spans = (EmotionSpan(NEUTRAL), *score.emotions)
        values = np.zeros((len(times), len(channels.ALL)))
        # One generator for each emotion: what one draws leaves the others as they are.
        strength, speaking = (line.strength, line.speaking) if line else (1.0, np.full(len(times), UNKNOWN_SPEECH))
        for span, weight, draws in zip(spans, weights_of(score, times), random.spawn(len(spans)), strict=True):
            if weight.any() and (neutral or span.name != NEUTRAL):
                shown = weight if span.name == NEUTRAL else weight * strength
                # Whole seconds, so that the draws do not depend on the frame rate.
                sampled = self.space_of(span.name).sample(span.name, float(np.floor(times[-1]) + 1), draws)
                for here in map(slice, range(0, len(times), _BLOCK), range(_BLOCK, len(times) + _BLOCK, _BLOCK)):
                    values[here] += shown[here, None] * sampled.carried_at(times[here])
                    if span.name in self.spoken:
                        values[here] += (shown * speaking)[here, None] * self.spoken[span.name]
        return values


def weights_of(score: Score, times: Floats) -> Floats:
    """Weights of neutral and of each emotion of a score, shape (1 + emotions, times); at each instant they sum to one.

    Examples
    --------
    >>> score = Score((EmotionSpan("sad", 0.8), EmotionSpan("angry", 0.8)))
    >>> weights_of(score, np.array([1.0])).round(2).ravel().tolist()
    [0.0, 0.5, 0.5]
    """
    asked = np.array([span.asked_at(times) for span in score.emotions]).reshape(-1, len(times))
    asked /= np.maximum(asked.sum(axis=0), 1.0)
    return np.concatenate([1 - asked.sum(axis=0, keepdims=True), asked])
