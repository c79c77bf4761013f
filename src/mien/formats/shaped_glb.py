"""Morph targets added to the meshes of a user's own glTF file; everything else in it stays as it is.

Source: glTF 2.0 specification, section 3.7.2.2 (morph targets) and 3.11 (animated weights).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.face.foreign.accessors import AccessorReader
from mien.face.foreign.draco import DRACO
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.model import Target
from mien.formats.appended_glb import AppendedGlb

__all__ = ["PrimitiveShapes", "write_shapes"]


@dataclass(frozen=True, eq=False)
class PrimitiveShapes:
    """What one primitive of a file gains.

    Attributes
    ----------
    mesh, primitive : int
        Their numbers in the file.
    targets : mapping of str to Target
        Offsets in the mesh's own coordinates; vertices past those that are there are the copies.
    copies : ndarray of int64
        Vertices that are given a copy, appended in this order (where a mesh is cut open).
    triangles : ndarray of int64, shape (t, 3), or None
        All triangles, where the cut changes them.
    """

    mesh: int
    primitive: int
    targets: Mapping[str, Target]
    copies: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    triangles: NDArray[np.int64] | None = None


def write_shapes(source: GltfDocument, shapes: Sequence[PrimitiveShapes], path: str | Path) -> tuple[Note, ...]:
    """Write a file again with further morph targets.

    Targets whose names a mesh has already are left as they are.

    Raises
    ------
    InputError
        If the result would overwrite the source, or the source does not hold together.
    OutputError
        If it cannot be written.
    """
    if source.path.resolve() == Path(path).resolve():
        raise InputError(f"{path} is both read and written: give the output another name")
    out = AppendedGlb(source)
    reader = AccessorReader(source)
    notes: list[Note] = []
    by_mesh: dict[int, list[PrimitiveShapes]] = {}
    for each in shapes:
        if each.targets:
            by_mesh.setdefault(each.mesh, []).append(each)
    for number, some in sorted(by_mesh.items()):
        notes += _shaped_mesh(out, reader, number, {each.primitive: each for each in some})
    content = out.packed()
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)
    return (*out.notes, *notes)


def _shaped_mesh(
    out: AppendedGlb, reader: AccessorReader, number: int, shapes: Mapping[int, PrimitiveShapes]
) -> list[Note]:
    mesh = out.document["meshes"][number]
    there = len(mesh["primitives"][0].get("targets", []))
    extras = mesh.get("extras") if isinstance(mesh.get("extras"), dict) else {}
    known = list((extras or {}).get("targetNames") or [])[:there]
    known += [f"target {i}" for i in range(len(known), there)]
    wanted = list(dict.fromkeys(name for each in shapes.values() for name in each.targets))
    names = [name for name in wanted if name not in known]
    for place, primitive in enumerate(mesh["primitives"]):
        own = shapes.get(place, PrimitiveShapes(number, place, {}))
        count = out.document["accessors"][primitive["attributes"]["POSITION"]]["count"]
        if len(own.copies):
            count = _cut_open(out, reader, primitive, own)
        none = Target(np.zeros(0, np.int32), np.zeros((0, 3), np.float32))
        primitive["targets"] = [*primitive.get("targets", [])]
        for name in names:
            target = own.targets.get(name, none)
            accessor = out.add_sparse(count, target.vertices.astype(np.int64), target.offsets)
            primitive["targets"].append({"POSITION": accessor})
    mesh["extras"] = {**(extras or {}), "targetNames": [*known, *names]}
    if "weights" in mesh:
        mesh["weights"] = [*mesh["weights"], *[0.0] * len(names)]
    _lengthen(out, reader, number, there, len(names))
    skipped = [name for name in wanted if name in known]
    if skipped:
        told = f"mesh {mesh.get('name', number)!r} has targets of these names already, left as they are: "
        return [Note("note", told + ", ".join(skipped))]
    return []


def _cut_open(out: AppendedGlb, reader: AccessorReader, primitive: dict[str, Any], shapes: PrimitiveShapes) -> int:
    """Give some vertices copies in all attributes and targets, and the triangles their new corners."""
    (primitive.get("extensions") or {}).pop(DRACO, None)  # what is cut open is written plain
    for group in (primitive["attributes"], *primitive.get("targets", [])):
        for key, accessor in group.items():
            rows = reader.stored(accessor)
            group[key] = out.add_rows(np.concatenate([rows, rows[shapes.copies]]), out.document["accessors"][accessor])
    count = int(out.document["accessors"][primitive["attributes"]["POSITION"]]["count"])
    assert shapes.triangles is not None
    primitive["indices"] = out.add_indices(shapes.triangles)
    primitive.pop("mode", None)
    return count


def _lengthen(out: AppendedGlb, reader: AccessorReader, mesh: int, before: int, more: int) -> None:
    """Rest weights of nodes, and animations of weights, for the targets that a mesh has gained."""
    nodes = [i for i, node in enumerate(out.document.get("nodes", [])) if node.get("mesh") == mesh]
    for number in nodes:
        if "weights" in out.document["nodes"][number]:
            out.document["nodes"][number]["weights"] += [0.0] * more
    if not before or not more:
        return
    for animation in out.document.get("animations", []):
        for channel in animation.get("channels", []):
            target = channel.get("target", {})
            if target.get("node") in nodes and target.get("path") == "weights":
                sampler = animation["samplers"][channel["sampler"]]
                keys = reader.read(sampler["output"], 1).reshape(-1, before)
                longer = np.hstack([keys, np.zeros((len(keys), more))]).astype(np.float32)
                sampler["output"] = out.add(longer.reshape(-1), "SCALAR")
