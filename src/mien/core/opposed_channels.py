"""Channels that are two ways of one movement: a jaw is not to the left and to the right at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["OPPOSED", "apart"]

OPPOSED: tuple[tuple[str, str], ...] = (
    ("jawLeft", "jawRight"),
    ("mouthLeft", "mouthRight"),
    ("eyeLookUpLeft", "eyeLookDownLeft"),
    ("eyeLookUpRight", "eyeLookDownRight"),
    ("eyeLookInLeft", "eyeLookOutLeft"),
    ("eyeLookInRight", "eyeLookOutRight"),
)
"""Pairs of which one at most is above zero in what mien performs. (What a face seldom does at once, such as smiling and
frowning, is a matter of degree: the antagonists of `mien.capture`.)"""


def apart(
    values: NDArray[np.float64],
    names: Sequence[str],
    held: NDArray[np.bool_] | None = None,
    pairs: Sequence[tuple[str, str]] = OPPOSED,
) -> NDArray[np.float64]:
    """Let opposed channels take one another off, so that one of each pair at most is above zero.

    Parameters
    ----------
    values : ndarray, shape (frames, channels)
    names : sequence of str
        Of the channels; pairs that are not among them are passed over.
    held : ndarray of bool, shape (frames, channels), optional
        Values that were asked for exactly: they stay, and the other of their pair gives way to them.
    pairs : sequence of (str, str)
        Those to look at.

    Returns
    -------
    ndarray
        The difference of each pair is what it was, unless one was held.

    Examples
    --------
    >>> apart(np.array([[0.5, 0.25, 1.0]]), ("jawLeft", "jawRight", "jawOpen")).tolist()
    [[0.25, 0.0, 1.0]]
    """
    values = values.copy()
    places = {name: place for place, name in enumerate(names)}
    for pair in pairs:
        if not set(pair) <= set(places):
            continue
        one, other = (places[name] for name in pair)
        common = np.maximum(np.minimum(values[:, one], values[:, other]), 0.0)
        if held is None:
            values[:, one] -= common
            values[:, other] -= common
            continue
        both = common > 0
        keeps_one, keeps_other = held[:, one] & ~held[:, other], held[:, other] & ~held[:, one]
        values[:, one] = np.where(both & keeps_other, 0.0, values[:, one] - np.where(keeps_one, 0.0, common))
        values[:, other] = np.where(both & keeps_one, 0.0, values[:, other] - np.where(keeps_other, 0.0, common))
    return values
