from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mien.face.surface import Surface, _grid, edges_of, vertex_normals
from mien.face.warps import SmoothWarp, similarity_between, spread_points

# Two squares, one over the other, that face each other: a shut mouth.
_LOWER = np.array([[0, 0, 0], [10, 0, 0], [10, 0, 10], [0, 0, 10.0]])
_UPPER = _LOWER + np.array([0, 0.2, 0])
VERTICES = np.concatenate([_LOWER, _UPPER])
TRIANGLES = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]], np.int32)


def test_the_side_that_faces_alike_is_found():
    surface = Surface(VERTICES, TRIANGLES)
    up, down = np.array([[0, 1.0, 0]]), np.array([[0, -1.0, 0]])
    point = np.array([[5.0, 0.18, 5.0]])  # nearer to the upper one
    assert surface.closest(point, up).points[0, 1] == 0.0
    assert surface.closest(point, down).points[0, 1] == 0.2


@given(st.lists(st.floats(-5, 15), min_size=3, max_size=3))
def test_closest_point_against_a_dense_search(place):
    surface = Surface(VERTICES[:4], TRIANGLES[:2])
    point = np.array([place])
    found = surface.closest(point, np.array([[0, 1.0, 0]]))
    want = np.array([np.clip(place[0], 0, 10), 0, np.clip(place[2], 0, 10)])
    np.testing.assert_allclose(found.points[0], want, atol=1e-9)
    np.testing.assert_allclose(found.matrix(surface.triangles, 4) @ VERTICES[:4], found.points, atol=1e-9)


def test_cells_of_a_triangle():
    grid = _grid(3)
    assert len(grid) == 9
    np.testing.assert_allclose(grid.sum(1), 1)
    assert grid.min() > 0


def test_edges_and_normals():
    assert len(edges_of(TRIANGLES[:2])) == 5
    np.testing.assert_allclose(vertex_normals(VERTICES, TRIANGLES)[:4], [[0, 1, 0]] * 4, atol=1e-12)


def test_similarity_is_found_again():
    chance = np.random.default_rng(0)
    points = chance.normal(0, 50, (12, 3))
    turn = np.linalg.qr(chance.normal(0, 1, (3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    fit = similarity_between(points, 3 * points @ turn.T + [1, 2, 3])
    assert abs(fit.scale - 3) < 1e-9
    np.testing.assert_allclose(fit.turn, turn, atol=1e-9)
    assert fit.residual < 1e-9
    flipped = points * [-1, 1, 1]
    assert similarity_between(points, flipped, mirrored=True).residual < 1e-9


def test_a_warp_goes_through_its_points_and_keeps_an_affine_map():
    chance = np.random.default_rng(1)
    points = chance.normal(0, 50, (20, 3))
    moved = points + chance.normal(0, 4, points.shape)
    np.testing.assert_allclose(SmoothWarp(points, moved)(points), moved, atol=1e-6)
    shift = SmoothWarp(points, points + np.array([1, 2, 3]))
    np.testing.assert_allclose(shift(np.array([[400.0, 0, 0]])), [[401, 2, 3]], atol=1e-6)


def test_spread_points_are_all_different():
    points = np.random.default_rng(2).normal(0, 1, (50, 3))
    assert len(set(spread_points(points, 20))) == 20
