"""The shapes of a fitted head put back on the vertices of the file that it came from."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.model import Target
from mien.fit.fit_head import FittedHead
from mien.fit.head_parts import GivenMesh, Origin
from mien.formats.shaped_glb import PrimitiveShapes

__all__ = ["shapes_of_file"]

Floats = NDArray[np.float64]


def shapes_of_file(done: FittedHead, mesh: GivenMesh) -> tuple[PrimitiveShapes, ...]:
    """What each primitive of the file gains; the offsets are in its own coordinates.

    Parameters
    ----------
    done : FittedHead
    mesh : GivenMesh
        That it was fitted to, read from a glTF file.

    Raises
    ------
    InputError
        If the mesh did not come from a glTF file.
    """
    if not mesh.origins:
        raise InputError("shapes are put back into .glb, .gltf and .vrm files only; write a new .glb instead")
    back = done.alignment.to_face.turn / done.alignment.to_face.scale  # offsets are rows
    whole = _whole(done, len(mesh.vertices), back)
    copied = done.kept[len(done.kept) - done.copied :]
    opened = _opened(done, len(mesh.vertices)) if done.copied else {}
    return tuple(found for origin in mesh.origins if (found := _of_primitive(origin, whole, copied, opened, mesh)))


def _whole(done: FittedHead, count: int, back: Floats) -> dict[str, Target]:
    """Targets on the file's vertices; those of copies are numbered past them."""
    gathered: dict[str, list[tuple[NDArray[np.int64], Floats]]] = {}
    number = done.kept.copy()
    if done.copied:
        number[-done.copied :] = count + np.arange(done.copied)
    for vertices, targets in ((number, done.face.part("skin").targets), *done.loose):
        for name, target in targets.items():
            gathered.setdefault(name, []).append((vertices[target.vertices], target.offsets @ back))
    found = {}
    for name, some in gathered.items():
        rows, first = np.unique(np.concatenate([rows for rows, _ in some]), return_index=True)
        found[name] = Target(rows.astype(np.int32), np.concatenate([o for _, o in some])[first].astype(np.float32))
    return found


def _opened(done: FittedHead, count: int) -> dict[tuple[int, ...], dict[int, int]]:
    """Of triangles that use copies, by the corners that they had before, the new corner for each old one."""
    number = done.kept.copy()
    number[-done.copied :] = count + np.arange(done.copied)
    triangles = done.face.part("skin").triangles
    changed = triangles[(triangles >= len(done.kept) - done.copied).any(axis=1)]
    pairs = (dict(zip(done.kept[c].tolist(), number[c].tolist(), strict=True)) for c in changed)
    return {tuple(sorted(pair)): pair for pair in pairs}


def _of_primitive(
    origin: Origin,
    whole: dict[str, Target],
    copied: NDArray[np.int64],
    opened: dict[tuple[int, ...], dict[int, int]],
    mesh: GivenMesh,
) -> PrimitiveShapes | None:
    count, last = len(mesh.vertices), origin.first + origin.count
    mine = np.flatnonzero((copied >= origin.first) & (copied < last))
    own = np.full(count + len(copied), -1)  # the primitive's number of each of the file's vertices
    own[origin.first : last] = np.arange(origin.count)
    own[count + mine] = origin.count + np.arange(len(mine))
    source = np.concatenate([np.arange(origin.count), copied[mine] - origin.first])
    inverse = np.asarray(np.linalg.pinv(origin.linear), dtype=np.float64)
    targets = {name: t for name, target in whole.items() if (t := _local(target, own, source, inverse)) is not None}
    if not targets:
        return None
    triangles = None
    if len(mine):
        triangles = origin.triangles.copy()
        for place, corners in _with_copies(origin, opened):
            triangles[place] = own[corners]
    return PrimitiveShapes(origin.mesh, origin.primitive, targets, copied[mine] - origin.first, triangles)


def _local(target: Target, own: NDArray[np.int64], source: NDArray[np.int64], inverse: Floats) -> Target | None:
    rows = own[target.vertices]
    there = np.flatnonzero(rows >= 0)
    if not len(there):
        return None
    there = there[np.argsort(rows[there])]
    rows = rows[there]
    linear = inverse[source[rows]] if len(inverse) > 1 else inverse[np.zeros(len(rows), np.int64)]
    return Target(
        rows.astype(np.int32),
        np.einsum("nij,nj->ni", linear, target.offsets[there].astype(np.float64)).astype(np.float32),
    )


def _with_copies(
    origin: Origin, opened: dict[tuple[int, ...], dict[int, int]]
) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Numbers of the primitive's triangles that the cut changes, with their new corners."""
    whole = origin.triangles + origin.first
    near = np.isin(whole, np.unique(np.array(list(opened), dtype=np.int64))).all(axis=1)
    for place in np.flatnonzero(near):
        new = opened.get(tuple(sorted(whole[place].tolist())))
        if new is not None:
            yield int(place), np.array([new[corner] for corner in whole[place].tolist()])
