"""Lips and eyes that a mesh holds together, on a flat sheet."""

from __future__ import annotations

import numpy as np

from mien.fit.eye_cut import cut_out_eye, eye_patch, inside_outline
from mien.fit.lip_cut import cut_apart
from mien.fit.shape_transfer import strays


def sheet(size: int = 21):
    """A flat grid in front of the camera, millimetres, and its triangles."""
    x, y = np.meshgrid(np.arange(size) - size // 2, np.arange(size) - size // 2)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1).astype(float)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return points, triangles.astype(np.int32)


def circle(radius: float, count: int = 40):
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn], axis=1)


def test_inside_of_an_outline():
    points = np.random.default_rng(0).uniform(-6, 6, (500, 2))
    inside = inside_outline(points, circle(5.0, 400)[:, :2])
    clear = np.abs(np.hypot(*points.T) - 5) > 0.05
    np.testing.assert_array_equal(inside[clear], np.hypot(*points.T)[clear] < 5)


def test_an_eye_is_cut_out_to_its_margin():
    points, triangles = sheet()
    cut = cut_out_eye(points, triangles, np.arange(len(points), dtype=np.int32), circle(5.0))
    assert cut.removed == eye_patch(points, triangles, circle(5.0)).sum() > 100
    used = np.unique(cut.triangles)
    assert np.hypot(*cut.vertices[used, :2].T).min() > 4.9  # nothing is left inside
    moved = np.linalg.norm(cut.vertices - points, axis=1)
    assert 0 < moved.max() < 1.0


def test_what_looks_away_is_no_eye():
    points, triangles = sheet()
    assert not eye_patch(points, triangles[:, ::-1], circle(5.0)).any()


def test_lips_are_cut_from_corner_to_corner():
    points, triangles = sheet()
    side = np.where(points[:, 1] >= 0, 1, -1).astype(np.int8)
    welded = np.arange(len(points), dtype=np.int32)
    new, stands, copied, known = cut_apart(points, triangles, welded, side, (-8.0, 8.0))
    assert len(copied)
    assert np.abs(points[copied, 0]).max() < 8
    assert len(stands) == len(known) == len(points) + len(copied)
    below = known[new].max(axis=1) < 0
    assert (new[below] >= len(points)).any()  # the lower lip has vertices of its own
    middle = (np.abs(points[:, 0]) < 6) & (np.abs(points[:, 1]) < 2)
    sides = known[new[np.isin(new % len(points), np.flatnonzero(middle)).all(axis=1)]]
    assert (np.ptp(sides, axis=1) == 0).all()  # no triangle joins them there


def test_a_vertex_that_leaves_all_its_neighbours_is_a_stray_and_a_cut_is_none():
    points, triangles = sheet()
    moves = np.where(points[:, 1:2] > 2, [[0.0, 10, 0]], 0.0)  # like lips that part
    assert not strays(points, triangles, moves).any()
    number = int(np.argmin(np.abs(points - [4, -5, 0]).sum(axis=1)))
    moves[number] = (0, -10, 0)
    assert np.flatnonzero(strays(points, triangles, moves)).tolist() == [number]
