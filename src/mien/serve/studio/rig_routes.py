"""The deformation editor's part of the HTTP interface."""

from __future__ import annotations

import asyncio
import json

from aiohttp import web

from mien.serve.studio.bodies import read_bytes, read_json
from mien.serve.studio.packing import packed
from mien.serve.studio.requests import FieldError
from mien.serve.studio.studio_faces import DEFAULT_FACE
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
        """A configuration as data, and whose it is."""
        name = request.match_info["id"]
        async with self._turn:
            rig = await asyncio.to_thread(self.rigs.get, name)
        body = b'{"rig":%s,"face":%s,"config":%s}' % (_json(name), _json(rig.face), rig.content)
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
        """The face that a tree moves, at rest."""
        async with self._turn:
            content = await asyncio.to_thread(self.rigs.mesh, request.match_info["id"])
        return await packed(request, content, "application/json", {"Cache-Control": "no-cache"})

    async def check(self, request: web.Request) -> web.Response:
        """The faults of a configuration."""
        asked = await read_json(request, self.limits, self.limits.upload_bytes)
        async with self._turn:
            faults = await asyncio.to_thread(self.rigs.check, asked.get("config"), _face(asked.get("face")))
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
            name, rig = await asyncio.to_thread(self.rigs.open, text, _face(request.query.get("face")))
            content = await asyncio.to_thread(lambda: rig.content)
        return web.Response(body=b'{"rig":%s,"config":%s}' % (_json(name), content), content_type="application/json")

    async def pose(self, request: web.Request) -> web.Response:
        """Vertices under parameter values."""
        asked = await read_json(request, self.limits)
        async with self._turn:
            content = await asyncio.to_thread(self.rigs.posed, request.match_info["id"], asked.get("values"))
        return web.Response(body=content, content_type="application/octet-stream")


def _face(asked: object) -> str:
    return asked if isinstance(asked, str) and asked else DEFAULT_FACE


def _json(value: object) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()
