"""`perform`: a performer plays what was spoken and translated."""

from __future__ import annotations

from mien.animation.animation import Animation
from mien.animation.edits.layer import EMPTY, EditLayer
from mien.core.timeline import FrameRate
from mien.motion.performer import Performer
from mien.pipeline.edited_performance import perform_edited
from mien.pipeline.spoken import Spoken
from mien.pipeline.translate import translate
from mien.text.score import Score

__all__ = ["directed", "perform_spoken"]


def perform_spoken(
    spoken: Spoken,
    performer: Performer,
    rate: FrameRate,
    seed: int = 0,
    score: Score | None = None,
    edits: EditLayer = EMPTY,
) -> Animation:
    """Perform, as `mien.pipeline.perform.perform` does.

    Parameters
    ----------
    spoken : Spoken
        Commands that are left in it are translated by the shipped library.
    performer, rate, seed
        As for `mien.pipeline.perform.perform`.
    score : Score, optional
        Direction for the whole besides: its emotions come before those of the script.
    edits : EditLayer
        Laid on the performance (`mien.pipeline.edited_performance.perform_edited`).
    """
    spoken, asked = directed(spoken, score)
    return perform_edited(spoken.utterance, asked, performer, rate, seed, edits)


def directed(spoken: Spoken, score: Score | None) -> tuple[Spoken, Score]:
    """What was spoken with all commands translated, and all that is asked of its performance."""
    if spoken.commands:
        spoken = translate(spoken)
    asked = spoken.score
    if score is not None:
        asked = Score(score.emotions + asked.emotions, score.curves + asked.curves, score.efforts + asked.efforts)
    return spoken, asked
