"""Texture coordinates for bare heads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.head_space import head_space
from mien.face.model import Target
from mien.fit.unwrap import flat, layout_picture, unwrapped
from tests.fit.heads import icosahedron, other_shape


def bare_part(vertices, triangles):
    """The default skin's material on another surface, with one target."""
    count = len(vertices)
    target = Target(np.arange(count, dtype=np.int32), np.tile([[1.0, 2.0, 3.0]], (count, 1)).astype(np.float32))
    return replace(
        head_space().skin, vertices=np.asarray(vertices, np.float32), triangles=np.asarray(triangles, np.int32),
        uv=np.zeros((count, 2), np.float32), colours=np.ones((count, 3), np.float32),
        head_weight=np.ones(count, np.float32), targets={"jawOpen": target},
    )  # fmt: skip


def test_a_flat_round_surface_stays_as_it_is():
    """Mean value coordinates give back what is flat already."""
    ring, rounds = 24, 5
    turn = 2 * np.pi * np.arange(ring) / ring
    points = [(0.0, 0.0, 0.0)]
    for k in range(1, rounds + 1):
        points += [(k * np.sin(a), k * np.cos(a), 0.0) for a in turn]
    triangles = [(0, 1 + (i + 1) % ring, 1 + i) for i in range(ring)]
    for k in range(rounds - 1):
        for i in range(ring):
            a, b = 1 + k * ring + i, 1 + k * ring + (i + 1) % ring
            triangles += [(a, b, b + ring), (a, b + ring, a + ring)]
    points, top = np.array(points), 1 + (rounds - 1) * ring
    found = flat(points, np.array(triangles), np.array([top]))
    wanted = 0.5 + 0.48 / rounds * points[:, :2] * [1, -1]
    assert np.abs(found - wanted).max() < 1e-6


def test_no_triangle_of_a_made_head_turns_over():
    part = bare_part(other_shape(), head_space().triangles)
    done = unwrapped(part)
    assert done.turned == 0
    assert done.spread < 12
    more = len(done.part.vertices) - len(part.vertices)
    assert 20 < more < 200  # the seam's copies, behind all others
    assert np.array_equal(done.part.vertices[done.part.triangles], part.vertices[part.triangles])
    assert len(done.part.targets["jawOpen"].vertices) == len(done.part.vertices)
    left = done.part.uv[np.argmax(part.vertices[:, 0])]
    assert left[0] > 0.6  # the speaker's left is on the picture's right
    assert done.part.uv.min() >= 0
    assert done.part.uv.max() <= 1
    assert (layout_picture(done.part, 200) < 100).any()


def test_a_closed_ball_is_cut_and_laid_flat():
    assert unwrapped(bare_part(*icosahedron(2))).turned == 0


def test_three_faces_at_an_edge_are_refused():
    fin = [(0.0, 0, 0), (0, 1, 0), (1, 0, 0), (-1, 0, 0), (0, 0, 1)]
    with pytest.raises(InputError, match="cannot be laid flat"):
        unwrapped(bare_part(np.array(fin) * 10, [(0, 2, 1), (0, 1, 3), (0, 1, 4)]))
