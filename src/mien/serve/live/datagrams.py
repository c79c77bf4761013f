"""Frames sent as UDP packets to engines: VMC and Live Link Face."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import uuid
from collections.abc import AsyncIterator, Callable, Sequence
from typing import Any

from mien.core.errors import InputError, OutputError
from mien.core.limits import is_whole
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.livelink import livelink_motion
from mien.serve.live.frames import Frame
from mien.serve.live.livelink_packets import LiveLinkPacket, encode_livelink
from mien.serve.live.vmc import HEAD_REST, VmcEncoder

__all__ = [
    "LIVELINK_PORT",
    "VMC_PORT",
    "Encode",
    "Outbox",
    "datagrams",
    "livelink_encoder",
    "parse_address",
    "vmc_encoder",
]

VMC_PORT, LIVELINK_PORT = 39539, 11111
_ASK_AGAIN = 0.25  # seconds

Encode = Callable[[Frame], bytes]


def parse_address(text: str, port: int) -> tuple[str, int]:
    """Read ``HOST``, ``HOST:PORT``, ``:PORT`` or ``[IPV6]:PORT``; ``port`` where none is given.

    Raises
    ------
    InputError
        If the port is no number from 1 to 65535.

    Examples
    --------
    >>> parse_address("192.168.0.7", 39539), parse_address(":11111", 39539), parse_address("[::1]:5000", 1)
    (('192.168.0.7', 39539), ('127.0.0.1', 11111), ('::1', 5000))
    """
    host, colon, number = text.rpartition(":") if text.count(":") == 1 or "]:" in text else (text, "", "")
    if colon:
        if not is_whole(number) or not 1 <= int(number) <= 65535:
            raise InputError(f"expected HOST:PORT with a port from 1 to 65535, got {text!r}")
        port = int(number)
    return host.strip("[]") or "127.0.0.1", port


def vmc_encoder(channels: Sequence[str], shapes: str, head: tuple[float, float, float] | None = HEAD_REST) -> Encode:
    """Packets of the VMC protocol (`mien.serve.live.vmc`)."""
    return VmcEncoder(channels, shapes, head).encode


def livelink_encoder(channels: Sequence[str], rate: FrameRate, subject: str) -> Encode:
    """Packets of Live Link Face under the name that the engine shows, with the timecode of this machine's clock."""
    names = tuple(channels)
    device = str(uuid.uuid5(uuid.NAMESPACE_DNS, subject)).upper()  # the same subject is the same device at every start

    def encode(frame: Frame) -> bytes:
        numbers = livelink_motion(ChannelTrack(names, frame.values[None], rate))[0]
        fraction = rate.fraction
        number = frame.number if frame.clock is None else round(frame.clock * rate.fps)
        packet = LiveLinkPacket(device, subject, number, (fraction.numerator, fraction.denominator), numbers)
        return encode_livelink(packet)

    return encode


@contextlib.asynccontextmanager
async def datagrams(address: tuple[str, int]) -> AsyncIterator[Outbox]:
    """Send packets to an address while the context lasts; whether anyone hears them cannot be known.

    Raises
    ------
    OutputError
        If the name of the host cannot be resolved.
    """
    loop = asyncio.get_running_loop()
    try:
        transport, deaf = await loop.create_datagram_endpoint(_Deaf, remote_addr=address)
    except (OSError, socket.gaierror) as problem:
        raise OutputError(f"cannot send to {address[0]}:{address[1]}: {problem.strerror or problem}") from problem
    try:
        yield Outbox(transport, deaf)
    finally:
        transport.close()


class _Deaf(asyncio.DatagramProtocol):
    """Nobody listening is no fault of a stream: the engine may be started later."""

    refused = 0

    def error_received(self, problem: Any) -> None:
        """A refused packet: the next one may be heard."""
        self.refused += 1


class Outbox:
    """Where packets go."""

    def __init__(self, transport: asyncio.DatagramTransport, deaf: _Deaf) -> None:
        self._transport, self._deaf = transport, deaf

    def send(self, packet: bytes) -> None:
        """Send one; never waits."""
        self._transport.sendto(packet)

    async def welcome(self, packet: bytes) -> None:
        """Send a packet again and again, until the other machine no longer says that nobody is there."""
        while True:
            refused = self._deaf.refused
            self.send(packet)
            await asyncio.sleep(_ASK_AGAIN)
            if self._deaf.refused == refused:
                return
