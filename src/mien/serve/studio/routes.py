"""The studio's HTTP interface (``docs/studio.md``): requests in, the workshop's answers out."""

from __future__ import annotations

import asyncio
import json
from urllib.parse import quote

from aiohttp import web

from mien.animation.edits import plain_layer
from mien.core.errors import InputError
from mien.formats.textgrid import read_textgrid
from mien.serve.studio.about import about
from mien.serve.studio.access import HEADERS
from mien.serve.studio.bodies import read_bytes, read_form, read_json
from mien.serve.studio.lru_store import new_id
from mien.serve.studio.packing import packed
from mien.serve.studio.page import MISSING, load_page, media_type
from mien.serve.studio.requests import FieldError, TakeRequest, checked_layer
from mien.serve.studio.results import checked_formats
from mien.serve.studio.studio_takes import Take
from mien.serve.studio.take_sounds import read_sound
from mien.serve.studio.views import Shown
from mien.serve.studio.workshop import Workshop

__all__ = ["Routes"]

_PIECE = 2**18
_MOST_ADDED = 64
_LONGEST_WAIT, _LOOK = 5.0, 0.02  # seconds


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
                web.get("/api/faces/{id}.jpg", self.picture),
                web.put("/api/faces/{id}.jpg", self.keep_picture),
                web.get("/api/faces/{id}/folds", self.folds),
                web.post("/api/faces", self.add_face),
                web.get("/api/faces", self.faces),
                web.get("/api/expressions", self.expressions),
                web.post("/api/takes", self.add_take),
                web.get("/api/takes", self.takes),
                web.get("/api/takes/{id}", self.take),
                web.delete("/api/takes/{id}", self.drop),
                web.post("/api/takes/{id}/open", self.open),
                web.post("/api/takes/{id}/copy", self.copy),
                web.put("/api/takes/{id}/name", self.rename),
                web.get("/api/takes/{id}/steps", self.history),
                web.put("/api/takes/{id}/steps", self.steps),
                web.get("/api/takes/{id}/frames", self.frames),
                web.get("/api/takes/{id}/sound.wav", self.sound),
                web.put("/api/takes/{id}/edits", self.edit),
                web.get("/api/takes/{id}/layer", self.layer),
                web.put("/api/takes/{id}/layer", self.edit),
                web.post("/api/takes/{id}/redo", self.redo),
                web.post("/api/takes/{id}/trial", self.trial),
                web.post("/api/takes/{id}/export", self.export),
                web.post("/api/takes/{id}/textgrid", self.textgrid),
                web.post("/api/ahead", self.ahead),
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
        answer = await packed(request, self._page[path], media_type(path), headers)
        if path.startswith("assets/basis_worker-"):  # its library makes functions out of text; it reads nothing else
            answer.headers["Content-Security-Policy"] = (
                "default-src 'none'; script-src 'unsafe-eval' 'wasm-unsafe-eval'"
            )
        return answer

    async def about(self, request: web.Request) -> web.Response:
        """What this studio offers."""
        return web.json_response(await asyncio.to_thread(about, self.limits))

    # ------------------------------------------------------------ faces

    async def face(self, request: web.Request) -> web.Response:
        """A face as GLB; a browser that has it already is told so."""
        content = await asyncio.to_thread(self.shop.faces.glb, request.match_info["id"])
        return await packed(request, content, "model/gltf-binary", {"Cache-Control": "no-cache"})

    async def picture(self, request: web.Request) -> web.Response:
        """A small picture of a face."""
        content = await asyncio.to_thread(self.shop.faces.picture, request.match_info["id"])
        return await packed(request, content, "image/jpeg", {"Cache-Control": "no-cache"})

    async def keep_picture(self, request: web.Request) -> web.Response:
        """Keep the picture that a page has drawn of an uploaded face."""
        content = await read_bytes(request, self.limits, self.limits.json_bytes)
        await asyncio.to_thread(self.shop.faces.keep_picture, request.match_info["id"], content)
        return web.json_response({})

    async def folds(self, request: web.Request) -> web.Response:
        """The folds of a face's skin; {} where it has none."""
        told = await asyncio.to_thread(self.shop.faces.folds, request.match_info["id"])
        return await packed(request, json.dumps(told).encode(), "application/json", {"Cache-Control": "no-cache"})

    async def add_face(self, request: web.Request) -> web.Response:
        """Keep a GLB of the user's."""
        content = await read_bytes(request, self.limits)
        called = request.query.get("name", "")[:200]
        name, face = await asyncio.to_thread(self.shop.faces.add, content, called)
        return web.json_response({"face": name, "name": face.name, "report": face.report}, status=201)

    async def faces(self, request: web.Request) -> web.Response:
        """The faces that can be shown: those of the cast, then those that were opened."""
        return web.json_response({"faces": await asyncio.to_thread(self.shop.faces.listed)})

    async def expressions(self, request: web.Request) -> web.Response:
        """What every emotion does to a silent face."""
        return web.json_response(
            await asyncio.to_thread(self.shop.expressions, request.query.get("performer", "default"))
        )

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

    async def takes(self, request: web.Request) -> web.Response:
        """All takes that are kept."""
        return web.json_response({"takes": self.shop.listed()})

    async def _take(self, request: web.Request) -> tuple[str, Take]:
        name = request.match_info["id"]
        return name, await asyncio.to_thread(self.shop.take, name)

    async def take(self, request: web.Request) -> web.Response:
        """A take but for its frames and its sound."""
        return web.json_response(await asyncio.to_thread(self.shop.plain, request.match_info["id"]))

    async def open(self, request: web.Request) -> web.Response:
        """Bring a take back that only the journal has."""
        return _accepted(self.shop.start_open(request.match_info["id"]))

    async def drop(self, request: web.Request) -> web.Response:
        """Delete a take."""
        await asyncio.to_thread(self.shop.drop, request.match_info["id"])
        return web.json_response({})

    async def copy(self, request: web.Request) -> web.Response:
        """Another take like one."""
        return web.json_response(
            {"take": await asyncio.to_thread(self.shop.copy, request.match_info["id"])}, status=201
        )

    async def rename(self, request: web.Request) -> web.Response:
        """Give a take another name."""
        asked = await read_json(request, self.limits)
        record = await asyncio.to_thread(self.shop.journal.rename, request.match_info["id"], asked.get("name"))
        return web.json_response({"name": record.name})

    async def history(self, request: web.Request) -> web.Response:
        """All steps of a take, as undo and redo know them."""
        record = self.shop.journal.get(request.match_info["id"])
        return web.json_response(await asyncio.to_thread(record.plain))

    async def steps(self, request: web.Request) -> web.Response:
        """Change them: edits, undo, redo."""
        asked = await read_json(request, self.limits, self.limits.upload_bytes)
        numbers, add = [asked.get(name) for name in ("keep", "at", "count")], asked.get("add", [])
        keep, at, count = (one if type(one) is int else -1 for one in numbers)
        if min(keep, at, count) < 0 or not isinstance(add, list) or len(add) > _MOST_ADDED:
            raise FieldError(
                "steps", 'expected {"keep": N, "add": [layers], "at": N, "count": N}, at most 64 layers at once'
            )
        layers = [checked_layer(layer, self.limits) for layer in add]
        name = request.match_info["id"]
        async with self._turn:
            told = await asyncio.to_thread(self.shop.steps, name, keep, layers, at, count)
        return web.json_response(told, status=202 if "job" in told else 200)

    async def frames(self, request: web.Request) -> web.Response:
        """All frames, float32."""
        _, take = await self._take(request)
        kind = next((kind for kind in ("neutral", "plain") if kind in request.query), "")
        async with self._turn:
            revision, content = await asyncio.to_thread(take.frames, kind)
        headers = {"X-Mien-Revision": str(revision), "Cache-Control": "no-cache"}
        return await packed(request, content, "application/octet-stream", headers)

    async def sound(self, request: web.Request) -> web.Response:
        """The sound, 24-bit WAV; parts of it where a player asks for them."""
        _, take = await self._take(request)
        content = await asyncio.to_thread(take.sound)
        return _ranged(request, content, "audio/wav")

    async def edit(self, request: web.Request) -> web.Response:
        """Put a layer of edits on the take."""
        name = request.match_info["id"]
        layer = checked_layer(await read_json(request, self.limits), self.limits)
        async with self._turn:
            revision, changed = await asyncio.to_thread(self.shop.edit, name, layer)
        told = self.shop.plain(name)
        return web.json_response(
            {"revision": revision, "frames_changed": changed, "lost": told["lost"], "take": told},
        )

    async def layer(self, request: web.Request) -> web.Response:
        """The edits as a file of their own."""
        _, take = await self._take(request)
        headers = {"Content-Disposition": 'attachment; filename="edits.json"'}
        return web.json_response(plain_layer(take.layer), headers=headers)

    async def redo(self, request: web.Request) -> web.Response:
        """Perform the line again with some fields changed, or over another sound; the edits are laid over it again."""
        name = request.match_info["id"]
        if request.content_type.startswith("multipart/"):
            fields, content, _ = await read_form(request, self.limits)
            if content is None:
                raise FieldError("sound", "expected a file 'sound' in the form")
            sound = await asyncio.to_thread(read_sound, content, self.shop.folder, self.limits)
            return _accepted(self.shop.start_redo(name, fields, sound))
        return _accepted(self.shop.start_redo(name, await read_json(request, self.limits)))

    async def trial(self, request: web.Request) -> web.Response:
        """Perform the line with some fields changed, to be heard and seen only: nothing of it is kept."""
        return _accepted(self.shop.start_trial(request.match_info["id"], await read_json(request, self.limits)))

    async def textgrid(self, request: web.Request) -> web.Response:
        """Perform the line with the words and phones of a TextGrid, the body."""
        content, path = await read_bytes(request, self.limits, self.limits.json_bytes), self.shop.folder / new_id()
        try:
            await asyncio.to_thread(path.write_bytes, content)
            tiers = await asyncio.to_thread(read_textgrid, path)
        except InputError as problem:
            raise FieldError("sound", str(problem).replace(str(path), "the file")) from problem
        finally:
            path.unlink(missing_ok=True)
        return _accepted(await asyncio.to_thread(self.shop.start_times, request.match_info["id"], tiers))

    async def ahead(self, request: web.Request) -> web.Response:
        """Make ready what is being written, if nothing else is being made."""
        asked = TakeRequest.of(await read_json(request, self.limits), self.limits)
        await asyncio.to_thread(self.shop.ahead, asked)
        return web.json_response({}, status=202)

    async def export(self, request: web.Request) -> web.Response:
        """Write the take into files."""
        name = request.match_info["id"]
        asked = await read_json(request, self.limits)
        formats = checked_formats(asked.get("formats"))
        return _accepted(await asyncio.to_thread(self.shop.start_export, name, formats, Shown.of(asked)))

    # ------------------------------------------------------------ jobs and files

    async def job(self, request: web.Request) -> web.Response:
        """How far a job is; with ``?wait=SECONDS`` as soon as it is farther, or after that time."""
        job, clock = self.shop.jobs.get(request.match_info["id"]), asyncio.get_running_loop()
        try:
            wait = min(float(request.query.get("wait", 0)), _LONGEST_WAIT)
        except ValueError as problem:
            raise FieldError("wait", "expected seconds") from problem
        before, until = job.plain(), clock.time() + wait
        while not job.over and job.plain() == before and clock.time() < until:
            await asyncio.sleep(_LOOK)
        return web.json_response(job.plain())

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
