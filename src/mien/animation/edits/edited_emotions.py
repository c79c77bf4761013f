"""Edited intensities laid on a score."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mien.animation.edits.applied import Lost
from mien.animation.edits.edited_places import Gone, Places
from mien.animation.edits.layer import EditLayer, IntensityEdit, Points
from mien.core.errors import Note
from mien.core.utterance import Utterance
from mien.text.intensity import IntensityCurve
from mien.text.key_tangents import tangents_of, through_tangents
from mien.text.score import EmotionSpan, Score

__all__ = ["asked_emotions", "found_points", "with_intensities"]

Found = tuple[float, float, str | None]
Floats = NDArray[np.float64]
_NEUTRAL = "neutral"
_LIKE = {"linear": "linear", "smooth": "spline"}
_PIECES = 12
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
        points = found_points(number, edit.points, places, lost, edit.tangents)
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


def found_points(
    number: int, points: Points, places: Places, lost: list[Lost], tangents: tuple[str | None, ...]
) -> list[Found]:
    """Seconds, values and tangents of an edit's points, in order of time; those that are gone are added to ``lost``."""
    found: list[Found] = []
    gone: list[Lost] = []
    for place, (anchor, value) in enumerate(points):
        try:
            found.append((places.seconds(anchor), value, tangents[place] if tangents else None))
        except Gone as problem:
            gone.append(Lost(number, place, str(problem)))
    if not found:
        gone = [Lost(number, None, gone[0].why)]
    lost += gone
    return sorted(found, key=lambda point: point[0])


def _curve(points: Sequence[Found], edit: IntensityEdit) -> IntensityCurve | float:
    apart: list[Found] = []
    for time, value, tangent in points:
        if apart and time - apart[-1][0] < _NEAREST:
            time = apart.pop()[0]
        apart.append((time, value, tangent))
    if len(apart) == 1:
        return apart[0][1]
    times, values, tangents = zip(*apart, strict=True)
    if edit.tangents:
        return _drawn(np.array(times), np.array(values), tangents_of(tangents, _LIKE[edit.interpolation]))
    return IntensityCurve(times, values, edit.interpolation)


def _drawn(times: Floats, values: Floats, tangents: Sequence[str]) -> IntensityCurve:
    """A curve through points with tangents, as straight lines between many; a step takes a millisecond."""
    moments = np.unique(
        np.concatenate([*(np.linspace(a, b, _PIECES + 1) for a, b in pairwise(times)), times[1:] - _NEAREST])
    )
    moments = moments[np.diff(moments, prepend=-np.inf) > _NEAREST / 2]
    drawn = np.clip(through_tangents(times, values, tangents, moments), 0.0, 1.0)
    return IntensityCurve(tuple(moments.tolist()), tuple(drawn.tolist()), "linear")
