"""`Watch`: bounds the number of connections, and cuts off those that send or take nothing."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import Counter
from collections.abc import Iterator

from aiohttp import web

from mien.serve.studio.settings import Limits

__all__ = ["Watch"]


class Watch:
    """The connections of one server.

    A connection on which no request is being answered has `Limits.head_seconds` to bring a whole head (bodies have
    their own limit, where they are read); one whose answer waits to be taken has `Limits.request_seconds` to take some.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._answering: Counter[asyncio.BaseTransport] = Counter()
        self._begun: Counter[asyncio.BaseTransport] = Counter()
        self._seen: dict[asyncio.BaseTransport, tuple[tuple[int, int, int], float]] = {}

    @contextlib.contextmanager
    def answering(self, request: web.Request) -> Iterator[None]:
        """A request is being answered inside."""
        transport = request.transport
        if transport is None:
            yield
            return
        self._answering[transport] += 1
        self._begun[transport] += 1
        try:
            yield
        finally:
            self._answering[transport] -= 1

    def protocol(self, server: web.Server) -> asyncio.BaseProtocol:
        """The protocol of a new connection; one too many is closed at once."""
        return _TurnedAway() if len(server.connections) >= self._limits.connections else server()

    async def sweep(self, server: web.Server) -> None:
        """Look at all connections again and again, for ever."""
        while True:
            await asyncio.sleep(min(1.0, self._limits.head_seconds / 4))
            transports = [connection.transport for connection in server.connections]
            self.look([transport for transport in transports if transport is not None], time.monotonic())

    def look(self, transports: list[asyncio.Transport], now: float) -> None:
        """Cut off those of which nothing has come and nothing was taken for too long."""
        for gone in set(self._begun) - set(transports):
            del self._begun[gone], self._answering[gone]
        before, self._seen = self._seen, {}
        for transport in transports:
            state = self._begun[transport], self._answering[transport], transport.get_write_buffer_size()
            known, since = before.get(transport, (state, now))
            since = since if known == state else now
            works = state[1] > 0 and state[2] == 0
            patience = self._limits.request_seconds if state[2] else self._limits.head_seconds
            if not works and now - since > patience:
                transport.abort()
            else:
                self._seen[transport] = state, since


class _TurnedAway(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        transport.close()
