"""The deformation editor's part of the HTTP interface."""

from __future__ import annotations

import asyncio
import json

from aiohttp import web

from mien.serve.studio.bodies import read_bytes, read_json
from mien.serve.studio.requests import FieldError
from mien.serve.studio.workshop import Workshop

__all__ = ["RigRoutes"]


class RigRoutes:
    """The handlers of parameter trees.

    Parameters
    ----------
    workshop : Workshop
    """

    def __init__(self, workshop: Workshop) -> None:
        self.rigs, self.limits = workshop.rigs, workshop.limits
        self._turn = asyncio.Semaphore(self.limits.workers)  # reading a tree of 10 MB takes seconds

    def add_to(self, app: web.Application) -> None:
        """Add all routes to an application."""
        app.add_routes(
            [
                web.get("/api/rigs/{id}.txt", self.text),
                web.get("/api/rigs/{id}", self.rig),
                web.get("/api/rigs/{id}/mesh", self.mesh),
                web.get("/api/rigs/{id}/influence", self.influence),
                web.post("/api/rigs/check", self.check),
                web.post("/api/rigs/{id}/pose", self.pose),
                web.post("/api/rigs", self.open),
                web.put("/api/rigs/{id}", self.save),
            ]
        )

    async def rig(self, request: web.Request) -> web.Response:
        """A configuration as data, with the parts of the face."""
        name = request.match_info["id"]
        async with self._turn:
            content = await asyncio.to_thread(lambda: self.rigs.get(name).content)
            parts = await asyncio.to_thread(lambda: self.rigs.parts)
        body = b'{"rig":%s,"parts":%s,"config":%s}' % (_json(name), _json(parts), content)
        return web.Response(body=body, content_type="application/json")

    async def text(self, request: web.Request) -> web.Response:
        """A configuration as its file."""
        async with self._turn:
            rig = await asyncio.to_thread(self.rigs.get, request.match_info["id"])
        headers = {"Content-Disposition": 'attachment; filename="rig.tree"'}
        return web.Response(text=rig.text, content_type="text/plain", charset="utf-8", headers=headers)

    async def influence(self, request: web.Request) -> web.Response:
        """What every parameter moves, vertex by vertex."""
        async with self._turn:
            content = await asyncio.to_thread(lambda: _json(self.rigs.influence(request.match_info["id"])))
        return web.Response(body=content, content_type="application/json")

    async def mesh(self, request: web.Request) -> web.Response:
        """The face that the trees move, at rest."""
        content = await asyncio.to_thread(lambda: self.rigs.mesh)
        return web.Response(body=content, content_type="application/json")

    async def check(self, request: web.Request) -> web.Response:
        """The faults of a configuration."""
        asked = await read_json(request, self.limits, self.limits.upload_bytes)
        async with self._turn:
            faults = await asyncio.to_thread(self.rigs.check, asked.get("config"))
        return web.json_response({"ok": not faults, "faults": faults})

    async def save(self, request: web.Request) -> web.Response:
        """Keep a configuration."""
        asked = await read_json(request, self.limits, self.limits.upload_bytes)
        async with self._turn:
            name = await asyncio.to_thread(self.rigs.save, request.match_info["id"], asked.get("config"))
        return web.json_response({"rig": name, "file": f"/api/rigs/{name}.txt"})

    async def open(self, request: web.Request) -> web.Response:
        """Read a configuration file of the user's."""
        content = await read_bytes(request, self.limits)
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as problem:
            raise FieldError("body", f"expected a .tree file, UTF-8 text; byte {problem.start} is not") from problem
        async with self._turn:
            name, rig = await asyncio.to_thread(self.rigs.open, text)
            content = await asyncio.to_thread(lambda: rig.content)
        return web.Response(body=b'{"rig":%s,"config":%s}' % (_json(name), content), content_type="application/json")

    async def pose(self, request: web.Request) -> web.Response:
        """Vertices under parameter values."""
        asked = await read_json(request, self.limits)
        async with self._turn:
            content = await asyncio.to_thread(self.rigs.posed, request.match_info["id"], asked.get("values"))
        return web.Response(body=content, content_type="application/octet-stream")


def _json(value: object) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()
