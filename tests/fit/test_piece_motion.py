"""A tongue that is one piece with the gums is found and moves."""

from __future__ import annotations

import numpy as np
import pytest

from mien.face.default_face import default_face
from mien.face.head_space import head_space
from mien.fit.head_mesh import HeadMesh
from mien.fit.piece_kinds import Piece
from mien.fit.piece_motion import PieceMotion


@pytest.mark.parametrize("with_tongue", [True, False])
def test_a_tongue_in_the_gums(with_tongue: bool) -> None:
    face, space = default_face(), head_space()
    tongue = face.part("tongue").vertices.astype(float)
    deep = np.array([[x, -95.0, z] for x in np.linspace(-15, 15, 8) for z in np.linspace(-20, 15, 8)])  # a flat floor
    rows = [(8 * i + j + k, 8 * i + j + 1 + 8 * k, 8 * i + j + 8) for i in range(7) for j in range(7) for k in (0, 1)]
    floor = np.array(rows, np.int32)
    points, triangles = deep, floor
    if with_tongue:
        points = np.concatenate([deep, tongue])
        triangles = np.concatenate([floor, face.part("tongue").triangles + len(deep)])
    head = HeadMesh(
        points, triangles, np.arange(len(points), dtype=np.int32),
        (Piece("gums", np.arange(len(triangles)), points.mean(0), 0.0),), np.arange(len(points)), (),
    )  # fmt: skip
    motion = PieceMotion(head, face, space.rest, {"jawOpen": np.zeros_like(space.rest)})
    assert motion.tongue_in(head.pieces[0]) is with_tongue
    targets = motion.of(head.pieces)
    assert ("tongueOut" in targets) is with_tongue
    if with_tongue:
        moved = np.zeros_like(points)
        moved[targets["tongueOut"].vertices] = targets["tongueOut"].offsets
        tip = len(deep) + np.argmax(tongue[:, 2])
        assert moved[tip, 2] > 8.0
        assert np.abs(moved[: len(deep)]).max() < 1.0
