"""What became of a layer on one take: what could not be laid on, and what was there before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mien.animation.edits.layer import EditLayer
from mien.core.errors import Note
from mien.core.timeline import Tier
from mien.text.score import EmotionSpan

__all__ = ["AppliedEdits", "Before", "Lost", "lost_notes"]


@dataclass(frozen=True)
class Lost:
    """An edit, or one of its points, that could not be laid on.

    Attributes
    ----------
    edit : int
        Its place in the layer.
    point : int or None
        Which of its points or keys; None: all of it.
    why : str
        One line.
    """

    edit: int
    point: int | None
    why: str


@dataclass(frozen=True, eq=False)
class Before:
    """What the edits took the place of, so that they can be taken off again.

    Attributes
    ----------
    words, phones : Tier
    native : Tier or None
    emotions : tuple of EmotionSpan
    channels : mapping of str to ndarray, shape (frames,)
        The edited channels without the curves, but under moved borders and changed intensities.
    """

    words: Tier
    phones: Tier
    native: Tier | None
    emotions: tuple[EmotionSpan, ...]
    channels: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Before) or self.channels.keys() != other.channels.keys():
            return False
        plain = (self.words, self.phones, self.native, self.emotions)
        same = all(np.array_equal(values, other.channels[name]) for name, values in self.channels.items())
        return same and plain == (other.words, other.phones, other.native, other.emotions)


@dataclass(frozen=True)
class AppliedEdits:
    """A layer as it lies on an animation.

    Attributes
    ----------
    layer : EditLayer
        With the line on which it was made.
    lost : tuple of Lost
    before : Before
    """

    layer: EditLayer
    lost: tuple[Lost, ...]
    before: Before


def lost_notes(layer: EditLayer, lost: tuple[Lost, ...]) -> tuple[Note, ...]:
    """What was lost, for a person."""
    told = []
    for loss in lost:
        point = "" if loss.point is None else f", point {loss.point + 1}"
        kind = type(layer.edits[loss.edit]).__name__.removesuffix("Edit").lower()
        told.append(Note("warning", f"edit {loss.edit + 1} ({kind}{point}) cannot be applied: {loss.why}"))
    return tuple(told)
