"""`LiveOut`: what the page shows, sent to an engine as it is shown: Live Link Face or VMC packets over UDP."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass
from typing import Any

from mien.core.errors import MienError
from mien.serve.live.clock import RealClock, frames_due
from mien.serve.live.datagrams import (
    LIVELINK_PORT,
    VMC_PORT,
    Encode,
    Outbox,
    datagrams,
    livelink_encoder,
    parse_address,
    vmc_encoder,
)
from mien.serve.live.frames import Frame
from mien.serve.live.streaming import second_of_day
from mien.serve.studio.lru_store import Missing
from mien.serve.studio.requests import FieldError
from mien.serve.studio.studio_takes import Take
from mien.serve.studio.workshop import Workshop

__all__ = ["LiveOut", "Shown"]

PORTS = {"livelink": LIVELINK_PORT, "vmc": VMC_PORT, "vmc-vrm": VMC_PORT, "vmc-vrm1": VMC_PORT}
"""What can be sent, and the port at which it is usually heard."""


@dataclass(frozen=True)
class Shown:
    """What the page shows.

    Attributes
    ----------
    take : str
    at : float
        Seconds of the line.
    speed : float
        0 while it stands.
    loop : (float, float) or None
        Seconds.
    since : float
        When it was so, on the event loop's clock.
    """

    take: str
    at: float = 0.0
    speed: float = 0.0
    loop: tuple[float, float] | None = None
    since: float = 0.0

    @classmethod
    def of(cls, asked: dict[str, Any], now: float) -> Shown:
        """Read from JSON."""
        numbers = [asked.get("at", 0), asked.get("speed", 0), *(asked.get("loop") or (0, 0))]
        if not isinstance(asked.get("take"), str) or len(numbers) != 4:
            raise FieldError(
                "take", 'expected {"take": ID, "at": seconds, "speed": 0..4, "loop": [begin, end] or null}'
            )
        if any(isinstance(one, bool) or not isinstance(one, (int, float)) or not 0 <= one < 1e5 for one in numbers):
            raise FieldError("at", "moments and the speed are numbers from 0")
        at, speed, first, last = (float(one) for one in numbers)
        return cls(str(asked["take"]), at, min(speed, 4.0), (first, last) if last > first else None, now)

    def moment(self, now: float, seconds: float) -> float:
        """Seconds of the line that are shown now.

        Examples
        --------
        >>> Shown("a", 1.0, 0.5).moment(4.0, 2.5), Shown("a", 1.0, 1.0, (1.0, 2.0)).moment(4.25, 9.0)
        (2.5, 1.25)
        """
        at = self.at + (now - self.since) * self.speed
        if self.loop is not None and self.speed > 0 and at > self.loop[0]:
            first, last = self.loop
            at = first + (at - first) % (last - first)
        return min(max(at, 0.0), seconds)


class LiveOut:
    """Sends to one address what the page shows, picture by picture, until it is told to stop.

    Parameters
    ----------
    shop : Workshop
    """

    def __init__(self, shop: Workshop) -> None:
        self._shop, self._shown = shop, Shown("")
        self._task: asyncio.Task[None] | None = None
        self._told: dict[str, Any] = {}
        self.sent = 0

    def plain(self) -> dict[str, Any]:
        """As JSON."""
        sending = self._task is not None and not self._task.done()
        return {"sending": sending, "sent": self.sent, "kinds": PORTS, **(self._told if sending else {})}

    def show(self, asked: dict[str, Any]) -> None:
        """Say what the page shows from now on."""
        self._shown = Shown.of(asked, asyncio.get_running_loop().time())

    async def start(self, asked: dict[str, Any]) -> None:
        """Begin to send.

        Raises
        ------
        FieldError
            If the kind or the address cannot be used.
        """
        kind, to, subject = (str(asked.get(name) or "")[:200] for name in ("kind", "to", "subject"))
        if kind not in PORTS:
            raise FieldError("kind", f"expected one of {', '.join(PORTS)}, got {kind[:40]!r}")
        self.show(asked)
        try:
            address = parse_address(to.strip(), PORTS[kind])
            opened = contextlib.AsyncExitStack()
            outbox = await opened.enter_async_context(datagrams(address))
        except MienError as problem:
            raise FieldError("to", str(problem)) from problem
        await self.stop()
        self._told = {"kind": kind, "to": f"{address[0]}:{address[1]}"}
        self.sent = 0
        take = await asyncio.to_thread(self._shop.take, self._shown.take)
        self._task = asyncio.get_running_loop().create_task(self._send(opened, outbox, kind, subject or "mien", take))

    async def stop(self) -> None:
        """Send no more."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):
                await self._task
        self._task = None

    async def _send(
        self, opened: contextlib.AsyncExitStack, outbox: Outbox, kind: str, subject: str, take: Take
    ) -> None:
        clock, first = asyncio.get_running_loop(), take.animation
        names, rate = first.channels.names, first.rate
        encode: Encode
        if kind == "livelink":
            encode = livelink_encoder(names, rate, subject)
        else:
            encode = vmc_encoder(names, kind.removeprefix("vmc-") if "-" in kind else "arkit")
        encode(Frame(0, 0.0, first.channels.values[0]))  # whatever the first needs is loaded
        async with opened:
            async for number in frames_due(rate, RealClock()):
                with contextlib.suppress(Missing):  # deleted: the last picture stays
                    take = self._shop.takes.get(self._shown.take)
                track = take.animation.channels
                at = self._shown.moment(clock.time(), take.animation.utterance.duration)
                row = track.values[min(round(at * track.rate.fps), len(track) - 1)]
                if track.names == names:
                    outbox.send(encode(Frame(number, number / rate.fps, row, second_of_day())))
                    self.sent += 1
