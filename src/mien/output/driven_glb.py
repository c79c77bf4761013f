"""A GLB of any maker, driven: keys are appended, everything else in the file stays as it is.

Only the JSON is edited and the binary chunk extended; no mesh, picture or compressed buffer is decoded.
Source: glTF 2.0 specification, sections 3.11 (animations) and 4.4 (binary container).
"""

from __future__ import annotations

import json
import re
import struct
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.channels import WEIGHTS
from mien.errors import InputError, Note
from mien.files import replace_when_complete
from mien.output.turning_nodes import turns_of_nodes
from mien.tracks import ChannelTrack

__all__ = ["DrivenMesh", "drive_glb", "driven_meshes", "read_chunks", "recipe_of_target", "target_names"]

_JSON, _BIN = 0x4E4F534A, 0x004E4942
Recipe = Mapping[str, float]
_ENOUGH_ARKIT = 10
"""ARKit shapes from which on a mesh is driven by them alone."""


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


@dataclass(frozen=True)
class DrivenMesh:
    """What of one mesh is driven.

    Attributes
    ----------
    name : str
    targets : tuple of str
        Names of all its morph targets; "" where the file has none.
    recipes : tuple of mapping of str to float
        For each target the channels that drive it; empty if its name is not known, or if the mesh has it twice over
        (a mesh with ARKit's shapes is not driven by visemes as well).
    """

    name: str
    targets: tuple[str, ...]
    recipes: tuple[Recipe, ...]


def driven_meshes(path: str | Path, document: Mapping[str, Any]) -> tuple[DrivenMesh, ...]:
    """All meshes of a document, and what drives their targets.

    Raises
    ------
    InputError
        If the document does not hold together.
    """
    try:
        from_vrm = _vrm_names(document)
        return tuple(
            _driven(str(mesh.get("name") or f"mesh {number}"), target_names(mesh, from_vrm.get(number, {})))
            for number, mesh in enumerate(document.get("meshes", []))
        )
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{path}: its meshes or expressions do not hold together ({problem!r})") from problem


def _driven(name: str, targets: tuple[str, ...]) -> DrivenMesh:
    recipes = [recipe_of_target(target) for target in targets]
    arkit = [target for target, recipe in zip(targets, recipes, strict=True) if recipe and _is_arkit(target)]
    if len(arkit) >= _ENOUGH_ARKIT:
        recipes = [recipe if _is_arkit(t) else {} for t, recipe in zip(targets, recipes, strict=True)]
    return DrivenMesh(name, targets, tuple(recipes))


def target_names(mesh: Mapping[str, Any], otherwise: Mapping[int, str] | None = None) -> tuple[str, ...]:
    """Names of a mesh's morph targets: from ``extras.targetNames``, else ``otherwise`` by place, else empty."""
    count = len(mesh["primitives"][0].get("targets", []))
    given = (mesh.get("extras") or {}).get("targetNames")
    given = given or (mesh["primitives"][0].get("extras") or {}).get("targetNames") or []
    names = [str(name) for name in given[:count]]
    return tuple(names + [(otherwise or {}).get(place, "") for place in range(len(names), count)])


def _vrm_names(document: Mapping[str, Any]) -> dict[int, dict[int, str]]:
    """Names of morph targets by mesh and place, as the expressions of VRM 1 or 0 that move them alone."""
    found: dict[int, dict[int, str]] = {}
    extensions = document.get("extensions", {})
    expressions = extensions.get("VRMC_vrm", {}).get("expressions", {})
    for group in ("preset", "custom"):
        for name, expression in expressions.get(group, {}).items():
            binds = expression.get("morphTargetBinds", [])
            meshes = {document["nodes"][bind["node"]]["mesh"] for bind in binds}
            if len(binds) == len(meshes):
                for bind in binds:
                    found.setdefault(document["nodes"][bind["node"]]["mesh"], {}).setdefault(bind["index"], name)
    for entry in extensions.get("VRM", {}).get("blendShapeMaster", {}).get("blendShapeGroups", []):
        name = entry.get("presetName", "")
        name = entry.get("name", "") if name in ("", "unknown") else name
        binds = entry.get("binds", [])
        if len(binds) == len({bind["mesh"] for bind in binds}):
            for bind in binds:
                found.setdefault(bind["mesh"], {}).setdefault(bind["index"], name)
    return found


