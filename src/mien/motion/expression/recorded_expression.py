"""Expressions of a recorded person: an expression space from their own expressive takes (Deng et al. 2006)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ALL
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take
from mien.face.model import Face
from mien.motion.expression.expression import Expression
from mien.motion.expression.expression_file import RecordedExpressions, rounded
from mien.motion.expression.expression_motion import Twins, expressive_displacement, find_twins
from mien.motion.expression.expression_space import RATE, ExpressionSpace, ExpressiveMotion
from mien.motion.expression.hand_made_performance import hand_made_expression, without_eyelids

__all__ = ["expression_of", "learn_expressions"]

Floats = NDArray[np.float64]
LEAST_SECONDS = 1.0
"""Seconds of expressive motion that an emotion needs; of less it is not learned."""


def learn_expressions(takes: Sequence[Take], face: Face | None = None) -> RecordedExpressions | None:
    """Learn from every expressive take that has a neutral twin; None if no emotion was recorded so.

    Parameters
    ----------
    takes : sequence of Take
        Expressive and neutral ones, of one layout.
    face : Face or None
        The face whose channels are carried; None takes a head shaped after the speaker (`mien.capture`).

    Raises
    ------
    InputError
        If expressive takes have twins, but none of them can be used; the message tells the first reason.
    """
    stretches: dict[str, list[Floats]] = {}
    faults: list[str] = []
    twins = find_twins(takes)
    for pair in twins:
        try:
            stretches.setdefault(pair.expressive.emotion, []).append(expressive_displacement(pair))
        except InputError as problem:
            faults.append(str(problem))
    patch = LEAST_SECONDS * RATE
    kept = {name: found for name, found in sorted(stretches.items()) if sum(map(len, found)) >= patch}
    if not kept:
        if faults:
            raise InputError(
                f"none of the {len(twins)} expressive takes with a neutral twin can be used (mend or leave them out): "
                f"{faults[0]}"
            )
        return None
    to_channels = _ChannelsOfMarkers(twins[0], face)
    space = ExpressionSpace().fit({name: [to_channels.stretch(rows) for rows in found] for name, found in kept.items()})
    return RecordedExpressions(rounded(space), tuple(Note("warning", f"left out: {fault}") for fault in faults))


class _ChannelsOfMarkers:
    """What an expression does to the speaker's own face, captured from how it moves the markers."""

    def __init__(self, twins: Twins, face: Face | None) -> None:
        from mien.capture import fit_person  # learning needs them, performing does not: they take long to load
        from mien.corpus.capturing import source_of

        take = twins.neutral
        rest = np.asarray(np.nanmean(take.markers.positions, axis=0))
        lids = set(take.markers.names) - set(without_eyelids(take.layout))
        self.kept = [place for place, name in enumerate(take.markers.names) if name not in lids]
        self.names, self.layout, self.rest = take.markers.names, take.layout, rest
        source = source_of(take.layout, take.head)
        self.person = fit_person([take.markers], take.layout, source, neutral=rest, face=face).apart_from_speech()

    def stretch(self, displacement: Floats) -> ExpressiveMotion:
        """Expressive motion of a displacement, shape (samples, markers, 3): eyelids carried, not in the space."""
        from mien.capture import capture_take

        track = MarkerTrack(self.names, self.rest + displacement, FrameRate.of(RATE))
        captured = capture_take(track, self.layout, head=self.person).channels
        carried = captured.select(ALL).values
        return ExpressiveMotion(displacement[:, self.kept].reshape(len(displacement), -1), carried)


def expression_of(recorded: RecordedExpressions | None) -> Expression:
    """The expression model of a performer: what was recorded, and the hand-made repertoire for what was not."""
    hand_made = hand_made_expression()
    if recorded is None:
        return hand_made
    names = tuple(sorted({*hand_made.names, *recorded.space.emotions}))
    own = frozenset(recorded.space.emotions)

    efforts = {name: effort for name, effort in hand_made.efforts.items() if name not in own}
    spoken = {name: row for name, row in hand_made.spoken.items() if name not in own}

    def space_of(emotion: str) -> ExpressionSpace:
        return recorded.space if emotion in own else hand_made.space_of(emotion)

    return Expression(names, space_of, hand_made.sealed_share, frozenset(names) - own, efforts, spoken)
