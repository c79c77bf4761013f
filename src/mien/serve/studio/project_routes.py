"""The page's state, projects as one file, and takes that a page hands back."""

from __future__ import annotations

import asyncio

from aiohttp import web

from mien.serve.studio.bodies import parsed, read_bytes, read_form, read_json
from mien.serve.studio.journal import record_of
from mien.serve.studio.projects import read_project, written_project
from mien.serve.studio.requests import FieldError
from mien.serve.studio.studio_takes import Source
from mien.serve.studio.take_sounds import read_sound
from mien.serve.studio.workshop import Workshop

__all__ = ["ProjectRoutes"]

_MOST_STATE = 2**18


class ProjectRoutes:
    """The handlers of what is kept beyond takes.

    Parameters
    ----------
    workshop : Workshop
    """

    def __init__(self, workshop: Workshop) -> None:
        self.shop, self.limits = workshop, workshop.limits

    def add_to(self, app: web.Application) -> None:
        """Add all routes to an application."""
        app.add_routes(
            [
                web.get("/api/page", self.page),
                web.put("/api/page", self.keep_page),
                web.post("/api/page", self.keep_page),  # as a page sends it that is being closed
                web.get("/api/project", self.project),
                web.post("/api/project", self.open_project),
                web.post("/api/takes/back", self.take_back),
            ]
        )

    async def page(self, request: web.Request) -> web.Response:
        """What the page looked like."""
        return web.json_response(self.shop.journal.page())

    async def keep_page(self, request: web.Request) -> web.Response:
        """Keep what it looks like."""
        await asyncio.to_thread(self.shop.journal.keep_page, await read_json(request, self.limits, _MOST_STATE))
        return web.json_response({})

    async def project(self, request: web.Request) -> web.Response:
        """All takes (or those asked for), with their sounds, faces and what the page looks like, as one file."""
        names = request.query.getall("take", list(self.shop.journal.records))
        content = await asyncio.to_thread(written_project, self.shop.journal, self.shop.faces, names)
        headers = {"Content-Disposition": 'attachment; filename="takes.mienproject"'}
        return web.Response(body=content, content_type="application/zip", headers=headers)

    async def open_project(self, request: web.Request) -> web.Response:
        """Add what a project holds."""
        content = await read_bytes(request, self.limits)
        told = await asyncio.to_thread(read_project, content, self.shop.journal, self.shop.faces, self.limits)
        return web.json_response(told, status=201)

    async def take_back(self, request: web.Request) -> web.Response:
        """Take what a page has that outlived its server: a form with ``take``, ``record`` and maybe ``sound``."""
        fields, content, _ = await read_form(request, self.limits)
        if not isinstance(fields.get("record"), str):
            raise FieldError("record", "expected the steps of a take as JSON")
        record = await asyncio.to_thread(lambda: record_of(parsed(fields["record"].encode()), self.limits))
        name = str(fields.get("take", ""))
        if name in self.shop.journal.records:
            return web.json_response({"take": name})
        if content is not None:
            heard = await asyncio.to_thread(read_sound, content, self.shop.folder, self.limits)
            record = await asyncio.to_thread(self.shop.with_sound, record, Source(*heard))
        return web.json_response({"take": await asyncio.to_thread(self.shop.journal.add, record, name)}, status=201)
