"""Expressive takes in the Anime Graph, and which emotion is asked of it.

Nodes come from all takes with their emotions (Cao et al. 2005, section 4.1: a node is ``<P, C, M, E>``). What an
emotion does to the face all the time, a smile say, is the expression's (`mien.motion.expression`); what it does to the
way of speaking is the node's. So the motion of expressive takes is moved as a whole by the difference of the mean
mouths in speech, emotion by emotion, and nothing is shown twice.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.take import Take
from mien.motion.mouth.mouth_space import MouthSpace
from mien.motion.mouth.recorded_mouths import recorded_mouths
from mien.text.score import Score

__all__ = ["NEUTRAL", "emotion_of", "felt_over", "labels_of", "levelled"]

NEUTRAL = "neutral"
STRONG = 0.5
"""Intensity from which speech is taken from recordings of the emotion."""
_RATE = 50.0  # instants per second at which intensities are looked at
_MARGIN = 0.0

Floats = NDArray[np.float64]


def emotion_of(take: Take) -> str:
    """Label of a take; takes without one are neutral."""
    return take.emotion or NEUTRAL


def levelled(felt: Sequence[Take], neutral: Sequence[Take], space: MouthSpace) -> list[Take]:
    """Expressive takes whose mean mouth in speech is that of the neutral ones, emotion by emotion.

    Parameters
    ----------
    felt, neutral : sequence of Take
    space : MouthSpace
        In which the mouth is learned.
    """
    if not felt:
        return []
    aim = _mean(neutral, space)
    means = {name: _mean([t for t in felt if emotion_of(t) == name], space) for name in sorted(map(emotion_of, felt))}
    return [_moved(take, space, aim - means[emotion_of(take)]) for take in felt]


def _mean(takes: Sequence[Take], space: MouthSpace) -> Floats:
    rows = np.concatenate([mouth.rows for mouth in recorded_mouths(takes, _MARGIN, space)])
    return np.asarray(rows.mean(axis=0))


def _moved(take: Take, space: MouthSpace, shift: Floats) -> Take:
    if space.kind == "channels" and take.channels is not None:
        track = take.channels
        # weights as differences: a shift may leave 0..1, which motion never does once it is performed
        change = space.differences_of(shift[None])[0]
        values = track.values.copy()
        for name, by in zip(space.names, change, strict=True):
            if name in track.names:
                values[:, track.names.index(name)] += by
        return replace(take, channels=ChannelTrack(track.names, values, track.rate))
    places = [take.markers.names.index(name) for name in space.names]
    positions = take.markers.positions.copy()
    positions[:, places] += space.differences_of(shift[None])[0]
    return replace(take, markers=MarkerTrack(take.markers.names, positions, take.markers.rate))


def labels_of(phones: Tier, felt: Tier | None, known: Collection[str]) -> tuple[str, ...] | None:
    """Emotion of each phone, that of its middle; None where the graph knows one emotion only.

    Examples
    --------
    >>> said = Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.2, 0.4, "M")))
    >>> labels_of(said, Tier("felt", (Interval(0.3, 0.9, "angry"),)), ("angry", "neutral"))
    ('neutral', 'angry')
    """
    if len(known) < 2:
        return None
    found = []
    for phone in phones:
        spans = [span.label for span in felt or () if span.start <= phone.middle < span.end]
        found.append(spans[-1] if spans and spans[-1] in known else NEUTRAL)
    base = next(iter(sorted(known)))
    return tuple(label if label in known else base for label in found)


def felt_over(score: Score, duration: float, known: Collection[str]) -> Tier:
    """Where a score asks for a recorded emotion at `STRONG` or more; of several, the strongest."""
    times = np.arange(0.0, max(duration, 1 / _RATE), 1 / _RATE)
    spans = [span for span in score.emotions if span.name in known]
    if not spans:
        return Tier("felt", ())
    strengths = np.array(
        [
            np.where(
                (times >= (span.start or 0.0)) & (times < (duration if span.end is None else span.end) + 1e-9),
                span.intensity_at(times),
                0.0,
            )
            for span in spans
        ]
    )
    strongest = np.where(strengths.max(axis=0) >= STRONG, strengths.argmax(axis=0), -1)
    borders = [0, *(np.flatnonzero(np.diff(strongest)) + 1), len(times)]
    return Tier(
        "felt",
        tuple(
            Interval(first / _RATE, after / _RATE, spans[strongest[first]].name)
            for first, after in pairwise(borders)
            if strongest[first] >= 0
        ),
    )
