"""Faces with fewer triangles, for compact files: a subset of the vertices, chosen beforehand where the mesh is known.

``assets/faces/reduced_meshes.npz`` (`tools/reduce_topology.py`) keeps, under the digest of a part's triangles, those
that remain: skin, eyes and teeth of the default face, which the cast shares. Other parts stay as they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.face.model import Face, Part
from mien.face.subset import subset

__all__ = ["REDUCED", "reduced_face", "topology"]

REDUCED = "faces/reduced_meshes.npz"


def topology(part: Part) -> str:
    """What all parts have in common that share their triangles."""
    return f"{len(part.vertices)}-{hashlib.blake2b(part.triangles.astype('<i4').tobytes(), digest_size=8).hexdigest()}"


def reduced_face(face: Face) -> tuple[Face, dict[str, NDArray[np.intp]]]:
    """The face with fewer triangles, and by part the numbers that its vertices had before."""
    parts, numbers = [], {}
    for part in face.parts:
        triangles = _known().get(topology(part), part.triangles).astype(np.int64)
        order = np.unique(triangles)
        parts.append(subset(part, order, np.searchsorted(order, triangles)))
        numbers[part.name] = order
    return replace(face, parts=tuple(parts), tree=None, sites={}), numbers


@cache
def _known() -> Mapping[str, NDArray[np.uint16]]:
    with np.load(asset(REDUCED), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}
