"""An animation played in real time to whoever listens: `stream`."""

from __future__ import annotations

import contextlib
import datetime
import io
import time
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from mien.animation.animation import Animation
from mien.core.audio import Audio
from mien.serve.live.clock import Clock, RealClock, frames_due
from mien.serve.live.datagrams import Encode, Outbox, datagrams
from mien.serve.live.frames import Frame, Greeting
from mien.serve.live.hub import Hub
from mien.serve.live.sockets import SOUND, Access, websocket_stream

__all__ = ["OpenOutlets", "Outlets", "Played", "greeting_of", "opened_outlets", "second_of_day", "stream", "wav_of"]


_LEAD = 0.1
"""Seconds between telling when frame 0 stands and that frame, so that a receiver can start its sound in time."""


def wav_of(audio: Audio) -> bytes:
    """A sound as a WAV file, 24 bit."""
    import soundfile

    content = io.BytesIO()
    soundfile.write(content, audio.samples, audio.rate, format="WAV", subtype="PCM_24")
    return content.getvalue()


def second_of_day() -> float:
    """Seconds since midnight on this machine's clock, as timecode counts."""
    now = datetime.datetime.now()
    return now.hour * 3600 + now.minute * 60 + now.second + now.microsecond / 1e6


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


def greeting_of(animation: Animation, loop: bool = False) -> Greeting:
    """The greeting of a stream of an animation: its text, words and phones are among the facts.

    ``loop``: it goes round and round; the fact ``round`` is how many seconds it takes each time.
    """
    speech = animation.utterance

    def told(tier: Any) -> list[list[Any]]:
        return [[round(i.start, 4), round(i.end, 4), i.label] for i in tier]

    facts = {
        "text": speech.text,
        "seconds": speech.duration,
        "words": told(speech.words),
        "phones": told(speech.phones),
        "performer": animation.provenance.performer,
        "sound": SOUND,
    }
    if loop:
        facts["round"] = len(animation.channels) / animation.rate.fps
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
    _senders: Sequence[tuple[Outbox, Encode]]

    def prepare(self, frame: Frame) -> None:
        """Load whatever the first frame needs, before any clock runs."""
        for _, encode in self._senders:
            encode(frame)

    async def heard(self, frame: Frame) -> None:
        """Wait until somebody listens at every outlet.

        Whether a packet is heard cannot be known; a machine that has nobody at the port mostly says so, and is asked
        again with ``frame`` until it does not.
        """
        if self.port is not None:
            await self.hub.occupied()
        for outbox, encode in self._senders:
            await outbox.welcome(encode(frame))

    def send(self, frame: Frame) -> None:
        """Hand a frame to everybody; never waits."""
        self.hub.publish(frame)
        for outbox, encode in self._senders:
            outbox.send(encode(frame))


@contextlib.asynccontextmanager
async def opened_outlets(
    outlets: Outlets, greeting: Greeting, sound: bytes | None = None
) -> AsyncIterator[OpenOutlets]:
    """Open all outlets while the context lasts; at its end the WebSocket's clients are told.

    ``sound``: a WAV file that clients of the WebSocket can fetch.

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
            port = await stack.enter_async_context(websocket_stream(hub, greeting, outlets.websocket, sound))
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
        Begin when the first WebSocket client has come, and nobody refuses packets any more.
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
    clock = clock or RealClock()
    sound = wav_of(animation.utterance.audio) if outlets.websocket is not None else None
    async with opened_outlets(outlets, greeting_of(animation, loop), sound) as open_to:
        open_to.prepare(Frame(0, 0.0, values[0]))
        opened(open_to.port)
        if wait:
            await open_to.heard(Frame(0, 0.0, values[0]))
        began = clock.now() + _LEAD
        open_to.hub.begin(time.time() + _LEAD)
        day = second_of_day() + _LEAD
        async for number in frames_due(rate, clock, began):
            if number >= len(values) and not loop:
                break
            at = rate.time_of(number)
            open_to.send(Frame(number, at, values[number % len(values)], day + at))
            sent, last = sent + 1, number + 1
    return Played(sent, last - sent)
