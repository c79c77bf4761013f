"""The mouth in a take: its frames in speech, as rows of a mouth space. What the speech models learn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.mouth.mouth_space import MouthSpace

__all__ = ["RecordedMouth", "recorded_mouths"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RecordedMouth:
    """The frames of one take in which it speaks and all of the mouth was seen.

    Attributes
    ----------
    phones : Tier
    times : ndarray, shape (frames,)
        Seconds.
    rows : ndarray, shape (frames, columns)
        Of the mouth space (`mien.motion.mouth.mouth_space`).
    """

    phones: Tier
    times: Floats
    rows: Floats


def recorded_mouths(takes: Sequence[Take], margin: float, space: MouthSpace) -> tuple[RecordedMouth, ...]:
    """Frames from ``margin`` seconds before the first phone to ``margin`` after the last; pauses inside count.

    Takes without such a frame are left out.

    Raises
    ------
    InputError
        If the takes do not fit the space, or none has a frame to learn from.
    """
    found: list[RecordedMouth] = []
    for take in takes:
        spoken = [phone for phone in take.phones if phone.label != PAUSE]
        if not spoken:
            continue
        rows = space.rows_of(take)
        times = take.markers.rate.times(len(rows))
        kept = np.isfinite(rows).all(axis=1)
        kept &= (times >= spoken[0].start - margin) & (times <= spoken[-1].end + margin)
        if kept.any():
            found.append(RecordedMouth(take.phones, times[kept], rows[kept]))
    if not found:
        raise InputError(f"none of the {len(takes)} takes to learn from has a frame with speech and every marker seen")
    return tuple(found)
