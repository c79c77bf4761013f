"""Rows of teeth are told apart, gums and all, and turned outward."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.face.default_face import default_face
from mien.face.head_space import head_space
from mien.fit.head_mesh import _bulging
from mien.fit.landmarks import known_landmarks
from mien.fit.piece_kinds import Piece, _Mouth, _upper_and_lower, kinds_of_pieces


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


def test_a_tooth_with_its_root_is_no_gums() -> None:
    corners = {"lip_corner_left": (22.0, -70.0, 0.0), "lip_corner_right": (-22.0, -70.0, 0.0)}
    eyes = {"eye_outer_left": (44.0, 0.0, 0.0), "eye_outer_right": (-44.0, 0.0, 0.0)}
    mouth = _Mouth.of({name: np.array(place) for name, place in (corners | eyes).items()})
    corner = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3)
    middle = np.array([5.0, -62.0, -15.0])
    assert mouth.kind(middle + corner * (8.5, 28.0, 9.5)) == "tooth"  # an incisor of the ICT head, 0.64 of this mouth
    assert mouth.kind(middle + corner * (60.0, 28.0, 30.0)) == "gums"


def test_a_row_of_teeth_bulges() -> None:
    points, triangles, _, _ = _teeth()
    corner = points[triangles]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    assert _bulging(corner.mean(axis=1), facing).sum() > 0
    assert _bulging(corner.mean(axis=1), -facing).sum() < 0


def test_teeth_of_a_head_that_nods() -> None:
    places = {"lip_corner_left": (22.0, -70.0, 0.0), "lip_corner_right": (-22.0, -70.0, 0.0)}
    places |= {"eye_outer_left": (44.0, 0.0, 0.0), "eye_outer_right": (-44.0, 0.0, 0.0)}
    mouth = _Mouth.of({name: np.array(place) for name, place in places.items()})
    corner = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3) * (7, 9, 7)
    depth = np.repeat(np.linspace(25, -20, 7), 2)  # seven on each side of each row; they rise by 14 mm to the back
    upper = [corner + np.array([side, -65 - 0.3 * z, z]) for side, z in zip([9, -9] * 7, depth, strict=True)]
    lower = [tooth - (0, 9.5, 0) for tooth in upper]
    pieces = [Piece("tooth", np.zeros(1, np.int64), np.zeros(3), 0.0)] * 28
    for raised in (0.0, 4.0):  # corners of a smile
        smiling = replace(mouth, middle=mouth.middle + np.array([0.0, raised, 0.0]))
        found = [piece.kind for piece in _upper_and_lower(pieces, upper + lower, smiling)]
        assert found == ["upper"] * 14 + ["lower"] * 14


def test_a_tongue_is_no_tooth() -> None:
    space = head_space()
    mouth = _Mouth.of({name: space.rest[mark.vertex] for name, mark in known_landmarks().items()})
    assert mouth.kind(default_face().part("tongue").vertices.astype(float)) == "tongue"
    assert mouth.kind(default_face().part("teeth_lower").vertices.astype(float)) == "tooth"
