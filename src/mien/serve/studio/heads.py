"""Heads without shapes: their landmarks are found, maybe moved by a person, and the head is given mien's shapes."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.foreign.gltf_document import read_gltf
from mien.face.head_space import head_space
from mien.fit.fit_head import GivenMesh, fit_head
from mien.fit.head_mesh import outward
from mien.fit.head_search import find_head
from mien.fit.in_own_file import shapes_of_file
from mien.fit.landmarks import checked_landmarks, known_landmarks, needed_landmarks
from mien.fit.mesh_files import read_mesh
from mien.formats.shaped_glb import write_shapes
from mien.serve.studio.jobs import Job
from mien.serve.studio.lru_store import Kept, new_id
from mien.serve.studio.requests import FieldError
from mien.serve.studio.studio_faces import FaceShelf

__all__ = ["HeadShelf"]

_HEADS = 2
_WHERE = "the GLB"


@dataclass(frozen=True, eq=False)
class _Head:
    """A head as it came, and where its landmarks were found, in its own coordinates."""

    path: Path
    name: str
    mesh: GivenMesh
    found: Mapping[str, NDArray[np.float64]]


class HeadShelf:
    """Heads that wait for shapes.

    Parameters
    ----------
    folder : Path
        Where they lie.
    faces : FaceShelf
        Takes them once they have shapes.
    """

    def __init__(self, folder: Path, faces: FaceShelf) -> None:
        self._folder, self._faces = folder, faces
        self._heads: Kept[_Head] = Kept("head", _HEADS, gone=lambda head: head.path.unlink(missing_ok=True))

    def open(self, content: bytes, name: str, job: Job) -> str:
        """Read a GLB and find the landmarks of its head; gives its id.

        Raises
        ------
        FieldError
            If it is none, or no head is found in it.
        """
        path = self._folder / f"{new_id()}.glb"
        path.write_bytes(content)
        try:
            job.at("reading the mesh", 0.1)
            mesh = read_mesh(path)
            job.at("looking for the face", 0.3)
            found = find_head(mesh.vertices, outward(mesh.vertices, mesh.triangles), head_space(), _WHERE).places
        except InputError as problem:
            path.unlink(missing_ok=True)
            raise FieldError("face", _plainly(problem, path)) from problem
        return self._heads.put(_Head(path, name, mesh, found))

    def plain(self, name: str) -> bytes:
        """Its mesh (float32, uint32, base64) and landmarks, as JSON; raises `Missing`."""
        head = self._heads.get(name)

        def packed(values: Any, kind: str) -> str:
            return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")

        marks = {
            mark: {"place": [float(at) for at in head.found[mark]], "words": known_landmarks()[mark].words}
            for mark in needed_landmarks()
        }
        mesh = {"vertices": packed(head.mesh.vertices, "<f4"), "triangles": packed(head.mesh.triangles, "<u4")}
        return json.dumps({"head": name, "name": head.name, **mesh, "landmarks": marks}).encode()

    def fit(self, name: str, landmarks: object, job: Job) -> str:
        """Give a head its shapes; ``landmarks`` are those that a person has set. Gives the id of the face it is now.

        Raises
        ------
        FieldError
            If the landmarks do not lie on it, or what comes of it is not fit to be kept.
        """
        head = self._heads.get(name)
        out = self._folder / f"{new_id()}.glb"
        try:
            given = checked_landmarks(landmarks, "landmarks", 3) if landmarks else {}
            job.at("bending the face onto the head", 0.1)
            done = fit_head(head.mesh, given, Path(head.name).stem or "head", None, (), _WHERE)
            refused = [finding.words for finding in done.findings if finding.kind == "refusal"]
            if isnan(done.lip_gap) and isnan(done.lid_gap):
                refused.append("neither lips nor lids that part were found")
            if refused:
                raise InputError(f"the fit is not kept: {'; '.join(refused)}; drag the points to where they belong")
            job.at("writing the shapes", 0.9)
            write_shapes(read_gltf(head.path), shapes_of_file(done, head.mesh), out)
            return self._faces.add(out.read_bytes(), f"{Path(head.name).stem} with shapes.glb")[0]
        except InputError as problem:
            raise FieldError("face", _plainly(problem, head.path)) from problem
        finally:
            out.unlink(missing_ok=True)


def _plainly(problem: InputError, path: Path) -> str:
    """What is wrong, in the page's words."""
    told = str(problem).replace(str(path), _WHERE)
    return told.replace("give --landmarks (mien face fit --list-landmarks)", "is it a head?")