def recipe_of_target(name: str) -> Recipe:
    """Which channels drive a target of this name, and by how much; empty if the name is not known.

    Examples
    --------
    >>> recipe_of_target("blendShape1.jaw_open")
    {'jawOpen': 1.0}
    >>> recipe_of_target("browDown_L")
    {'browDownLeft': 1.0}
    """
    channel = _channel_of(name)
    if channel:
        return {channel: 1.0}
    plain, table = _plain(name.rsplit(".", 1)[-1]), _table()
    viseme = re.sub(r"^(viseme|vrcv|fclmth|fcleye|v)(?=.)", "", plain)
    found: Recipe = table["arkit"].get(plain) or table["visemes"].get(viseme) or {}
    return found


def _is_arkit(name: str) -> bool:
    return bool(_channel_of(name))


@cache
def _channel_of(name: str) -> str:
    """The channel whose own name this is, whatever its spelling; "" if there is none."""
    short = re.sub(r"_(L|R)$", lambda side: "Left" if side[1] == "L" else "Right", name.rsplit(".", 1)[-1])
    spelt = {_plain(channel): channel for channel in WEIGHTS}
    if _plain(short) in ("browinnerupleft", "browinnerupright"):
        return "browInnerUp"
    return spelt.get(_plain(short), "")


def drive_glb(track: ChannelTrack, source: str | Path, path: str | Path) -> tuple[Note, ...]:
    """Write ``source`` again with the weights of a track, and its head and eyes turning, as one more animation.

    Returns
    -------
    tuple of Note
        Which of the head and the eyes were not found among its nodes.

    Raises
    ------
    InputError
        If it cannot be read, has no morph target with a known name, or would be overwritten.
    OutputError
        If the result cannot be written.
    """
    if Path(source).resolve() == Path(path).resolve():
        raise InputError(f"{path} is both read and written: give the output another name")
    document, chunks = read_chunks(source)
    meshes = driven_meshes(source, document)
    if not any(recipe for mesh in meshes for recipe in mesh.recipes):
        raise InputError(f"{source} has no morph target with a known name (ARKit, VRM or viseme): nothing could move")
    try:
        keys = _Keys(document, chunks)
        notes = _add_animation(track, document, meshes, keys)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{source}: its nodes do not hold together ({problem!r})") from problem
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(keys.packed())
    return notes


def _add_animation(
    track: ChannelTrack, document: dict[str, Any], meshes: tuple[DrivenMesh, ...], keys: _Keys
) -> tuple[Note, ...]:
    times = keys.add(track.rate.times(len(track)).astype(np.float32), "SCALAR", bounds=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []

    def put(node: int, path: str, output: int) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": times, "interpolation": "LINEAR", "output": output})

    for number, node in enumerate(document.get("nodes", [])):
        if "mesh" in node and any(meshes[node["mesh"]].recipes):
            rest = node.get("weights") or document["meshes"][node["mesh"]].get("weights")
            put(number, "weights", keys.add(_weights(track, meshes[node["mesh"]], rest).reshape(-1), "SCALAR"))
    turned, notes = turns_of_nodes(track, document)
    for number, turns in turned.items():
        put(number, "rotation", keys.add(turns.astype(np.float32), "VEC4"))
    document.setdefault("animations", []).append({"name": "mien", "channels": channels, "samplers": samplers})
    return notes


def _weights(track: ChannelTrack, mesh: DrivenMesh, rest: Sequence[float] | None) -> NDArray[np.float32]:
    values = np.tile(np.asarray(rest or [0.0] * len(mesh.recipes), dtype=np.float32), (len(track), 1))
    for column, recipe in enumerate(mesh.recipes):
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

    def add(self, values: NDArray[np.float32], kind: str, bounds: bool = False) -> int:
        self.data += bytes(-len(self.data) % 4)
        views = self.document.setdefault("bufferViews", [])
        accessors = self.document.setdefault("accessors", [])
        views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.astype("<f4").tobytes()
        accessor: dict[str, Any] = {
            "bufferView": len(views) - 1,
            "componentType": 5126,
            "count": len(values),
            "type": kind,
        }
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


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads((resources.files("mien") / "assets" / "rigs" / "names.toml").read_text("utf-8"))
