"""`AlignedPhone`: what the aligner finds, phone by phone."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["AlignedPhone"]


@dataclass(frozen=True)
class AlignedPhone:
    """A phone in time, seconds.

    Attributes
    ----------
    label : str
    start, end : float
    word : int
        Number of its word; -1 in a pause.
    score : float
        How much less likely it is than the likeliest label, mean over its rows: natural logarithm, 0 where it fits.
    other : float
        Seconds of a pause in which there is speech that the text does not have.
    """

    label: str
    start: float
    end: float
    word: int
    score: float
    other: float = 0.0
