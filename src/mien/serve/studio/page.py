"""The built page, read whole when the studio starts, so that no path of a client's reaches the file system."""

from __future__ import annotations

import mimetypes
from collections.abc import Iterator
from pathlib import Path

from mien.core.assets import asset

__all__ = ["MISSING", "load_page", "media_type"]

MISSING = """<!doctype html><meta charset="utf-8"><title>mien studio</title>
<h1>The studio's page is not in this installation</h1>
<p>The server works (<a href="/api/about">/api/about</a>), but <code>mien/assets/studio/index.html</code> is missing.
In a clone, build it with <code>make page</code> (wants Node); from a wheel, install mien again.</p>
"""
_TYPES = {
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".css": "text/css",
    ".html": "text/html",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
    ".woff2": "font/woff2",
    ".json": "application/json",
    ".webmanifest": "application/manifest+json",
    ".glb": "model/gltf-binary",
    ".wav": "audio/wav",
    ".mp4": "video/mp4",
    ".csv": "text/csv",
    ".zip": "application/zip",
    ".textgrid": "text/plain",
    ".fap": "text/plain",
}


def media_type(name: str) -> str:
    """The media type of a file name; the machine's own tables are asked last.

    Examples
    --------
    >>> media_type("index.JS"), media_type("a.unknown")
    ('text/javascript', 'application/octet-stream')
    """
    suffix = "." + name.rpartition(".")[2].lower()
    return _TYPES.get(suffix) or mimetypes.guess_type(name)[0] or "application/octet-stream"


def load_page() -> dict[str, bytes]:
    """Every file of the built page by its path under the root, such as ``"assets/index-1a2b.js"``; empty if missing."""
    root = asset("studio")
    return dict(_files(root, "")) if root.is_dir() else {}


def _files(folder: Path, path: str) -> Iterator[tuple[str, bytes]]:
    for item in folder.iterdir():
        if item.is_dir():
            yield from _files(item, f"{path}{item.name}/")
        elif item.is_file():
            yield f"{path}{item.name}", item.read_bytes()
