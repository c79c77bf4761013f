"""Edited intensities laid on a score."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from mien.animation.edits.applied import Lost
from mien.animation.edits.edited_places import Gone, Places
from mien.animation.edits.layer import EditLayer, IntensityEdit, Points
from mien.core.errors import Note
from mien.core.utterance import Utterance
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan, Score

__all__ = ["asked_emotions", "found_points", "with_intensities"]

_NEUTRAL = "neutral"
_NEAREST = 1e-3
"""Seconds between two points of a curve; of nearer ones the later in the layer holds."""


def asked_emotions(score: Score) -> tuple[str, ...]:
    """The emotions of a score, each once.

    Examples
    --------
    >>> asked_emotions(Score((EmotionSpan("sad"), EmotionSpan("happy"), EmotionSpan("sad"))))
    ('sad', 'happy')
    """
    return tuple(dict.fromkeys(span.name for span in score.emotions))


def with_intensities(
    layer: EditLayer, utterance: Utterance, score: Score, known: Collection[str] | None = None
) -> tuple[Score, tuple[Lost, ...], tuple[Note, ...]]:
    """Lay the edited intensities of a layer on a score.

    An emotion that was asked for when the edit was made, and is not now, is lost; but where one emotion took the place
    of one other, its intensity is what was drawn for that.

    Parameters
    ----------
    layer : EditLayer
    utterance : Utterance
        With its borders moved.
    score : Score
    known : collection of str, optional
        Emotions that the performer has; others are lost.
    """
    if not layer.intensities:
        return score, (), ()
    places, lost, notes = Places(layer, utterance), list[Lost](), list[Note]()
    drawn: dict[str, IntensityCurve | float] = {}
    asked = asked_emotions(score)
    for number, edit in layer.intensities:
        emotion = _now(edit, layer, asked)
        if emotion is None or (known is not None and emotion not in known):
            why = "is not asked for any more" if emotion is None else "is not among the emotions that can be shown here"
            lost.append(Lost(number, None, f"{emotion or edit.emotion!r} {why}"))
            continue
        points = found_points(number, edit.points, places, lost)
        if points:
            drawn[emotion] = _curve(points, edit)
            if emotion != edit.emotion:
                told = f"the intensity that was drawn for {edit.emotion!r} is that of {emotion!r} now"
                notes.append(Note("note", told))
    kept = [span for span in score.emotions if span.name not in drawn]
    spans = [EmotionSpan(name, intensity) for name, intensity in drawn.items()]
    order = {name: place for place, name in enumerate(asked)}
    emotions = sorted(kept + spans, key=lambda span: order.get(span.name, len(order)))
    return replace(score, emotions=tuple(emotions)), tuple(lost), tuple(notes)


def _now(edit: IntensityEdit, layer: EditLayer, asked: tuple[str, ...]) -> str | None:
    """The emotion whose intensity an edit is now; None if it was asked for then and is not now."""
    then = asked if layer.emotions is None else layer.emotions
    if edit.emotion in asked or edit.emotion not in then:
        return edit.emotion
    return asked[0] if len(then) == len(asked) == 1 and asked[0] != _NEUTRAL else None


def found_points(number: int, points: Points, places: Places, lost: list[Lost]) -> list[tuple[float, float]]:
    """Seconds and values of the points of an edit, in order of time; those that are gone are added to ``lost``."""
    found: list[tuple[float, float]] = []
    gone: list[Lost] = []
    for place, (anchor, value) in enumerate(points):
        try:
            found.append((places.seconds(anchor), value))
        except Gone as problem:
            gone.append(Lost(number, place, str(problem)))
    if not found:
        gone = [Lost(number, None, gone[0].why)]
    lost += gone
    return sorted(found, key=lambda point: point[0])


def _curve(points: Sequence[tuple[float, float]], edit: IntensityEdit) -> IntensityCurve | float:
    apart: list[tuple[float, float]] = []
    for time, value in points:
        if apart and time - apart[-1][0] < _NEAREST:
            apart[-1] = (apart[-1][0], value)
        else:
            apart.append((time, value))
    if len(apart) == 1:
        return apart[0][1]
    return IntensityCurve(tuple(time for time, _ in apart), tuple(value for _, value in apart), edit.interpolation)
