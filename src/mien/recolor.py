"""`recolor`: an animation as it would be in another emotion, its words and its edits kept.

What the performer's expression does in the old emotion is taken out, what it does in the new one is put in, so that
edits made since stay. The expressions of a performer without recorded ones are authored, and the result says so. A map
learned from recordings of the same sentences in two emotions is `mien.models.emotion_mapping`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mien import channels
from mien.animation import Animation
from mien.errors import InputError, Note
from mien.models.expression import Expression
from mien.models.performer import Performer
from mien.models.performers import load_performer
from mien.pipeline import perform
from mien.script.score import EmotionSpan
from mien.tracks import ChannelTrack

__all__ = ["recolor"]


def recolor(
    animation: Animation,
    emotion: str | EmotionSpan,
    performer: Performer | str | Path | None = None,
) -> Animation:
    """The same speech in another emotion.

    Parameters
    ----------
    animation : Animation
        As `mien.animate` or `mien.say` made it, edited or not; one made elsewhere counts as neutral if its score is
        empty.
    emotion : str or EmotionSpan
        Takes the place of all emotions of the score; ``"neutral"`` takes them out.
    performer : Performer, str or Path, optional
        Whose expressions; the one that made the animation unless given.

    Returns
    -------
    Animation
        Its markers, which are of the mouth alone, stay as they are.

    Raises
    ------
    InputError
        If the performer cannot be found or does not have the emotion.
    """
    span = EmotionSpan.parse(emotion) if isinstance(emotion, str) else emotion
    actor = _performer(animation, performer)
    score = replace(animation.score, emotions=(span,))
    actor.expression.check(score)
    # A performance made elsewhere may hold emotions that this performer does not have: they cannot be taken out.
    actor.expression.check(animation.score)
    rate, seed = animation.rate, animation.provenance.seed
    before = perform(animation.utterance, animation.score, actor, rate, seed).channels.values
    after = perform(animation.utterance, score, actor, rate, seed)
    count = len(animation.channels)
    if count != len(before):
        raise InputError(f"expected {len(before)} frames over the sound, got {count}: is the animation cut?")
    own = animation.channels.select(channels.ALL).values
    values = own + (after.channels.values - before)
    weights = slice(0, len(channels.WEIGHTS))
    values[:, weights] = np.clip(values[:, weights], 0.0, 1.0)
    edited = int((np.abs(own - before) > 1e-6).any(axis=1).sum())
    told = f"{edited} of {count} frames had been edited: the edits are kept on top" if edited else ""
    notes = [n for n in (*animation.notes, *after.notes) if n not in after.utterance.notes]
    return replace(
        animation,
        channels=ChannelTrack(channels.ALL, values, rate),
        score=score,
        provenance=after.provenance,
        notes=(*dict.fromkeys(notes), *_authored(actor, span), *([Note("note", told)] if told else [])),
    )


def _authored(actor: Performer, span: EmotionSpan) -> tuple[Note, ...]:
    if not isinstance(actor.expression, Expression) or span.name not in actor.expression.authored:
        return ()
    return (Note("note", f"the expression {span.name!r} is authored, not learned from recordings"),)


def _performer(animation: Animation, performer: Performer | str | Path | None) -> Performer:
    if isinstance(performer, Performer):
        return performer
    asked = performer if performer is not None else animation.provenance.performer
    try:
        return load_performer(asked)
    except InputError as problem:
        if performer is not None:
            raise
        raise InputError(
            f"the animation was made by the performer {asked!r}, which is not at hand: name one with --performer"
        ) from problem
