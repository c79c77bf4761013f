"""Time: seconds, frame rates, intervals and tiers. Every rounding of time to frames lives here.

Conventions
-----------
* Times are seconds from the start of the sound, as ``float``.
* Frame ``i`` of a track at rate ``fps`` shows the instant ``i / fps`` (the frame's start; no half-frame offset).
* An `Interval` holds its start and not its end: ``start <= t < end``.
* A sound of ``d`` seconds is covered by ``ceil(d * fps)`` frames, so the picture ends within one frame after the
  sound and never before it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import fraction_of

__all__ = ["MAX_FPS", "FrameRate", "Interval", "Tier", "timecode"]

MAX_FPS = 1000
# A time within a millionth of a frame of the next frame counts as that frame, so that 0.04 s at 25 fps is frame 1.
_FRAME_TOLERANCE = 1e-6


@dataclass(frozen=True)
class FrameRate:
    """Frames per second as an exact fraction, so that 29.97 means 30000/1001.

    Examples
    --------
    >>> FrameRate.of(29.97)
    FrameRate(fraction=Fraction(30000, 1001))
    >>> FrameRate.of(25).frames_covering(2.01)
    51
    >>> FrameRate.of(25).time_of(50)
    2.0
    """

    fraction: Fraction

    @classmethod
    def of(cls, value: float | str | Fraction | FrameRate) -> FrameRate:
        """Read a rate from a number, a text such as ``"30000/1001"``, or another rate.

        Raises
        ------
        InputError
            If the value is not a number above 0 and up to `MAX_FPS`.
        """
        if isinstance(value, FrameRate):
            return value
        try:
            exact = fraction_of(value, "rate")
        except InputError as problem:
            raise InputError(
                f"a frame rate is a number above 0 such as 30 or 29.97, not {str(value)[:40]!r}"
            ) from problem
        if exact.limit_denominator(1001) <= 0 or exact > MAX_FPS:  # 0.0001 would become 0
            raise InputError(f"a frame rate is above 0 and at most {MAX_FPS} frames per second, not {value}")
        for ntsc in (24, 30, 48, 60, 120):
            rate = Fraction(ntsc * 1000, 1001)
            if abs(exact - rate) < Fraction(1, 200) and exact.denominator != 1:
                return cls(rate)
        return cls(exact.limit_denominator(1001))

    @property
    def fps(self) -> float:
        """Frames per second."""
        return float(self.fraction)

    def __str__(self) -> str:
        return f"{self.fps:g}"

    def time_of(self, frame: int) -> float:
        """Seconds at which frame ``frame`` stands."""
        return float(frame / self.fraction)

    def times(self, frames: int) -> NDArray[np.float64]:
        """Seconds of the first ``frames`` frames, shape (frames,)."""
        return np.arange(frames) * self.fraction.denominator / self.fraction.numerator

    def frame_at(self, seconds: float) -> int:
        """Number of the frame on show at ``seconds``: the last one that does not start later."""
        return math.floor(seconds * self.fraction + _FRAME_TOLERANCE)

    def nearest_frame(self, seconds: float) -> int:
        """Number of the frame that starts nearest to ``seconds`` (a tie goes to the later one)."""
        return math.floor(seconds * self.fraction + 0.5 + _FRAME_TOLERANCE)

    def frames_covering(self, seconds: float) -> int:
        """How many frames cover a stretch of ``seconds``: at least one."""
        return max(1, math.ceil(seconds * self.fraction - _FRAME_TOLERANCE))


@dataclass(frozen=True)
class Interval:
    """A labelled stretch of time: ``start`` is inside, ``end`` is not. Seconds."""

    start: float
    end: float
    label: str

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.end) and self.start <= self.end):
            raise InputError(f"interval {self.label!r} must run forward in finite time, not {self.start}..{self.end} s")

    @property
    def duration(self) -> float:
        """Length in seconds."""
        return self.end - self.start

    @property
    def middle(self) -> float:
        """The instant half-way through, in seconds."""
        return (self.start + self.end) / 2


@dataclass(frozen=True)
class Tier:
    """Intervals in order of time, not overlapping; gaps are allowed.

    Raises
    ------
    InputError
        If an interval starts before the one ahead of it has ended.

    Examples
    --------
    >>> tier = Tier("words", (Interval(0.1, 0.4, "never"), Interval(0.4, 0.7, "said")))
    >>> tier.at(0.4).label
    'said'
    >>> tier.at(0.9) is None
    True
    """

    name: str
    intervals: tuple[Interval, ...]

    def __post_init__(self) -> None:
        for before, after in zip(self.intervals, self.intervals[1:], strict=False):
            if after.start < before.end - 1e-9:
                raise InputError(
                    f"tier {self.name!r}: {after.label!r} starts at {after.start:.4f} s, "
                    f"before {before.label!r} has ended at {before.end:.4f} s"
                )

    def __len__(self) -> int:
        return len(self.intervals)

    def __iter__(self) -> Iterator[Interval]:
        return iter(self.intervals)

    def at(self, seconds: float) -> Interval | None:
        """The interval that holds an instant, or None in a gap."""
        place = bisect_right([interval.start for interval in self.intervals], seconds) - 1
        if place >= 0 and seconds < self.intervals[place].end:
            return self.intervals[place]
        return None

    def shifted(self, seconds: float) -> Tier:
        """The same tier, later by ``seconds``."""
        return Tier(self.name, tuple(Interval(i.start + seconds, i.end + seconds, i.label) for i in self.intervals))


def timecode(frame: int, rate: FrameRate, start: Fraction = Fraction(0)) -> str:
    """Timecode HH:MM:SS:FF.mmm of a frame as Live Link Face writes it.

    ``FF`` counts ticks of the rate rounded up to whole frames per second, ``mmm`` is the part of a tick: frames of
    29.97 come 1.001 ticks apart. ``start`` is the first frame's timecode in ticks since midnight.

    Examples
    --------
    >>> timecode(61, FrameRate.of(30))
    '00:00:02:01.000'
    >>> timecode(2, FrameRate.of(59.94))
    '00:00:00:02.002'
    """
    whole = math.ceil(rate.fraction)
    ticks, part = divmod(round(1000 * (start + frame * whole / rate.fraction)), 1000)
    seconds, tick = divmod(ticks, whole)
    return f"{seconds // 3600 % 24:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{tick:02d}.{part:03d}"
