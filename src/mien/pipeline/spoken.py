"""`Spoken`: an utterance with its direction in time, from `speak` to `perform`; `translate` makes commands curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mien.core.errors import Note
from mien.core.utterance import Utterance
from mien.text.commands import Command, CommandLibrary, shipped_library
from mien.text.effort_spans import EffortSpan
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan, Score

__all__ = ["Spoken", "translate"]


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


def translate(spoken: Spoken, library: CommandLibrary | None = None) -> Spoken:
    """Every high-level command becomes curves of face parameters; the result has none left.

    Raises
    ------
    InputError
        If a command is not known or its parameters do not fit.
    """
    library = library or shipped_library()
    curves, notes = list(spoken.curves), list[Note]()
    for command in spoken.commands:
        translation = library.translate(command)
        curves += translation.curves
        notes += translation.notes
    return replace(spoken, utterance=spoken.utterance.with_notes(*notes), commands=(), curves=tuple(curves))
