"""`AlignedPhone`: what the aligner finds, phone by phone."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["AlignedPhone"]


@dataclass(frozen=True)
class AlignedPhone:
    """A phone in time. ``word`` is the number of its word, -1 in a pause; ``score`` is per frame of 5 ms."""

    label: str
    start: float
    end: float
    word: int
    score: float
