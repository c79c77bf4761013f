"""A face of any maker, driven: keys are appended, everything else in the file stays as it is.

Only the JSON is edited and the binary chunk extended; no mesh, picture or compressed buffer is decoded. A ``.gltf``
becomes a ``.glb`` that needs no other file: its first buffer is the binary chunk, further ones stay as ``data:`` URIs
under their numbers, pictures go into buffer views.
Source: glTF 2.0 specification, sections 3.11 (animations) and 4.4 (binary container).
"""

from __future__ import annotations

import base64
import copy
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import BIN, JSON, GltfDocument
from mien.face.foreign.known_face import known_face
from mien.face.foreign.recognition import ForeignFace
from mien.face.foreign.rig_names import OwnNames
from mien.face.foreign.rig_nodes import local_matrix, parts_of
from mien.formats.turning_nodes import turns_of_nodes

__all__ = ["NAME", "drive_glb"]

NAME = "mien"
"""Of the animation: the first of the file, since players that are not asked play the first."""

_PICTURES = {
    ".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp", ".ktx2": "image/ktx2",
    ".avif": "image/avif", ".dds": "image/vnd-ms.dds",
}  # fmt: skip


def drive_glb(
    track: ChannelTrack,
    source: str | Path | ForeignFace,
    path: str | Path,
    names: OwnNames | str | Path | None = None,
) -> tuple[Note, ...]:
    """Write a face again with the weights of a track, and its head and eyes turning, as the first of its animations.

    An animation that an earlier run of mien put there is replaced; others are kept.

    Parameters
    ----------
    track : ChannelTrack
    source : path-like or ForeignFace
        A ``.glb``, ``.vrm`` or ``.gltf`` file.
    path : path-like
        A ``.glb`` file.
    names : OwnNames or path-like, optional
        A table of the user's own (``docs/faces.md``).

    Returns
    -------
    tuple of Note
        Which of the head and the eyes were not found among its nodes, and what of the file could not be taken along.

    Raises
    ------
    InputError
        If it cannot be read, has no morph target with a known name, or would be overwritten.
    OutputError
        If the result cannot be written.
    """
    face = source if isinstance(source, ForeignFace) else known_face(source, names)
    if face.document.path.resolve() == Path(path).resolve():
        raise InputError(f"{path} is both read and written: give the output another name")
    face.require_motion()
    keys = _Keys(face.document)
    try:
        notes = _add_animation(track, face, keys)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{face.document.path}: its nodes do not hold together ({problem!r})") from problem
    content = keys.packed()
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)
    return (*keys.notes, *notes)


