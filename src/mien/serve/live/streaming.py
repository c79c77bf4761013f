"""An animation played in real time to whoever listens: `stream`."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from mien.animation.animation import Animation
from mien.serve.live.clock import Clock, RealClock, frames_due
from mien.serve.live.datagrams import Encode, datagrams
from mien.serve.live.frames import Frame, Greeting
from mien.serve.live.hub import Hub
from mien.serve.live.sockets import Access, websocket_stream

__all__ = ["OpenOutlets", "Outlets", "Played", "greeting_of", "opened_outlets", "stream"]


@dataclass(frozen=True)
class Outlets:
    """Where a stream goes.

    Attributes
    ----------
    websocket : Access or None
    datagrams : sequence of ((host, port), encoder)
        Packets for engines (`mien.serve.live.datagrams`).
    """

    websocket: Access | None = None
    datagrams: Sequence[tuple[tuple[str, int], Encode]] = field(default_factory=tuple)


@dataclass(frozen=True)
class Played:
    """What a finished stream did.

    Attributes
    ----------
    frames, skipped : int
        Frames sent, and frames passed over because the machine was late.
    """

    frames: int
    skipped: int


def greeting_of(animation: Animation) -> Greeting:
    """The greeting of a stream of an animation: its text, words and phones are among the facts."""
    speech = animation.utterance

    def told(tier: Any) -> list[list[Any]]:
        return [[round(i.start, 4), round(i.end, 4), i.label] for i in tier]

    facts = {
        "text": speech.text,
        "seconds": speech.duration,
        "words": told(speech.words),
        "phones": told(speech.phones),
        "performer": animation.provenance.performer,
    }
    return Greeting(animation.channels.names, animation.rate.fps, facts)


@dataclass(frozen=True)
class OpenOutlets:
    """Outlets that take frames.

    Attributes
    ----------
    port : int or None
        Of the WebSocket.
    hub : Hub
    """

    port: int | None
    hub: Hub
    _senders: Sequence[tuple[Callable[[bytes], None], Encode]]

    def send(self, frame: Frame) -> None:
        """Hand a frame to everybody; never waits."""
        self.hub.publish(frame)
        for send, encode in self._senders:
            send(encode(frame))


@contextlib.asynccontextmanager
async def opened_outlets(outlets: Outlets, greeting: Greeting) -> AsyncIterator[OpenOutlets]:
    """Open all outlets while the context lasts; at its end the WebSocket's clients are told.

    Raises
    ------
    OutputError
        If an address cannot be listened on or sent to.
    """
    hub = Hub()
    async with contextlib.AsyncExitStack() as stack:
        senders = [(await stack.enter_async_context(datagrams(a)), encode) for a, encode in outlets.datagrams]
        port = None
        if outlets.websocket is not None:
            port = await stack.enter_async_context(websocket_stream(hub, greeting, outlets.websocket))
        try:
            yield OpenOutlets(port, hub, senders)
        finally:
            hub.end()


async def stream(
    animation: Animation,
    outlets: Outlets,
    *,
    loop: bool = False,
    wait: bool = False,
    clock: Clock | None = None,
    opened: Callable[[int | None], None] = lambda port: None,
) -> Played:
    """Play an animation in real time.

    Parameters
    ----------
    animation : Animation
    outlets : Outlets
    loop : bool
        Begin again at the end, until stopped; frame numbers and times go on.
    wait : bool
        Begin when the first WebSocket client has come.
    clock : Clock or None
        None takes the machine's.
    opened : callable (port or None)
        Called once all outlets are open, with the port of the WebSocket.

    Raises
    ------
    OutputError
        If an address cannot be listened on or sent to.
    """
    values, rate = animation.channels.values, animation.rate
    sent = last = 0
    async with opened_outlets(outlets, greeting_of(animation)) as open_to:
        opened(open_to.port)
        if wait:
            await open_to.hub.occupied()
        async for number in frames_due(rate, clock or RealClock()):
            if number >= len(values) and not loop:
                break
            open_to.send(Frame(number, rate.time_of(number), values[number % len(values)]))
            sent, last = sent + 1, number + 1
    return Played(sent, last - sent)
