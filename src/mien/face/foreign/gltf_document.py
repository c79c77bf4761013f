"""A glTF 2.0 file as it stands: its JSON, and the bytes that it points to. Nothing is decoded here.

Source: glTF 2.0 specification, sections 3.6 (binary data), 3.5 (nodes) and 4.4 (binary container).
"""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.limits import check_begun, file_beside, read_bytes
from mien.core.plain_text import parsed_json

__all__ = ["BIN", "JSON", "SUFFIXES", "GltfDocument", "is_gltf", "read_gltf"]

JSON, BIN = 0x4E4F534A, 0x004E4942
SUFFIXES = (".glb", ".vrm", ".gltf", ".fbx")
_BARE = (".obj", ".ply", ".stl", ".usd", ".usda", ".usdc", ".usdz")
_LISTS = (
    "nodes", "meshes", "skins", "accessors", "bufferViews", "buffers", "images", "animations", "scenes", "materials",
    "textures",
)  # fmt: skip


def is_gltf(name: str | Path) -> bool:
    """Whether a file of this name holds a face of another maker.

    Examples
    --------
    >>> is_gltf("Anna.VRM"), is_gltf("default")
    (True, False)
    """
    return str(name).lower().endswith(SUFFIXES)


@dataclass(frozen=True)
class GltfDocument:
    """A glTF file.

    Attributes
    ----------
    path : Path
    json : dict
    binary : bytes or None
        The binary chunk of a ``.glb``.
    other_chunks : tuple of (int, bytes)
        Chunks of a ``.glb`` that are neither JSON nor binary.
    """

    path: Path
    json: dict[str, Any]
    binary: bytes | None = None
    other_chunks: tuple[tuple[int, bytes], ...] = ()
    _read: dict[str, bytes] = field(default_factory=dict, repr=False, compare=False)

    def list_of(self, name: str) -> list[dict[str, Any]]:
        """One of the lists of the document; empty where it has none."""
        found = self.json.get(name)
        return found if isinstance(found, list) else []

    def buffer(self, number: int) -> bytes:
        """The bytes of a buffer, at least as many as it says.

        Raises
        ------
        InputError
            If they are missing, too few, or held back by a compression that has no plain copy.
        """
        facts = self._entry("buffers", number)
        length = facts.get("byteLength")
        if "uri" in facts:
            data = self.bytes_at(facts["uri"], f"buffer {number}")
        elif number == 0 and self.binary is not None:
            data = self.binary
        else:
            raise InputError(f"{self.path}: buffer {number} has no bytes in the file")
        if not isinstance(length, int) or not 0 <= length <= len(data):
            raise InputError(f"{self.path}: buffer {number} should have {length} bytes and has {len(data)}")
        return data

    def view(self, number: int) -> bytes:
        """The bytes of a buffer view.

        Raises
        ------
        InputError
            If it lies outside its buffer.
        """
        facts = self._entry("bufferViews", number)
        return self.span(facts, f"buffer view {number}")

    def span(self, facts: Mapping[str, Any], what: str) -> bytes:
        """The bytes that ``buffer``, ``byteOffset`` and ``byteLength`` of some entry name."""
        start, length = facts.get("byteOffset", 0), facts.get("byteLength")
        data = self.buffer(facts.get("buffer", -1))
        if not _whole(start) or not _whole(length) or start + length > len(data):
            raise InputError(f"{self.path}: {what} (bytes {start} + {length}) lies outside its buffer of {len(data)}")
        return data[start : start + length]

    def bytes_at(self, uri: object, what: str) -> bytes:
        """The bytes of a ``data:`` URI, or of a file in the folder of this one.

        Raises
        ------
        InputError
            If there is no such file, or it lies elsewhere.
        """
        if not isinstance(uri, str):
            raise InputError(f"{self.path}: {what} has no readable URI")
        if uri not in self._read:
            self._read[uri] = _data_of_uri(self.path, uri, what) if uri.startswith("data:") else self._file(uri, what)
        return self._read[uri]

    def _file(self, uri: str, what: str) -> bytes:
        if "://" in uri:
            raise InputError(f"{self.path}: {what} is at {uri[:60]}; mien reads files beside it only")
        try:
            return read_bytes(file_beside(self.path, unquote(uri)))
        except InputError as problem:
            raise InputError(f"{self.path}: {what} is in {uri[:60]!r}: {problem}") from problem

    def _entry(self, name: str, number: object) -> dict[str, Any]:
        entries = self.list_of(name)
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < len(entries):
            raise InputError(f"{self.path}: there is no {name}[{number}]; it has {len(entries)} of them")
        return entries[number]

    def parents(self) -> dict[int, int]:
        """The parent of every node that has one."""
        return {child: place for place, node in enumerate(self.list_of("nodes")) for child in node.get("children", [])}

    def below(self, number: int) -> Iterator[int]:
        """A node and all below it."""
        waiting = [number]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(self.list_of("nodes")[node].get("children", [])))