def _add_animation(track: ChannelTrack, face: ForeignFace, keys: _Keys) -> tuple[Note, ...]:
    document = keys.document
    keys.forget_animations(_ours)
    times = keys.add(track.rate.times(len(track)).astype(np.float32), "SCALAR", bounds=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []

    def put(node: int, path: str, output: int) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": times, "interpolation": "LINEAR", "output": output})

    for number, node in enumerate(document.get("nodes", [])):
        if "mesh" in node and face.meshes[node["mesh"]].moves:
            mesh = face.meshes[node["mesh"]]
            rest = node.get("weights") or document["meshes"][node["mesh"]].get("weights")
            weights = face.weights(mesh, track, rest if rest and len(rest) == len(mesh.targets) else None)
            put(number, "weights", keys.add(weights.astype(np.float32).reshape(-1), "SCALAR"))
    turned, notes = turns_of_nodes(track, face)
    for number, turns in turned.items():
        _without_matrix(document["nodes"][number])
        put(number, "rotation", keys.add(turns.astype(np.float32), "VEC4"))
    if not any(channel["target"]["path"] == "weights" for channel in channels):
        raise InputError(f"{face.document.path}: no node shows the meshes that could move")
    there = document.setdefault("animations", [])
    there.insert(0, {"name": NAME, "channels": channels, "samplers": samplers})
    if len(there) > 1:
        told = (
            f"the file has {len(there) - 1} animation(s) of its own, kept; the performance is the first, named {NAME!r}"
        )
        notes = (*notes, Note("note", told))
    return notes


def _ours(animation: dict[str, Any]) -> bool:
    """Whether an earlier run of mien made an animation: by its name, or by what mien's own faces note in it."""
    extras = animation.get("extras")
    return animation.get("name") == NAME or (isinstance(extras, dict) and "mien" in extras)


def _without_matrix(node: dict[str, Any]) -> None:
    """Give a node that is to turn its parts: glTF lets no matrix be animated."""
    if "matrix" in node:
        parts = parts_of(local_matrix(node))
        if parts is not None:
            del node["matrix"]
            node["translation"], node["rotation"], node["scale"] = parts


_USE_ACCESSORS = {"input", "output", "indices", "inverseBindMatrices", "attributes", "targets", "TRANSLATION"}


def _numbers_of(tree: Any, names: set[str], under: bool = False) -> set[int]:
    """Whole numbers that stand under one of the names anywhere in a document: what is referred to."""
    if isinstance(tree, dict):
        return {n for name, value in tree.items() for n in _numbers_of(value, names, under or name in names)}
    if isinstance(tree, list):
        return {n for value in tree for n in _numbers_of(value, names, under)}
    return {tree} if under and isinstance(tree, int) and not isinstance(tree, bool) else set()


class _Keys:
    """Appends to a document without touching the bytes that are there, and gathers what lies in other files."""

    def __init__(self, source: GltfDocument) -> None:
        self.source, self.document = source, copy.deepcopy(source.json)
        self.notes: list[Note] = []
        buffers = self.document.setdefault("buffers", [])
        for number, buffer in enumerate(buffers):
            if "uri" in buffer and not str(buffer["uri"]).startswith("data:") and number > 0:
                data = source.buffer(number)
                buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode("ascii")
        if not buffers:
            buffers.append({"byteLength": 0})
            self.data, self.ours = bytearray(), 0
        elif source.binary is not None and "uri" not in buffers[0]:
            source.buffer(0)  # refuses one that is cut off
            self.data, self.ours = bytearray(source.binary), 0
        elif "uri" in buffers[0] and source.binary is None:
            self.data, self.ours = bytearray(source.buffer(0)), 0
            del buffers[0]["uri"]
        else:  # the first buffer is a compression's placeholder: keys go into one of their own
            buffers.append({"byteLength": 0})
            self.data, self.ours = bytearray(), len(buffers) - 1
        self._gather_pictures()

    def _gather_pictures(self) -> None:
        for number, image in enumerate(self.document.get("images", [])):
            uri = image.get("uri")
            if isinstance(uri, str) and not uri.startswith("data:"):
                try:
                    data = self.source.bytes_at(uri, f"picture {number}")
                except InputError as problem:
                    self.notes.append(Note("warning", f"{problem}; it is left as it is"))
                    continue
                del image["uri"]
                kind = _PICTURES.get(Path(uri.partition("?")[0]).suffix.lower(), "image/png")
                image["bufferView"] = self._view(data)
                image.setdefault("mimeType", kind)

    def forget_animations(self, which: Callable[[dict[str, Any]], bool]) -> None:
        """Take animations out, with their keys where those are the last things in the file."""
        animations = self.document.get("animations", [])
        if not any(map(which, animations)):
            return
        self.document["animations"] = [animation for animation in animations if not which(animation)]
        accessors, views = self.document.get("accessors", []), self.document.get("bufferViews", [])
        used = _numbers_of({k: v for k, v in self.document.items() if k != "accessors"}, _USE_ACCESSORS)
        while accessors and len(accessors) - 1 not in used and "sparse" not in accessors[-1]:
            accessors.pop()
        used = _numbers_of(self.document, {"bufferView"})
        while views and len(views) - 1 not in used and views[-1].get("buffer") == self.ours:
            if views[-1].get("byteOffset", 0) + views[-1]["byteLength"] + 3 < len(self.data):
                break
            del self.data[views[-1].get("byteOffset", 0) :]
            views.pop()

    def add(self, values: NDArray[np.float32], kind: str, bounds: bool = False) -> int:
        """Append an array of float32; returns the number of its accessor."""
        accessors = self.document.setdefault("accessors", [])
        accessor: dict[str, Any] = {
            "bufferView": self._view(values.astype("<f4").tobytes()),
            "componentType": 5126,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        accessors.append(accessor)
        return len(accessors) - 1

    def _view(self, data: bytes) -> int:
        self.data += bytes(-len(self.data) % 4)
        views = self.document.setdefault("bufferViews", [])
        views.append({"buffer": self.ours, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(views) - 1

    def packed(self) -> bytes:
        """The whole file."""
        buffer = self.document["buffers"][self.ours]
        buffer["byteLength"] = len(self.data)
        chunks: list[tuple[int, bytes]] = []
        if self.ours == 0:
            chunks.append((BIN, bytes(self.data) + bytes(-len(self.data) % 4)))
        else:
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode("ascii")
            if self.source.binary is not None:
                chunks.append((BIN, self.source.binary))
        text = json.dumps(self.document, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")
        everything = [(JSON, text + b" " * (-len(text) % 4)), *chunks, *self.source.other_chunks]
        body = b"".join(struct.pack("<II", len(data), kind) + data for kind, data in everything)
        if len(body) + 12 >= 2**32:
            raise InputError(f"{self.source.path}: with its keys the file would be larger than a GLB can be (4 GB)")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
