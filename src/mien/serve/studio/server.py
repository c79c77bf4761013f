"""The studio's server: one application over one workshop, guarded, and stopped cleanly."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Awaitable, Callable

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from mien.core.errors import MienError, OutputError
from mien.serve.studio.access import HEADERS, Gate
from mien.serve.studio.bodies import TooLarge
from mien.serve.studio.head_routes import HeadRoutes
from mien.serve.studio.jobs import Busy
from mien.serve.studio.live_routes import LiveRoutes
from mien.serve.studio.lru_store import Missing
from mien.serve.studio.owner_watch import Watch
from mien.serve.studio.project_routes import ProjectRoutes
from mien.serve.studio.rig_routes import RigRoutes
from mien.serve.studio.routes import Routes
from mien.serve.studio.settings import StudioSettings
from mien.serve.studio.workshop import Changed, Workshop

__all__ = ["WATCH", "application", "running_studio"]

WATCH = web.AppKey("watch", Watch)

_log = logging.getLogger("mien.serve.studio")
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def application(settings: StudioSettings, workshop: Workshop) -> web.Application:
    """The studio as an aiohttp application."""
    gate, watch = Gate(settings), Watch(settings.limits)

    @web.middleware
    async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
        refused = gate.refusal(request)
        if refused is not None:
            return refused
        with watch.answering(request):
            answer = await _answered(request, handler)
        if not answer.prepared:
            answer.headers.update({name: value for name, value in HEADERS.items() if name not in answer.headers})
        return answer

    app = web.Application(middlewares=[guard], client_max_size=settings.limits.upload_bytes)
    app[WATCH] = watch
    Routes(workshop).add_to(app)
    RigRoutes(workshop).add_to(app)
    ProjectRoutes(workshop).add_to(app)
    LiveRoutes(workshop).add_to(app)
    HeadRoutes(workshop).add_to(app)
    return app


async def _answered(request: web.Request, handler: Handler) -> web.StreamResponse:
    """A handler's answer, or its error as JSON."""
    try:
        return await handler(request)
    except Missing as problem:
        return _told(404, str(problem))
    except Changed as problem:
        return _told(409, str(problem))
    except Busy as problem:
        return _told(429, str(problem))
    except TooLarge as problem:
        return _closing(_told(413, str(problem), problem.field))
    except MienError as problem:
        return _told(400, " ".join(str(problem).split()), getattr(problem, "field", None))
    except TimeoutError:
        return _closing(_told(408, "the request did not arrive in time"))
    except web.HTTPException as problem:
        return _told(problem.status, problem.reason if problem.text is None else problem.text.strip())
    except (ConnectionError, asyncio.CancelledError):
        raise
    except Exception as problem:  # a fault of ours: told, logged, and the server goes on
        _log.exception("%s %s failed", request.method, request.path)
        return _told(500, f"the studio itself failed ({type(problem).__name__}); its terminal has the details")


def _told(status: int, message: str, field: str | None = None) -> web.Response:
    return web.json_response({"error": message, "field": field}, status=status)


def _closing(answer: web.Response) -> web.Response:
    answer.force_close()
    return answer


def _is_ours(record: logging.LogRecord) -> bool:
    """Whether a fault is the studio's, not that of a request which cannot be read."""
    return not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError | ConnectionError))


@contextlib.asynccontextmanager
async def running_studio(settings: StudioSettings, workshop: Workshop) -> AsyncIterator[int]:
    """Serve while the context lasts; gives the port.

    Raises
    ------
    OutputError
        If the address cannot be bound to.
    """
    app = application(settings, workshop)
    logging.getLogger("aiohttp.server").addFilter(_is_ours)  # what strangers send in wrong is answered, not told here
    runner = web.AppRunner(app, access_log=None, keepalive_timeout=30, shutdown_timeout=1, auto_decompress=False)
    await runner.setup()
    server, watch, loop = runner.server, app[WATCH], asyncio.get_running_loop()
    assert server is not None
    try:
        listening = await loop.create_server(lambda: watch.protocol(server), settings.host, settings.port)
    except (OSError, UnicodeError) as problem:
        await runner.cleanup()
        told = getattr(problem, "strerror", None) or str(problem)
        raise OutputError(
            f"cannot listen on {settings.host}:{settings.port}: {told}; another --port may be free"
        ) from problem
    sweeping = loop.create_task(watch.sweep(server))
    try:
        yield listening.sockets[0].getsockname()[1]
    finally:
        sweeping.cancel()
        listening.close()
        server.pre_shutdown()
        await runner.cleanup()
