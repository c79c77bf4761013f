"""`Spoken`: an utterance with its direction in time; what goes from `speak` through `translate` to `perform`."""

from __future__ import annotations

from dataclasses import dataclass

from mien.core.utterance import Utterance
from mien.text.commands import Command
from mien.text.effort_spans import EffortSpan
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan, Score

__all__ = ["Spoken"]


@dataclass(frozen=True)
class Spoken:
    """What is said, and what the face is to do when.

    Attributes
    ----------
    utterance : Utterance
    emotions : tuple of EmotionSpan
    commands : tuple of Command
        High-level commands still to be translated; ``at`` in ms.
    curves : tuple of ParameterCurve
        The low level.
    efforts : tuple of EffortSpan
    """

    utterance: Utterance
    emotions: tuple[EmotionSpan, ...] = ()
    commands: tuple[Command, ...] = ()
    curves: tuple[ParameterCurve, ...] = ()
    efforts: tuple[EffortSpan, ...] = ()

    @property
    def score(self) -> Score:
        """The direction, for a performer."""
        return Score(self.emotions, curves=self.curves, efforts=self.efforts)