@guarded("a glTF file")
def read_gltf(path: str | Path) -> GltfDocument:
    """Read a ``.glb``, ``.vrm`` or ``.gltf`` file, or an ``.fbx`` by way of Blender.

    Raises
    ------
    InputError
        If it cannot be read, is cut off, is not glTF 2, or its nodes and meshes do not hold together.
    """
    path = Path(path)
    check_begun(path)
    content = read_bytes(path, "mesh")
    if path.suffix.lower() == ".fbx":
        from mien.face.foreign.blender_bridge import converted

        content = converted(content, ".fbx", ".glb", name=str(path))
    if content[:4] == b"glTF":
        document = _binary(path, content)
    elif path.suffix.lower() == ".gltf" or content.lstrip()[:1] == b"{":
        document = GltfDocument(path, _parsed(path, content))
    elif path.suffix.lower() == ".npz":
        told = f"'mien say Hi --face {path} -o X.glb' writes it as one"
        raise InputError(f"{path} is a face file of mien's, not a .glb, .vrm or .gltf: {told}")
    else:
        told = f"'mien face fit {path} -o FACE.npz' gives a bare mesh its shapes"
        bare = path.suffix.lower() in _BARE
        why = f"is a bare mesh without shapes: {told}" if bare else "is not a GLB file: it does not begin with 'glTF'"
        raise InputError(f"{path} {why}")
    _check(document)
    return document


def _binary(path: Path, content: bytes) -> GltfDocument:
    if len(content) < 20:
        raise InputError(f"{path} is cut off: a GLB has 20 bytes at least, this one {len(content)}")
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
    if not chunks or chunks[0][0] != JSON:
        raise InputError(f"{path}: the first chunk is not a JSON object")
    binary = next((data for kind, data in chunks[1:] if kind == BIN), None)
    others = tuple(chunk for chunk in chunks[1:] if chunk[0] != BIN)
    return GltfDocument(path, _parsed(path, chunks[0][1]), binary, others)


def _parsed(path: Path, text: bytes) -> dict[str, Any]:
    try:
        document = parsed_json(text.rstrip(b"\0 ").decode("utf-8-sig"))
    except ValueError as problem:
        raise InputError(f"{path}: its JSON cannot be read: {problem}") from problem
    if not isinstance(document, dict):
        raise InputError(f"{path}: expected a JSON object, got {type(document).__name__}")
    return document


def _data_of_uri(path: Path, uri: str, what: str) -> bytes:
    head, comma, body = uri.partition(",")
    try:
        if not comma or not head.endswith(";base64"):
            raise ValueError("expected data:...;base64,...")
        return base64.b64decode(unquote(body), validate=True)
    except (ValueError, binascii.Error) as problem:
        raise InputError(f"{path}: {what} has a data URI that cannot be read: {problem}") from problem


def _whole(number: object) -> bool:
    return isinstance(number, int) and not isinstance(number, bool) and number >= 0


def _check(document: GltfDocument) -> None:
    """Refuse what would make later steps stumble: wrong kinds, numbers out of range, trees that are none."""
    path, content = document.path, document.json
    for name in _LISTS:
        entries = content.get(name, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise InputError(f"{path}: expected a list of objects under {name!r}")
    extensions = content.get("extensions", {})
    if not isinstance(extensions, dict):
        raise InputError(f"{path}: expected an object under 'extensions'")
    for place, node in enumerate(document.list_of("nodes")):
        for key, among in (("mesh", "meshes"), ("skin", "skins")):
            if key in node:
                document._entry(among, node[key])
        _numbers(path, f"node {place}", node)
    for place, mesh in enumerate(document.list_of("meshes")):
        _check_mesh(path, place, mesh)
    _check_tree(document)


def _numbers(path: Path, what: str, node: Mapping[str, Any]) -> None:
    for key, count in (("matrix", 16), ("translation", 3), ("rotation", 4), ("scale", 3)):
        given = node.get(key)
        if given is not None and not _row(given, count):
            raise InputError(f"{path}: {key} of {what} is not a row of {count} numbers")


def _row(given: object, count: int) -> bool:
    return (
        isinstance(given, Sequence)
        and len(given) == count
        and all(isinstance(v, (int, float)) and not isinstance(v, bool) and abs(v) < 1e30 for v in given)
    )


def _check_mesh(path: Path, place: int, mesh: Mapping[str, Any]) -> None:
    primitives = mesh.get("primitives")
    if not isinstance(primitives, list) or not primitives or not all(isinstance(p, dict) for p in primitives):
        raise InputError(f"{path}: its meshes do not hold together: mesh {place} has no primitives")
    counts = set()
    for primitive in primitives:
        targets = primitive.get("targets", [])
        if not isinstance(targets, list) or not all(isinstance(target, dict) for target in targets):
            raise InputError(f"{path}: its meshes do not hold together: targets of mesh {place} are not a list")
        counts.add(len(targets))
    if len(counts) > 1:
        raise InputError(
            f"{path}: the primitives of mesh {place} have {sorted(counts)} morph targets; glTF wants as many in each"
        )


def _check_tree(document: GltfDocument) -> None:
    nodes, seen = document.list_of("nodes"), set()
    for place, node in enumerate(nodes):
        children = node.get("children", [])
        if not isinstance(children, list):
            raise InputError(f"{document.path}: the children of node {place} are not a list")
        for child in children:
            document._entry("nodes", child)
            if child in seen:
                raise InputError(f"{document.path}: node {child} has two parents; its nodes must form a tree")
            seen.add(child)
    parents = document.parents()
    settled: set[int] = set()
    for place in range(len(nodes)):
        way: set[int] = set()
        while place in parents and place not in settled:
            if place in way:
                raise InputError(f"{document.path}: node {place} is its own ancestor; its nodes must form a tree")
            way.add(place)
            place = parents[place]
        settled |= way
    for number, scene in enumerate(document.list_of("scenes")):
        roots = scene.get("nodes", [])
        for root in roots if isinstance(roots, list) else [None]:
            if root is None or not _whole(root) or root >= len(nodes):
                raise InputError(f"{document.path}: scene {number} names nodes that are not there")
