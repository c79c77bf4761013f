"""`perform`: a performer plays what was spoken and translated."""

from __future__ import annotations

from dataclasses import replace

from mien.animation import Animation
from mien.edits.layer import EMPTY, EditLayer
from mien.models.performer import Performer
from mien.modules.edit import perform_edited
from mien.modules.spoken import Spoken
from mien.modules.translate import translate
from mien.script.score import Score
from mien.timeline import FrameRate

__all__ = ["directed", "perform_spoken"]


def perform_spoken(
    spoken: Spoken,
    performer: Performer,
    rate: FrameRate,
    seed: int = 0,
    score: Score | None = None,
    edits: EditLayer = EMPTY,
) -> Animation:
    """Perform, as `mien.pipeline.perform` does.

    Parameters
    ----------
    spoken : Spoken
        Commands that are left in it are translated by the shipped library.
    performer, rate, seed
        As for `mien.pipeline.perform`.
    score : Score, optional
        Direction for the whole besides: its emotions come before those of the script.
    edits : EditLayer
        Laid on the performance (`mien.modules.edit.perform_edited`).
    """
    spoken, asked = directed(spoken, score)
    return perform_edited(spoken.utterance, asked, performer, rate, seed, edits)


def directed(spoken: Spoken, score: Score | None) -> tuple[Spoken, Score]:
    """What was spoken with all commands translated, and all that is asked of its performance."""
    if spoken.commands:
        spoken = translate(spoken)
    asked = spoken.score
    if score is not None:
        asked = replace(asked, emotions=score.emotions + asked.emotions, curves=score.curves + asked.curves)
    return spoken, asked
