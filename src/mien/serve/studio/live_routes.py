"""The live output's part of the HTTP interface: what the page shows, sent to an engine."""

from __future__ import annotations

from aiohttp import web

from mien.serve.studio.bodies import read_json
from mien.serve.studio.live_out import LiveOut
from mien.serve.studio.workshop import Workshop

__all__ = ["LiveRoutes"]


class LiveRoutes:
    """The handlers of the live output.

    Parameters
    ----------
    workshop : Workshop
    """

    def __init__(self, workshop: Workshop) -> None:
        self.out, self.limits = LiveOut(workshop), workshop.limits

    def add_to(self, app: web.Application) -> None:
        """Add all routes to an application."""
        app.add_routes(
            [
                web.get("/api/live", self.state),
                web.post("/api/live", self.start),
                web.put("/api/live", self.show),
                web.delete("/api/live", self.stop),
            ]
        )
        app.on_cleanup.append(self._end)

    async def state(self, request: web.Request) -> web.Response:
        """Whether and where to it sends."""
        return web.json_response(self.out.plain())

    async def start(self, request: web.Request) -> web.Response:
        """Begin to send."""
        await self.out.start(await read_json(request, self.limits))
        return web.json_response(self.out.plain())

    async def show(self, request: web.Request) -> web.Response:
        """What the page shows from now on."""
        self.out.show(await read_json(request, self.limits))
        return web.json_response({})

    async def stop(self, request: web.Request) -> web.Response:
        """Send no more."""
        await self.out.stop()
        return web.json_response(self.out.plain())

    async def _end(self, app: web.Application) -> None:
        await self.out.stop()
