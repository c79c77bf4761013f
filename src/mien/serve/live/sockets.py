"""The WebSocket of a stream, safe by default: loopback only, or a token; pages of other origins are refused."""

from __future__ import annotations

import asyncio
import contextlib
import http
import secrets
from collections.abc import AsyncIterator
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from mien.core.errors import OutputError
from mien.serve.addresses import check_address, is_loopback
from mien.serve.live.frames import END, Greeting, encode_frame
from mien.serve.live.hub import Hub, Listener

__all__ = ["MOST_CLIENTS", "PATIENCE", "SOUND", "Access", "websocket_stream"]

SOUND = "/sound.wav"
"""Where the sound of a stream is, on the port of its WebSocket."""

MOST_CLIENTS = 64
"""Clients at once; one more is turned away."""
PATIENCE = 5.0
"""Seconds after which a client that takes nothing is cut off. The system's own buffers hold a minute of frames: only a
client that answers is known to read."""
_LARGEST_MESSAGE = 1024  # bytes: clients have nothing to say
_SEND_BUFFER = 16384  # bytes: past this a client counts as slow


@dataclass(frozen=True)
class Access:
    """Who may listen.

    Attributes
    ----------
    host : str
        Address to bind to.
    port : int
        0 takes any free one.
    token : str or None
        Must stand in the address (``?token=...``); needed where ``host`` is not the machine itself.
    origins : tuple of str
        Origins of web pages that may connect besides those of this machine, such as ``"http://192.168.0.7:5173"``.

    Raises
    ------
    InputError
        If others could reach it and there is no token.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    token: str | None = None
    origins: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_address(self.host, self.port, self.token)

    def refusal(self, request: Request) -> tuple[http.HTTPStatus, str] | None:
        """Why a request is turned away, or None."""
        given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        if self.token is not None and not secrets.compare_digest(given.encode(), self.token.encode()):
            return http.HTTPStatus.UNAUTHORIZED, "the token is missing or wrong\n"
        origin = request.headers.get("Origin")
        if origin is not None and origin not in self.origins and not is_loopback(urlsplit(origin).hostname or ""):
            return http.HTTPStatus.FORBIDDEN, f"pages of {origin[:100]} may not listen\n"
        return None


@contextlib.asynccontextmanager
async def websocket_stream(
    hub: Hub, greeting: Greeting, access: Access, sound: bytes | None = None
) -> AsyncIterator[int]:
    """Serve a hub's frames over WebSocket while the context lasts; gives the port.

    A ``sound`` (a WAV file) is answered to ``GET /sound.wav`` on the same port, to whom may listen.

    Raises
    ------
    OutputError
        If the address cannot be bound to.
    """

    async def attend(client: ServerConnection) -> None:
        with contextlib.suppress(ConnectionClosed, TimeoutError):
            await _attend(client, hub, greeting)

    def admit(client: ServerConnection, request: Request) -> Response | None:
        if len(hub) >= MOST_CLIENTS:
            return client.respond(http.HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_CLIENTS} clients listen already\n")
        refused = access.refusal(request)
        if refused:
            return client.respond(*refused)
        if sound is not None and urlsplit(request.path).path == SOUND:
            return _sounding(sound, request.headers.get("Origin"))
        return None

    try:
        server: Server = await serve(
            attend,
            access.host,
            access.port,
            process_request=admit,
            max_size=_LARGEST_MESSAGE,
            write_limit=_SEND_BUFFER,
            compression=None,
            open_timeout=PATIENCE,
            ping_interval=PATIENCE / 10,  # a stalled client is asked, given up and cut off within the patience
            ping_timeout=PATIENCE / 2,
            close_timeout=PATIENCE / 10,
        )
    except OSError as problem:
        raise OutputError(f"cannot listen on {access.host}:{access.port}: {problem.strerror or problem}") from problem
    try:
        yield next(iter(server.sockets)).getsockname()[1]
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE):
                await hub.empty()  # whoever still listens gets the last frames and the goodbye
    finally:
        server.close()
        await server.wait_closed()


def _sounding(sound: bytes, origin: str | None) -> Response:
    headers = Headers({"Content-Type": "audio/wav", "Content-Length": str(len(sound)), "Connection": "close"})
    if origin is not None:
        headers["Access-Control-Allow-Origin"] = origin
    return Response(200, "OK", headers, sound)


async def _attend(client: ServerConnection, hub: Hub, greeting: Greeting) -> None:
    """Greet, then hand on frames until the stream or the client ends."""
    listener = hub.join()
    await asyncio.wait_for(client.send(greeting.encode(hub.began)), PATIENCE)
    hearing = asyncio.create_task(_hear(client, listener))
    try:
        while (frame := await listener.get()) is not None:
            await asyncio.wait_for(client.send(frame if isinstance(frame, str) else encode_frame(frame)), PATIENCE)
        await asyncio.wait_for(client.send(END), PATIENCE)
    finally:
        hub.leave(listener)
        hearing.cancel()


async def _hear(client: ServerConnection, listener: Listener) -> None:
    """Read what a client sends and forget it, so that its pings and its goodbye are seen."""
    with contextlib.suppress(ConnectionClosed):
        async for _ in client:
            pass
    listener.end()
