"""Answers as browsers like them: compressed where that pays, and not sent again where nothing has changed."""

from __future__ import annotations

import asyncio
import gzip
from collections import OrderedDict
from hashlib import sha256
from threading import Lock

from aiohttp import web

__all__ = ["packed"]

_LEAST = 1024
_MOST_KEPT = 2**26
_compressed: OrderedDict[str, bytes] = OrderedDict()
_lock = Lock()


async def packed(request: web.Request, content: bytes, kind: str, headers: dict[str, str]) -> web.Response:
    """An answer with an ETag, gzip where the client takes it; 304 if the client has it."""
    tag = await asyncio.to_thread(_digest, content)
    headers = {**headers, "ETag": f'"{tag}"', "Vary": "Accept-Encoding"}
    if f'"{tag}"' in request.headers.get("If-None-Match", ""):
        return web.Response(status=304, headers=headers)
    if len(content) >= _LEAST and "gzip" in request.headers.get("Accept-Encoding", "").lower():
        content = await asyncio.to_thread(_gzip, tag, content)
        headers["Content-Encoding"] = "gzip"
    return web.Response(body=content, content_type=kind, headers=headers)


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()[:24]


def _gzip(tag: str, content: bytes) -> bytes:
    with _lock:
        if tag in _compressed:
            _compressed.move_to_end(tag)
            return _compressed[tag]
    made = gzip.compress(content, 6 if len(content) < 2**23 else 1, mtime=0)
    with _lock:
        _compressed[tag] = made
        while sum(map(len, _compressed.values())) > _MOST_KEPT and len(_compressed) > 1:
            _compressed.popitem(last=False)
    return made
