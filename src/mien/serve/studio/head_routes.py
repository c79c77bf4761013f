"""The HTTP interface to heads that wait for shapes."""

from __future__ import annotations

import asyncio
from typing import Any

from aiohttp import web

from mien.serve.studio.bodies import read_bytes, read_json
from mien.serve.studio.heads import HeadShelf
from mien.serve.studio.jobs import Job
from mien.serve.studio.packing import packed
from mien.serve.studio.workshop import Workshop

__all__ = ["HeadRoutes"]


class HeadRoutes:
    """The handlers of heads.

    Parameters
    ----------
    workshop : Workshop
    """

    def __init__(self, workshop: Workshop) -> None:
        self.shop, self.heads = workshop, HeadShelf(workshop.folder, workshop.faces)

    def add_to(self, app: web.Application) -> None:
        """Add all routes to an application."""
        app.add_routes(
            [
                web.post("/api/heads", self.open),
                web.get("/api/heads/{id}", self.head),
                web.post("/api/heads/{id}/fit", self.fit),
            ]
        )

    async def open(self, request: web.Request) -> web.Response:
        """Look for the face in a GLB; the job's ``head`` is its id."""
        content, name = await read_bytes(request, self.shop.limits), request.query.get("name", "head.glb")[:200]

        def work(job: Job) -> dict[str, Any]:
            return {"head": self.heads.open(content, name, job)}

        return web.json_response({"job": self.shop.jobs.start(work)}, status=202)

    async def head(self, request: web.Request) -> web.Response:
        """Its mesh and its landmarks."""
        content = await asyncio.to_thread(self.heads.plain, request.match_info["id"])
        return await packed(request, content, "application/json", {"Cache-Control": "no-cache"})

    async def fit(self, request: web.Request) -> web.Response:
        """Give it shapes, with the landmarks that were moved; the job's ``face`` is what it is now."""
        name, asked = request.match_info["id"], await read_json(request, self.shop.limits)

        def work(job: Job) -> dict[str, Any]:
            return {"face": self.heads.fit(name, asked.get("landmarks"), job)}

        return web.json_response({"job": self.shop.jobs.start(work)}, status=202)
