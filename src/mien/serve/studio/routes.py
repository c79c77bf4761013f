"""The studio's HTTP interface (``docs/studio.md``): requests in, the workshop's answers out."""

from __future__ import annotations

import asyncio
import json
from typing import Any
from urllib.parse import quote

from aiohttp import web

from mien.animation.edits import EditLayer, layer_of, plain_layer
from mien.core.errors import InputError
from mien.serve.studio.about import about
from mien.serve.studio.access import HEADERS
from mien.serve.studio.bodies import read_bytes, read_form, read_json
from mien.serve.studio.page import MISSING, load_page, media_type
from mien.serve.studio.requests import FieldError, TakeRequest
from mien.serve.studio.results import checked_formats
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_takes import Take
from mien.serve.studio.take_sounds import read_sound
from mien.serve.studio.views import Shown
from mien.serve.studio.workshop import Workshop

__all__ = ["Routes"]

_PIECE = 2**18


class Routes:
    """The handlers of one studio.

    Parameters
    ----------
    workshop : Workshop
    """

    def __init__(self, workshop: Workshop) -> None:
        self.shop, self.limits = workshop, workshop.limits
        self._page = load_page()
        self._turn = asyncio.Semaphore(self.limits.workers)  # what is quick, but not nothing

    def add_to(self, app: web.Application) -> None:
        """Add all routes to an application."""
        app.add_routes(
            [
                web.get("/", self.index),
                web.get("/assets/{name:.+}", self.asset),
                web.get("/api/about", self.about),
                web.get("/api/faces/{id}.glb", self.face),
                web.post("/api/faces", self.add_face),
                web.post("/api/takes", self.add_take),
                web.get("/api/takes/{id}", self.take),
                web.get("/api/takes/{id}/frames", self.frames),
                web.get("/api/takes/{id}/sound.wav", self.sound),
                web.put("/api/takes/{id}/edits", self.edit),
                web.get("/api/takes/{id}/layer", self.layer),
                web.put("/api/takes/{id}/layer", self.edit),
                web.post("/api/takes/{id}/redo", self.redo),
                web.post("/api/takes/{id}/export", self.export),
                web.get("/api/jobs/{id}", self.job),
                web.delete("/api/jobs/{id}", self.cancel),
                web.get("/api/files/{id}/{name}", self.file),
            ]
        )

    # ------------------------------------------------------------ the page

    async def index(self, request: web.Request) -> web.Response:
        """The page, or one that says that it is missing."""
        content = self._page.get("index.html")
        if content is None:
            return web.Response(status=503, text=MISSING, content_type="text/html")
        return web.Response(
            body=content, content_type="text/html", charset="utf-8", headers={"Cache-Control": "no-cache"}
        )

    async def asset(self, request: web.Request) -> web.Response:
        """A file of the page."""
        path = f"assets/{request.match_info['name']}"
        if path not in self._page:
            raise web.HTTPNotFound(text="the page has no such file")
        headers = {"Cache-Control": "max-age=31536000, immutable"}  # the name holds a hash of the content
        return web.Response(body=self._page[path], content_type=media_type(path), headers=headers)

    async def about(self, request: web.Request) -> web.Response:
        """What this studio offers."""
        return web.json_response(await asyncio.to_thread(about, self.limits))

    # ------------------------------------------------------------ faces

    async def face(self, request: web.Request) -> web.Response:
        """A face as GLB."""
        content = await asyncio.to_thread(self.shop.faces.glb, request.match_info["id"])
        return web.Response(body=content, content_type="model/gltf-binary")

    async def add_face(self, request: web.Request) -> web.Response:
        """Keep a GLB of the user's."""
        content = await read_bytes(request, self.limits)
        name, face = await asyncio.to_thread(self.shop.faces.add, content)
        return web.json_response({"face": name, "report": face.report}, status=201)

    # ------------------------------------------------------------ takes

    async def add_take(self, request: web.Request) -> web.Response:
        """Perform a line; JSON, or a form with a sound."""
        if request.content_type.startswith("multipart/"):
            fields, content, _ = await read_form(request, self.limits)
            if content is None:
                raise FieldError("sound", "expected a file 'sound' in the form")
            asked = TakeRequest.of(fields, self.limits, with_sound=True)
            sound, notes = await asyncio.to_thread(read_sound, content, self.shop.folder, self.limits)
            return _accepted(self.shop.start_take(asked, sound, notes))
        asked = TakeRequest.of(await read_json(request, self.limits), self.limits)
        return _accepted(self.shop.start_take(asked))

    def _take(self, request: web.Request) -> tuple[str, Take]:
        name = request.match_info["id"]
        return name, self.shop.takes.get(name)

    async def take(self, request: web.Request) -> web.Response:
        """A take but for its frames and its sound."""
        name, take = self._take(request)
        return web.json_response(take.plain(name))

    async def frames(self, request: web.Request) -> web.Response:
        """All frames, float32."""
        _, take = self._take(request)
        kind = next((kind for kind in ("neutral", "plain") if kind in request.query), "")
        async with self._turn:
            revision, content = await asyncio.to_thread(take.frames, kind)
        headers = {"X-Mien-Revision": str(revision), "Cache-Control": "no-cache"}
        return web.Response(body=content, content_type="application/octet-stream", headers=headers)

    async def sound(self, request: web.Request) -> web.Response:
        """The sound, 24-bit WAV; parts of it where a player asks for them."""
        _, take = self._take(request)
        content = await asyncio.to_thread(take.sound)
        return _ranged(request, content, "audio/wav")

    async def edit(self, request: web.Request) -> web.Response:
        """Put a layer of edits on the take."""
        name, take = self._take(request)
        layer = checked_layer(await read_json(request, self.limits), self.limits)
        async with self._turn:
            revision, changed = await asyncio.to_thread(self.shop.edit, name, layer)
        told = take.plain(name)
        return web.json_response(
            {"revision": revision, "frames_changed": changed, "lost": told["lost"], "take": told},
        )

    async def layer(self, request: web.Request) -> web.Response:
        """The edits as a file of their own."""
        _, take = self._take(request)
        headers = {"Content-Disposition": 'attachment; filename="edits.json"'}
        return web.json_response(plain_layer(take.layer), headers=headers)

    async def redo(self, request: web.Request) -> web.Response:
        """Perform the line again with some fields changed; the edits are laid over it again."""
        name, _ = self._take(request)
        return _accepted(self.shop.start_redo(name, await read_json(request, self.limits)))

    async def export(self, request: web.Request) -> web.Response:
        """Write the take into files."""
        name, _ = self._take(request)
        asked = await read_json(request, self.limits)
        formats = checked_formats(asked.get("formats"))
        return _accepted(self.shop.start_export(name, formats, Shown.of(asked)))

    # ------------------------------------------------------------ jobs and files

    async def job(self, request: web.Request) -> web.Response:
        """How far a job is."""
        return web.json_response(self.shop.jobs.get(request.match_info["id"]).plain())

    async def cancel(self, request: web.Request) -> web.Response:
        """Cancel a job."""
        job = self.shop.jobs.get(request.match_info["id"])
        job.cancel()
        return web.json_response(job.plain())

    async def file(self, request: web.Request) -> web.StreamResponse:
        """A result; the name in the address is for the browser alone, the id finds the file."""
        found = self.shop.results.get(request.match_info["id"])
        answer = web.StreamResponse(
            headers={
                "Content-Disposition": f"attachment; filename=\"{found.name}\"; filename*=UTF-8''{quote(found.name)}",
                "Content-Type": media_type(found.name),
                **HEADERS,
            }
        )
        with await asyncio.to_thread(found.path.open, "rb") as file:
            answer.content_length = found.path.stat().st_size
            await answer.prepare(request)
            while piece := await asyncio.to_thread(file.read, _PIECE):
                async with asyncio.timeout(self.limits.request_seconds):
                    await answer.write(piece)
        await answer.write_eof()
        return answer


