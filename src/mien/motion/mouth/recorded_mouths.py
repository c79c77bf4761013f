"""The mouth in a take: which markers it is made of, and its frames in speech. What the speech models learn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.tracks import MarkerTrack
from mien.core.utterance import PAUSE
from mien.corpus.take import Take

__all__ = ["RecordedMouth", "mouth_markers", "only_mouth", "recorded_mouths"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RecordedMouth:
    """The frames of one take in which it speaks and every marker was seen.

    Attributes
    ----------
    phones : Tier
    times : ndarray, shape (frames,)
        Seconds.
    positions : ndarray, shape (frames, markers * 3)
        Millimetres.
    """

    phones: Tier
    times: Floats
    positions: Floats


def mouth_markers(layout: str, names: Sequence[str]) -> tuple[int, ...]:
    """Places of the mouth markers of a layout among marker names, in the order of ``names``.

    Raises
    ------
    InputError
        If the layout is not known, or no name belongs to its mouth.

    Examples
    --------
    >>> mouth_markers("mediapipe-218", ("11.1", "2.2", "2.3"))
    (1, 2)
    """
    members = set(load_layout(layout).groups["mouth"])
    places = tuple(place for place, name in enumerate(names) if name in members)
    if not places:
        raise InputError(
            f"none of the {len(names)} markers belongs to the mouth of layout {layout!r}: nothing to learn"
        )
    return places


def only_mouth(take: Take) -> Take:
    """The same take with its mouth markers only."""
    kept = list(mouth_markers(take.layout, take.markers.names))
    if len(kept) == len(take.markers.names):
        return take
    names = [take.markers.names[place] for place in kept]
    return replace(take, markers=MarkerTrack(names, take.markers.positions[:, kept], take.markers.rate))


def recorded_mouths(takes: Sequence[Take], margin: float) -> tuple[RecordedMouth, ...]:
    """Frames from ``margin`` seconds before the first phone to ``margin`` after the last; pauses inside count.

    Takes without such a frame are left out.

    Raises
    ------
    InputError
        If the takes do not share their markers, or none has a frame to learn from.
    """
    found: list[RecordedMouth] = []
    for take in takes:
        if take.markers.names != takes[0].markers.names:
            raise InputError(f"take {take.name!r} has other markers than take {takes[0].name!r}: learn from one layout")
        spoken = [phone for phone in take.phones if phone.label != PAUSE]
        if not spoken:
            continue
        flat = take.markers.positions.reshape(len(take.markers), -1)
        times = take.markers.rate.times(len(flat))
        kept = np.isfinite(flat).all(axis=1)
        kept &= (times >= spoken[0].start - margin) & (times <= spoken[-1].end + margin)
        if kept.any():
            found.append(RecordedMouth(take.phones, times[kept], flat[kept]))
    if not found:
        raise InputError(f"none of the {len(takes)} takes to learn from has a frame with speech and every marker seen")
    return tuple(found)
