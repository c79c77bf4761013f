"""Which vertices of a head's mesh the markers of a layout are: for recordings that are meshes of one topology."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.capture.layouts import load_layout
from mien.face.head_space import head_space
from mien.face.surface import Surface
from mien.fit.alignment import align
from mien.fit.head_mesh import outward, prepared_mesh
from mien.fit.head_search import find_head
from mien.fit.mesh_files import read_mesh
from mien.fit.surface_fit import FitSettings, fit_surface

__all__ = ["vertices_for"]


def vertices_for(path: Path, places: NDArray[np.float64], layout: str) -> dict[str, int]:
    """Vertex number of each marker: the default face is fitted to the head, and its markers go along.

    Parameters
    ----------
    path : Path
        A mesh with faces, in any unit and axes; the head is found in it.
    places : ndarray, shape (n, 3)
        Its vertices in the file's order, which the mesh as read may not keep.
    layout : str
        Name of a marker layout.

    Raises
    ------
    InputError
        If no head is found in it.
    """
    space, mesh, where = head_space(), read_mesh(path), str(path)
    found = find_head(mesh.vertices, outward(mesh.vertices, mesh.triangles), space, where).places
    alignment = align(found, space, where, None)
    marks = {key: alignment.to_face(place[None])[0] for key, place in found.items()}
    template = alignment.template(space.rest)
    eyes = {eye.side: alignment.template(np.array([eye.centre]))[0] for eye in space.face.eyes}
    head = prepared_mesh(
        mesh.vertices, mesh.triangles, alignment.to_face, template, space.triangles, eyes, marks, {}, where
    )
    surface = Surface(head.vertices, head.welded[head.triangles], head.of("skin"))
    settings = FitSettings(landmark_sigma=3.0, warped=False)
    centres = {p.kind[4:].capitalize(): p.centre for p in head.pieces if p.kind.startswith("eye_")}
    fit = fit_surface(space, surface, marks, alignment, settings, centres)
    markers = load_layout(layout)
    skin = cKDTree(space.rest)
    near = np.array([skin.query(markers.place(name))[1] for name in markers.markers])
    offsets = np.array([markers.place(name) for name in markers.markers]) - space.rest[near]
    on_head = fit.vertices[near] + offsets * alignment.template.scale
    _, numbers = cKDTree(alignment.to_face(places)).query(on_head)
    return {name: int(number) for name, number in zip(markers.markers, numbers, strict=True)}
