"""`perform_spoken`: what was spoken is performed, with a layer of edits; in the order in which one rests on the other.

borders      moved before anybody performs: the mouth follows the phones
intensities  laid on the score, at anchors in the moved phones
curves       laid on the finished channels; no model is asked, so they are quick to change
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mien.animation.animation import Animation
from mien.animation.edits.applied import AppliedEdits, Before, lost_notes
from mien.animation.edits.borders import with_borders
from mien.animation.edits.edited_curves import with_curves
from mien.animation.edits.edited_emotions import asked_emotions, with_intensities
from mien.animation.edits.edited_line import line_of
from mien.animation.edits.layer import EMPTY, BorderEdit, EditLayer
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.core.utterance import Utterance
from mien.motion.performer import Performer
from mien.pipeline.perform import perform
from mien.pipeline.spoken import Spoken, translate
from mien.text.score import EmotionSpan, Score

__all__ = [
    "directed",
    "perform_edited",
    "perform_spoken",
    "perform_under",
    "recoloured_under_edits",
    "unedited",
    "with_edited_channels",
    "without_edited_channels",
]


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
        Laid on the performance (`perform_edited`).
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


def perform_edited(
    utterance: Utterance, score: Score, performer: Performer, rate: FrameRate, seed: int, layer: EditLayer
) -> Animation:
    """Perform, as `mien.pipeline.perform.perform` does, with a layer of edits.

    An empty layer changes nothing. What cannot be laid on is listed in ``edits.lost`` of the result, and in its notes.
    """
    if not layer.edits:
        return perform(utterance, score, performer, rate, seed)
    return with_edited_channels(perform_under(utterance, score, performer, rate, seed, layer))


def perform_under(
    utterance: Utterance, score: Score, performer: Performer, rate: FrameRate, seed: int, layer: EditLayer
) -> Animation:
    """Perform with a layer's borders and intensities, but without its curves (`with_edited_channels` lays those on)."""
    layer = layer.made_on(line_of(utterance).line, asked_emotions(score))
    speech, lost, notes = with_borders(layer, utterance)
    asked, also_lost, also_noted = with_intensities(layer, speech, score, performer.expression.names)
    before = Before(utterance.words, utterance.phones, utterance.native, score.emotions)
    animation = perform(speech, asked, performer, rate, seed)
    edits = AppliedEdits(layer, (*lost, *also_lost), before)
    return replace(animation, edits=edits, notes=(*animation.notes, *notes, *also_noted))


def with_edited_channels(animation: Animation) -> Animation:
    """Lay the curves of an animation's layer on it, and tell in the notes what of the layer is lost.

    Parameters
    ----------
    animation : Animation
        As `perform_under` made it.
    """
    if animation.edits is None:
        return animation
    layer, before = animation.edits.layer, animation.edits.before
    track, lost, channels = with_curves(layer, animation.utterance, animation.channels)
    lost = tuple(sorted((*animation.edits.lost, *lost), key=lambda loss: (loss.edit, loss.point or 0)))
    edits = AppliedEdits(layer, lost, replace(before, channels=channels))
    return replace(animation, channels=track, edits=edits, notes=(*animation.notes, *lost_notes(layer, lost)))


def without_edited_channels(animation: Animation) -> Animation:
    """The animation with its edited channels as they were under the curves, and no layer on it; borders stay moved."""
    if animation.edits is None:
        return animation
    track, values = animation.channels, animation.channels.values.copy()
    for name, before in animation.edits.before.channels.items():
        values[:, track.names.index(name)] = before
    told = lost_notes(animation.edits.layer, animation.edits.lost)
    notes = tuple(note for note in animation.notes if note not in told)
    return replace(animation, channels=ChannelTrack(track.names, values, track.rate), edits=None, notes=notes)


def recoloured_under_edits(
    animation: Animation, emotion: EmotionSpan, recolour: Callable[[Animation, EmotionSpan], Animation]
) -> Animation:
    """An edited animation in another emotion, its layer laid on again.

    Parameters
    ----------
    animation : Animation
        With edits.
    emotion : EmotionSpan
        Takes the place of all others.
    recolour : callable
        Given an animation without edits and the emotion as it was drawn, gives it in that emotion.
    """
    if animation.edits is None:
        return recolour(animation, emotion)
    layer, before = animation.edits.layer, animation.edits.before
    score, lost, notes = with_intensities(layer, animation.utterance, Score((emotion,)), (emotion.name,))
    changed = recolour(without_edited_channels(animation), score.emotions[0])
    borders = tuple(loss for loss in animation.edits.lost if isinstance(layer.edits[loss.edit], BorderEdit))
    edits = AppliedEdits(layer, (*borders, *lost), replace(before, emotions=(emotion,), channels={}))
    return with_edited_channels(replace(changed, edits=edits, notes=(*changed.notes, *notes)))


def unedited(animation: Animation) -> tuple[Utterance, Score]:
    """What an animation was performed from before its edits: perform it again to have them off."""
    if animation.edits is None:
        return animation.utterance, animation.score
    before = animation.edits.before
    speech = replace(animation.utterance, words=before.words, phones=before.phones, native=before.native)
    return speech, replace(animation.score, emotions=before.emotions)
