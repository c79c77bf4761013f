"""When each frame of a stream is due, on a real or a simulated clock."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from typing import Protocol

from mien.core.timeline import FrameRate

__all__ = ["Clock", "RealClock", "SimulatedClock", "frames_due"]


class Clock(Protocol):
    """Seconds from any fixed instant, and waiting for one."""

    def now(self) -> float:
        """Seconds."""

    async def wait_until(self, seconds: float) -> None:
        """Return when `now` has reached ``seconds``; at once if it has already."""


class RealClock:
    """The machine's steady clock."""

    def now(self) -> float:
        """Seconds of the steady clock."""
        return time.monotonic()

    async def wait_until(self, seconds: float) -> None:
        """Sleep until then."""
        await asyncio.sleep(max(0.0, seconds - self.now()))


class SimulatedClock:
    """A clock that jumps to whatever is waited for: an hour passes in a moment.

    Parameters
    ----------
    late : callable or None
        Called with the instant waited for, returns by how many seconds the wake-up comes late (a busy machine).
    """

    def __init__(self, late: LateBy | None = None) -> None:
        self._now, self._late = 0.0, late

    def now(self) -> float:
        """Seconds since the clock was made."""
        return self._now

    async def wait_until(self, seconds: float) -> None:
        """Jump there, and let other tasks run."""
        self._now = max(self._now, seconds + (self._late(seconds) if self._late else 0.0))
        await asyncio.sleep(0)


class LateBy(Protocol):
    """How late a simulated clock wakes up."""

    def __call__(self, seconds: float) -> float:
        """Seconds, 0 or more."""


async def frames_due(rate: FrameRate, clock: Clock, start: float | None = None) -> AsyncIterator[int]:
    """Numbers of the frames as they fall due, without end.

    Frame ``i`` falls due at ``start + i / fps``, told from the start and not from the frame before it: lateness is
    never added up. Frames whose successor is due already are passed over, so that a late stream catches up at once.
    """
    start = clock.now() if start is None else start
    number = 0
    while True:
        await clock.wait_until(start + rate.time_of(number))
        number = max(number, rate.frame_at(max(0.0, clock.now() - start)))
        yield number
        number += 1
