"""What is odd about a face's meshes: nothing here stops the work, and each line names the part and the first place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.face.model import Face, Part

__all__ = ["mesh_notes"]

_NO_AREA = 1e-12  # square of the mesh's unit, relative to the mean triangle
_MANY = 300_000


def mesh_notes(face: Face) -> list[str]:
    """Holes, repeated or unused vertices, triangles without area, crowded edges, no morph targets, very many vertices.

    Vertices and triangles are counted from 0.

    Examples
    --------
    >>> from mien.face.obj import Mesh, face_of_mesh
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9.0]])
    >>> mesh = Mesh(points, np.array([[0, 1, 2]], np.int32), np.zeros((4, 2)), np.ones((4, 3)))
    >>> for line in mesh_notes(face_of_mesh(mesh, "one")):
    ...     print(line)
    part 'mesh': 1 open edge loop (a hole or a rim), the first at vertex 0
    part 'mesh': no triangle uses 1 of 4 vertices, first 3: moved, not drawn
    no part has morph targets: only a parameter tree can move this face
    """
    notes = [f"part {part.name!r}: {note}" for part in face.parts for note in _part_notes(part)]
    if not any(part.targets for part in face.parts):
        notes.append("no part has morph targets: only a parameter tree can move this face")
    return notes


def _part_notes(part: Part) -> list[str]:
    count, triangles = len(part.vertices), part.triangles.astype(np.int64)
    if not len(triangles):
        return ["has no triangles: nothing of it is drawn"]
    notes = []
    rims, first, crowded = _rims(part)
    if rims:
        notes.append(f"{rims} open edge loop{'s' if rims > 1 else ''} (a hole or a rim), the first at vertex {first}")
    if crowded:
        notes.append(f"{crowded} edges have more than two triangles: shading may be uneven there")
    flat = _without_area(part.vertices, triangles)
    if len(flat):
        notes.append(f"{len(flat)} of {len(triangles)} triangles have no area, first {flat[0]}: not drawn")
    unused = np.setdiff1d(np.arange(count), triangles)
    if len(unused):
        notes.append(f"no triangle uses {len(unused)} of {count} vertices, first {unused[0]}: moved, not drawn")
    _, first_of, number = np.unique(part.vertices.round(5), axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first_of[number.reshape(-1)] != np.arange(count))
    if len(again):
        other = first_of[number.reshape(-1)][again[0]]
        notes.append(f"{len(again)} vertices lie where another one does, first {again[0]} on {other}: shaded as one")
    if count > _MANY:
        notes.append(f"{count:,} vertices: posing takes some {count / 40_000:.0f} ms a frame, drawing far longer")
    return notes


def _without_area(vertices: NDArray[np.float32], triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    corner = vertices.astype(np.float64)[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.flatnonzero(area <= _NO_AREA * max(float(area.mean()), 1e-300))


def _rims(part: Part) -> tuple[int, int, int]:
    """Number of open loops, a vertex of the first one, and edges with more than two triangles; seams are closed."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    from mien.face.posing import welded_vertices

    welded = welded_vertices(part).astype(np.int64)[part.triangles]
    sides = np.sort(np.vstack([welded[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    sides = sides[sides[:, 0] != sides[:, 1]]
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    border = edges[uses == 1]
    if not len(border):
        return 0, -1, int((uses > 2).sum())
    on, local = np.unique(border, return_inverse=True)
    local = local.reshape(-1, 2)
    graph = coo_matrix((np.ones(len(local)), (local[:, 0], local[:, 1])), (len(on), len(on)))
    return int(connected_components(graph, directed=False)[0]), int(on[0]), int((uses > 2).sum())
