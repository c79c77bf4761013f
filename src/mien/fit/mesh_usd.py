"""The meshes of a USD stage as one, at its default time."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, MissingPartError
from mien.core.limits import check_size

__all__ = ["USD_SUFFIXES", "read_usd_mesh"]

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def read_usd_mesh(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Vertices (n, 3) in the stage's unit, triangles (t, 3), and colours (n, 3) where meshes have one for each point.

    Raises
    ------
    InputError
        If the file cannot be read or has no meshes.
    MissingPartError
        If Pixar's USD library is not installed.
    """
    if find_spec("pxr") is None:
        raise MissingPartError(f"{path}: USD files need Pixar's library: pip install 'mien[usd]'")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    from pxr import Tf, Usd, UsdGeom

    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException as problem:
        raise InputError(f"{path}: no USD file that can be read") from problem
    places = UsdGeom.XformCache()
    points, triangles, colours, first = [], [], [], 0
    for prim in stage.Traverse():
        mesh = UsdGeom.Mesh(prim)
        own = _numbers(mesh.GetPointsAttr().Get() if mesh else None, np.float64)
        if not len(own):
            continue
        check_size("rows", first + len(own), str(path))
        matrix = np.array(places.GetLocalToWorldTransform(prim))
        points.append(own @ matrix[:3, :3] + matrix[3, :3])
        triangles.append(_fans(mesh, len(own), str(path)) + first)
        given = mesh.GetDisplayColorAttr().Get()
        linear = np.array(given) if given is not None and len(given) == len(own) else np.ones((len(own), 3))
        colours.append(
            np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)
        )
        first += len(own)
    if not points:
        raise InputError(f"{path}: it has no meshes")
    return np.concatenate(points), np.concatenate(triangles).astype(np.int32), np.clip(np.concatenate(colours), 0, 1)


def _numbers(given: object, kind: type) -> NDArray[Any]:
    return np.zeros(0, kind) if given is None else np.array(given, dtype=kind)


def _fans(mesh, count: int, where: str) -> NDArray[np.int64]:  # type: ignore[no-untyped-def]
    """Polygons cut into fans."""
    sizes = _numbers(mesh.GetFaceVertexCountsAttr().Get(), np.int64)
    corners = _numbers(mesh.GetFaceVertexIndicesAttr().Get(), np.int64)
    if sizes.sum() != len(corners) or (len(corners) and not 0 <= corners.min() <= corners.max() < count):
        raise InputError(f"{where}: the faces of {mesh.GetPath()} do not hold together")
    start = np.cumsum(sizes) - sizes
    fans = np.maximum(sizes - 2, 0)
    face = np.repeat(np.arange(len(sizes)), fans)
    step = np.arange(len(face)) - np.repeat(np.cumsum(fans) - fans, fans)
    found = np.stack([corners[start[face]], corners[start[face] + step + 1], corners[start[face] + step + 2]], axis=1)
    left_handed = mesh.GetOrientationAttr().Get() == "leftHanded"
    return found[:, ::-1] if left_handed else found