def checked_layer(document: dict[str, Any], limits: Limits) -> EditLayer:
    """Read a layer from JSON; a bare ``{"edits": [...]}`` counts as one of this version.

    Raises
    ------
    FieldError
        If it does not hold together, or is larger than the studio takes.
    """
    document = (
        {"format": "mien-edits", "version": 1, **document.get("layer", document)}
        if isinstance(document.get("layer", document), dict)
        else document
    )
    try:
        layer = layer_of(document)
    except InputError as problem:
        raise FieldError("edits", str(problem)) from problem
    points = sum(len(edit.points) for _, edit in layer.intensities) + sum(len(edit.keys) for _, edit in layer.curves)
    if len(layer.edits) + points > limits.edits or len(layer.line or ()) > limits.text_characters:
        raise FieldError("edits", f"the studio takes at most {limits.edits} edits and points, got more")
    return layer


def _accepted(job: str) -> web.Response:
    return web.Response(status=202, text=json.dumps({"job": job}), content_type="application/json")


def _ranged(request: web.Request, content: bytes, kind: str) -> web.Response:
    """Bytes, or the part of them that the header Range asks for."""
    headers = {"Accept-Ranges": "bytes"}
    if "Range" not in request.headers:
        return web.Response(body=content, content_type=kind, headers=headers)
    try:
        first, end, _ = request.http_range.indices(len(content))
    except ValueError:
        first, end = len(content), 0
    if first >= end:
        headers["Content-Range"] = f"bytes */{len(content)}"
        return web.Response(status=416, headers=headers)
    headers["Content-Range"] = f"bytes {first}-{end - 1}/{len(content)}"
    return web.Response(status=206, body=content[first:end], content_type=kind, headers=headers)
