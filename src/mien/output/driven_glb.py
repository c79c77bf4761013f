"""A GLB of any maker, driven: keys are appended, everything else in the file stays as it is.

Only the JSON is edited and the binary chunk extended; no mesh, picture or compressed buffer is decoded.
Source: glTF 2.0 specification, sections 3.11 (animations) and 4.4 (binary container).
"""

from __future__ import annotations

import json
import re
import struct
import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.channels import ARKIT
from mien.errors import InputError
from mien.files import replace_when_complete
from mien.tracks import ChannelTrack

__all__ = ["drive_glb", "read_chunks", "recipe_of_target", "target_names"]

_JSON, _BIN = 0x4E4F534A, 0x004E4942
Recipe = Mapping[str, float]


def read_chunks(path: str | Path) -> tuple[dict[str, Any], list[tuple[int, bytes]]]:
    """The JSON of a GLB and its other chunks, in order."""
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise InputError(f"cannot read {path}: {problem.strerror}") from problem
    if content[:4] != b"glTF" or len(content) < 20:
        raise InputError(f"{path} is not a GLB file: it does not begin with 'glTF' and a chunk")
    _, version, length = struct.unpack_from("<4sII", content)
    if version != 2 or length > len(content):
        raise InputError(f"{path}: glTF 2 of {length} bytes expected, version {version} of {len(content)} bytes came")
    chunks, at = [], 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", content, at)
        if at + 8 + size > length:
            raise InputError(f"{path} is cut off: the chunk at byte {at} should have {size} bytes")
        chunks.append((kind, content[at + 8 : at + 8 + size]))
        at += 8 + size
    try:
        document = json.loads(chunks[0][1]) if chunks and chunks[0][0] == _JSON else None
    except ValueError as problem:
        raise InputError(f"{path}: its JSON cannot be read: {problem}") from problem
    if not isinstance(document, dict):
        raise InputError(f"{path}: the first chunk is not a JSON object")
    return document, chunks[1:]


def target_names(mesh: Mapping[str, Any]) -> list[str]:
    """Names of a mesh's morph targets; without ``extras.targetNames``, empty names."""
    count = len(mesh["primitives"][0].get("targets", []))
    names = mesh.get("extras", {}).get("targetNames")
    names = names or mesh["primitives"][0].get("extras", {}).get("targetNames") or []
    return [str(name) for name in names[:count]] + [""] * (count - len(names))


def recipe_of_target(name: str) -> Recipe:
    """Which channels drive a target of this name, and by how much; empty if the name is not known.

    Examples
    --------
    >>> recipe_of_target("blendShape1.jaw_open")
    {'jawOpen': 1.0}
    >>> recipe_of_target("browDown_L")
    {'browDownLeft': 1.0}
    """
    table = _table()
    short = re.sub(r"_(L|R)$", lambda side: "Left" if side[1] == "L" else "Right", name.rsplit(".", 1)[-1])
    plain = _plain(short)
    for channel in ARKIT:
        if _plain(channel) == plain:
            return {channel: 1.0}
    if plain in ("browinnerupleft", "browinnerupright"):
        return {"browInnerUp": 1.0}
    viseme = re.sub(r"^(viseme|vrcv|fclmth|v)(?=.)", "", plain)
    found: Recipe = table["arkit"].get(plain) or table["visemes"].get(viseme) or {}
    return found


def drive_glb(track: ChannelTrack, source: str | Path, path: str | Path) -> None:
    """Write ``source`` again with the weights of a track as one more animation."""
    if Path(source).resolve() == Path(path).resolve():
        raise InputError(f"{path} is both read and written: give the output another name")
    document, chunks = read_chunks(source)
    keys = _Keys(document, chunks)
    times = keys.add(track.rate.times(len(track)).astype(np.float32), bounds=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    for number, node in enumerate(document.get("nodes", [])):
        values = _weights(track, document, node)
        if values is not None:
            channels.append({"sampler": len(samplers), "target": {"node": number, "path": "weights"}})
            samplers.append({"input": times, "interpolation": "LINEAR", "output": keys.add(values.reshape(-1))})
    if not channels:
        raise InputError(f"{source} has no morph target with a known name (ARKit or viseme): nothing could move")
    document.setdefault("animations", []).append({"name": "mien", "channels": channels, "samplers": samplers})
    content = keys.packed()
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)


def _weights(track: ChannelTrack, document: Mapping[str, Any], node: Mapping[str, Any]) -> NDArray[np.float32] | None:
    if "mesh" not in node:
        return None
    mesh = document["meshes"][node["mesh"]]
    recipes = [recipe_of_target(name) for name in target_names(mesh)]
    if not any(recipes):
        return None
    rest = node.get("weights") or mesh.get("weights") or [0.0] * len(recipes)
    values = np.tile(np.asarray(rest, dtype=np.float32), (len(track), 1))
    for column, recipe in enumerate(recipes):
        if recipe:
            parts = track.select(tuple(recipe)).values @ np.array(list(recipe.values()))
            values[:, column] = np.clip(parts, 0.0, 1.0)
    return values


class _Keys:
    """Appends accessors to a document without touching the bytes that are there."""

    def __init__(self, document: dict[str, Any], chunks: list[tuple[int, bytes]]) -> None:
        self.document, self.others = document, [chunk for chunk in chunks if chunk[0] != _BIN]
        self.data = bytearray(next((data for kind, data in chunks if kind == _BIN), b""))
        buffers = document.setdefault("buffers", [])
        if not any(kind == _BIN for kind, _ in chunks):
            if buffers:
                raise InputError("the GLB keeps its buffers outside the file: pack them into it first")
            buffers.append({"byteLength": 0})

    def add(self, values: NDArray[np.float32], bounds: bool = False) -> int:
        self.data += bytes(-len(self.data) % 4)
        views = self.document.setdefault("bufferViews", [])
        accessors = self.document.setdefault("accessors", [])
        views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.astype("<f4").tobytes()
        accessor = {"bufferView": len(views) - 1, "componentType": 5126, "count": values.size, "type": "SCALAR"}
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        accessors.append(accessor)
        return len(accessors) - 1

    def packed(self) -> bytes:
        self.document["buffers"][0]["byteLength"] = len(self.data)
        text = json.dumps(self.document, ensure_ascii=False, separators=(",", ":")).encode()
        chunks = [(_JSON, text + b" " * (-len(text) % 4)), (_BIN, bytes(self.data)), *self.others]
        body = b"".join(struct.pack("<II", len(data), kind) + data for kind, data in chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _table() -> dict[str, Any]:
    return tomllib.loads((resources.files("mien") / "assets" / "rigs" / "names.toml").read_text("utf-8"))
