"""`EffortSpan`: how hard somebody articulates over a stretch of time, 0 to 2; 1: as recorded (docs/effort.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.text.intensity import IntensityCurve, checked, parse_values

__all__ = ["AS_RECORDED", "HIGHEST", "EffortCurve", "EffortSpan", "effort_over", "parse_effort"]

Floats = NDArray[np.float64]
AS_RECORDED = 1.0
HIGHEST = 2.0
RAMP = 0.3
"""Seconds over which effort changes where a stretch starts or ends inside the line."""
Source = Literal["asked", "voice", "off"]


@dataclass(frozen=True)
class EffortCurve(IntensityCurve):
    """An effort that changes over time: an `IntensityCurve` whose values run from 0 to 2.

    Examples
    --------
    >>> EffortCurve((0.0, 2.0), (0.5, 1.6)).at(np.array([1.0])).round(2).tolist()
    [1.05]
    """

    highest: ClassVar[float] = HIGHEST
    what: ClassVar[str] = "effort"


@dataclass(frozen=True)
class EffortSpan:
    """An effort over a stretch of time; within it, it takes the place of what was asked for before it.

    Attributes
    ----------
    level : float or EffortCurve
        0 (nothing moves but what the words cannot do without) to 2; 1 is as recorded.
    start, end : float or None
        Seconds; None means the start or end of the sound.
    source : {"asked", "voice", "off"}
        Where it comes from, and so what an emotion's own effort does to it: it is added to what is asked for by hand;
        it takes the place of a voice's, which says the same, as far as the emotion is shown; ``off`` leaves it out (as
        for a voice's effort that was asked for by name, ``auto``).

    Raises
    ------
    InputError
        If the level lies outside 0..2, or the stretch runs backwards.
    """

    level: float | EffortCurve = AS_RECORDED
    start: float | None = None
    end: float | None = None
    source: Source = "asked"

    def __post_init__(self) -> None:
        if not isinstance(self.level, EffortCurve):
            checked(self.level, EffortCurve)
        if self.start is not None and self.end is not None and self.end < self.start:
            raise InputError(f"an effort ends at {self.end:g} s, before it starts at {self.start:g} s")

    def level_at(self, seconds: Floats) -> Floats:
        """Levels at instants, whether inside the stretch or not, shape (times,)."""
        if isinstance(self.level, EffortCurve):
            return self.level.at(seconds)
        return np.full(len(seconds), float(self.level))

    def share_at(self, seconds: Floats) -> Floats:
        """1 inside the stretch, 0 outside, half a cosine about each end that lies inside the line, shape (times,)."""
        share = np.ones(len(seconds))
        if self.start is not None:
            share *= _ease((seconds - self.start) / RAMP + 0.5)
        if self.end is not None:
            share *= _ease((self.end - seconds) / RAMP + 0.5)
        return share


def _ease(passed: Floats) -> Floats:
    return np.asarray((1 - np.cos(np.pi * np.clip(passed, 0.0, 1.0))) / 2)


def parse_effort(text: str) -> float | EffortCurve:
    """Read ``1.4``, key points ``0.5@0,1.6@2`` (value at second), or the name of a ``.csv`` file.

    Raises
    ------
    InputError
        If it is none of these, or out of range.

    Examples
    --------
    >>> parse_effort("0.5@0, 1.6@2").values
    (0.5, 1.6)
    """
    return parse_values(text, EffortCurve)


def effort_over(spans: Sequence[EffortSpan], felt: Floats, shown: Floats, times: Floats) -> Floats:
    """The effort at instants, shape (times,), 0 to 2.

    Parameters
    ----------
    spans : sequence of EffortSpan
        A later one takes the place of earlier ones where it stands.
    felt : ndarray, shape (times,)
        What the emotions ask for: 1, or more or less.
    shown : ndarray, shape (times,)
        How far emotions are shown: 0 (neutral) to 1.
    times : ndarray, shape (times,)
        Seconds.

    Examples
    --------
    >>> voice = EffortSpan(1.5, source="voice")
    >>> felt, shown = np.full(3, 1.2), np.full(3, 0.5)
    >>> effort_over([voice, EffortSpan(0.6, 1.0, 2.0)], felt, shown, np.array([0.0, 1.5, 3.0])).round(3).tolist()
    [1.45, 0.8, 1.45]
    """
    level, heard, off = np.ones(len(times)), np.zeros(len(times)), np.zeros(len(times))
    for span in spans:
        share = span.share_at(times)
        level += share * (span.level_at(times) - level)
        heard += share * ((span.source == "voice") - heard)
        off += share * ((span.source == "off") - off)
    own, more = level - AS_RECORDED, felt - AS_RECORDED
    total = own * (1 - heard * shown) + more * (1 - off)
    return np.asarray(np.clip(AS_RECORDED + total, 0.0, HIGHEST))
