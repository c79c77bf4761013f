"""Rows of teeth are told apart, gums and all, and turned outward."""

from __future__ import annotations

import numpy as np

from mien.face.default_face import default_face
from mien.face.head_space import head_space
from mien.fit.head_mesh import _bulging
from mien.fit.landmarks import known_landmarks
from mien.fit.piece_kinds import kinds_of_pieces


def _teeth():
    """The default's teeth, each a piece, and which piece belongs to which row."""
    import scipy.sparse as sparse
    from scipy.sparse.csgraph import connected_components

    points, triangles, labels, rows = [], [], [], []
    for row in ("teeth_upper", "teeth_lower"):
        part = default_face().part(row)
        place = np.unique(np.round(part.vertices, 3), axis=0, return_inverse=True)[1].ravel()
        sides = place[part.triangles]
        ends = sides[:, :2].T.ravel(), sides[:, 1:].T.ravel()
        graph = sparse.coo_matrix((np.ones(2 * len(sides)), ends))
        graph.resize(place.max() + 1, place.max() + 1)
        label = connected_components(graph, directed=False)[1][sides[:, 0]] + len(rows)
        triangles.append(part.triangles + sum(map(len, points)))
        points.append(part.vertices.astype(float))
        labels.append(label)
        rows += [row[6:]] * (label.max() + 1 - len(rows))
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(labels), rows


def test_gums_do_not_part_a_row() -> None:
    space = head_space()
    points, triangles, label, rows = _teeth()
    whole = np.concatenate([space.rest, points])
    faces = np.concatenate([space.triangles, triangles + len(space.rest)])
    labels = np.concatenate([np.zeros(len(space.triangles), int), label + 1])
    places = {name: space.rest[mark.vertex] for name, mark in known_landmarks().items()}
    eyes = {eye.side: np.array(eye.centre) for eye in space.face.eyes}
    found = {labels[p.triangles[0]]: p.kind for p in kinds_of_pieces(whole, faces, labels, eyes, places)}
    assert found[0] == "skin"
    assert [found[number + 1] for number in range(len(rows))] == rows


def test_a_row_of_teeth_bulges() -> None:
    points, triangles, _, _ = _teeth()
    corner = points[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    assert _bulging(corner.mean(axis=1), facing).sum() > 0
    assert _bulging(corner.mean(axis=1), -facing).sum() < 0
