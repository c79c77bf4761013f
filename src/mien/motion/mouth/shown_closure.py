"""Lips that are shut on the face that is shown, whatever brought them there.

Markers that touch do not make lips touch: a solver may roll the upper lip in behind the lower one, or leave the jaw
some millimetres down, and an emotion raises or lowers a lip besides. At the closures of /p b m/ the lips are therefore
brought together in the channels themselves: ``mouthClose`` undoes what ``jawOpen`` opens, as ARKit defines the two, and
what lifts, lowers or rolls a single lip gives way. Hand-made.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.time_spans import seconds_away
from mien.core.timeline import Tier

__all__ = ["BILABIALS", "bilabial_seal", "close_lips"]

Floats = NDArray[np.float64]
BILABIALS = frozenset({"P", "B", "M"})
_SEALED = {True: BILABIALS, False: frozenset({"F", "V"})}
_JAW, _CLOSE = (channels.ALL.index(name) for name in ("jawOpen", "mouthClose"))
_APART = [
    channels.ALL.index(name)
    for name in (
        "mouthUpperUpLeft",
        "mouthUpperUpRight",
        "mouthLowerDownLeft",
        "mouthLowerDownRight",
        "mouthFunnel",
        "mouthRollUpper",
    )
]


def bilabial_seal(seal: Floats, phones: Tier, times: Floats) -> Floats:
    """The part of a seal that is of both lips, shape (frames,): nearer to a /p b m/ than to an /f v/.

    Parameters
    ----------
    seal : ndarray, shape (frames,)
        0..1: how strictly the lips are shut, or the lower one on the teeth.
    phones : Tier
    times : ndarray, shape (frames,)
        Seconds.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> phones = Tier("phones", (Interval(0.0, 0.1, "B"), Interval(0.1, 0.2, "AA"), Interval(0.2, 0.3, "V")))
    >>> bilabial_seal(np.array([1.0, 0.2, 1.0]), phones, np.array([0.05, 0.12, 0.25])).tolist()
    [1.0, 0.2, 0.0]
    """
    away = {both: seconds_away([p for p in phones if p.label in labels], times) for both, labels in _SEALED.items()}
    return np.where(away[True] < away[False], seal, 0.0)


def close_lips(values: Floats, seal: Floats) -> Floats:
    """Channels with the lips brought together by ``seal``, both of ``frames`` rows; `mien.core.channels.ALL`.

    Examples
    --------
    >>> values = np.zeros((1, len(channels.ALL)))
    >>> values[0, _JAW] = 0.2
    >>> float(close_lips(values, np.ones(1))[0, _CLOSE])
    0.2
    """
    shut = values.copy()
    shut[:, _CLOSE] = np.maximum(shut[:, _CLOSE], seal * shut[:, _JAW])
    shut[:, _APART] *= 1 - seal[:, None]
    return shut
