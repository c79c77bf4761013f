"""Phones about each instant, as numbers: what the baselines see of an utterance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take

__all__ = ["STEP", "PhoneContext", "mouth_frames", "speech_frames"]

STEP = 0.04
"""Seconds between two looks at the phones."""
MARGIN = 0.08
"""Seconds before and after speech that are learned with it."""

Array = NDArray[np.float64]


class PhoneContext:
    """Which phone sounds at and around an instant: one of n at each look.

    Parameters
    ----------
    reach : float
        Seconds to look back and ahead, in steps of `STEP`.

    Attributes
    ----------
    symbols_ : tuple of str
        Phones met in learning; another one is seen as none of them.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> tier = Tier("phones", (Interval(0.0, 0.1, "M"), Interval(0.1, 0.2, "AA")))
    >>> PhoneContext(0.04).fit([tier]).encode(tier, np.array([0.08]))
    array([[1, 4, 6]])
    """

    def __init__(self, reach: float) -> None:
        self.looks = np.arange(-round(reach / STEP), round(reach / STEP) + 1) * STEP

    def fit(self, tiers: Sequence[Tier]) -> PhoneContext:
        """Learn which phones there are."""
        self.symbols_ = tuple(sorted({PAUSE} | {phone.label for tier in tiers for phone in tier}))
        return self

    @property
    def width(self) -> int:
        """Number of columns of the one-of-n code."""
        return len(self.looks) * len(self.symbols_)

    def encode(self, phones: Tier, times: Array) -> NDArray[np.int64]:
        """Column that is 1 for each look at each time, -1 for an unknown phone: shape (frames, looks).

        Before the first phone and after the last one there is a pause.
        """
        number = {symbol: place for place, symbol in enumerate(self.symbols_)}
        labels = np.array([number.get(p.label, -1) for p in phones] + [number[PAUSE]])
        starts = np.array([p.start for p in phones] or [0.0])
        ends = np.array([p.end for p in phones] or [0.0])
        at = times[:, None] + self.looks + 1e-9
        place = np.searchsorted(starts, at, side="right") - 1
        held = (place >= 0) & (at < ends[np.maximum(place, 0)])
        code = labels[np.where(held, place, -1)]
        return np.where(code < 0, -1, code + np.arange(len(self.looks)) * len(self.symbols_))


def mouth_frames(take: Take) -> tuple[Array, Array]:
    """Times and flat positions of the frames in which every marker was seen: (frames,), (frames, markers * 3)."""
    flat = take.markers.positions.reshape(len(take.markers), -1)
    seen = np.isfinite(flat).all(axis=1)
    return take.markers.rate.times(len(flat))[seen], flat[seen]


def speech_frames(take: Take) -> tuple[Array, Array]:
    """As `mouth_frames`, from `MARGIN` before the first phone to `MARGIN` after the last."""
    times, flat = mouth_frames(take)
    spoken = [phone for phone in take.phones if phone.label != PAUSE]
    if not spoken:
        return times[:0], flat[:0]
    held = (times >= spoken[0].start - MARGIN) & (times <= spoken[-1].end + MARGIN)
    return times[held], flat[held]
