"""Fewer triangles for small pictures, on a small sheet and a few ribbons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.face.model import Face, Material, Part, Target
from mien.face.normals import normals_of
from mien.face.render.detail import Detail


def part(name, vertices, triangles) -> Part:
    ones = np.ones((len(vertices), 3), np.float32)
    vertices, triangles = np.asarray(vertices, np.float32), np.asarray(triangles, np.int32)
    return Part(name, vertices, triangles, ones[:, :2].copy(), ones, Material(name), ones[:, 0].copy())


def dome(side=40) -> Part:
    """A bulged square of 60 mm, side x side vertices."""
    x, y = np.meshgrid(np.linspace(-30, 30, side), np.linspace(-30, 30, side))
    points = np.stack([x, y, 10 * np.cos(x / 20) * np.cos(y / 20)], axis=-1).reshape(-1, 3)
    k = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    return part("skin", points, np.concatenate([np.c_[k, k + 1, k + side], np.c_[k + 1, k + side + 1, k + side]]))


def strands(count=100, points=8) -> Part:
    rng = np.random.default_rng(0)
    root = np.c_[rng.uniform(-30, 30, (count, 2)), np.zeros(count)]
    line = root[:, None] + np.arange(points)[:, None] * (0.0, -5.0, 0.0)
    sides = [line[:, :-1] + (offset, 0.0, 0.0) for offset in (-0.5, 0.5)]
    body = np.stack(sides, axis=2).reshape(count, -1, 3)
    each = 2 * points - 1
    strip = [t for k in range(0, each - 3, 2) for t in ((k, k + 1, k + 2), (k + 1, k + 3, k + 2))]
    strip.append((each - 3, each - 2, each - 1))
    triangles = np.array(strip)[None] + each * np.arange(count)[:, None, None]
    return part("hair", np.concatenate([body, line[:, -1:]], axis=1).reshape(-1, 3), triangles.reshape(-1, 3))


def face(*parts: Part) -> Face:
    return Face("test", parts, (), (0.0, 0.0, 0.0), {}, "CC0-1.0")


def test_what_is_larger_than_a_pixel_stays_whole():
    assert Detail.of(face(dome(), strands()), 0.05) is None


def test_a_small_picture_has_fewer_triangles_on_the_same_surface():
    whole = dome()
    detail = Detail.of(face(whole), 2.0)
    coarse = detail.face.parts[0]
    assert len(coarse.triangles) < 0.5 * len(whole.triangles)
    welded = np.arange(len(whole.vertices), dtype=np.int32)
    moved = whole.vertices + np.float32([1, 2, 3])
    vertices, normals = detail.posed(moved, normals_of(moved, whole.triangles, welded))
    np.testing.assert_allclose(vertices, coarse.vertices + np.float32([1, 2, 3]), atol=1e-5)
    np.testing.assert_allclose(normals, normals_of(whole.vertices, whole.triangles, welded)[detail.kept], atol=1e-5)
    rim = np.abs(whole.vertices[:, :2]).max(axis=1) > 29.9
    assert set(np.flatnonzero(rim)) <= set(detail.kept)  # the outline is as it was


def test_vertices_that_part_stay_two():
    sheet = dome()
    upper = np.flatnonzero(sheet.vertices[:, 1] > 0).astype(np.int32)
    opening = {"jawOpen": Target(upper, np.tile(np.float32([0, 20, 0]), (len(upper), 1)))}
    detail = Detail.of(face(replace(sheet, targets=opening)), 3.0)
    moved = sheet.vertices.copy()
    moved[upper, 1] += 20
    edge = detail.posed(moved, moved)[0][:, 1]
    assert edge[edge > 10].min() < 21.6
    assert edge[edge < 10].max() > -1.6


def test_strands_become_fewer_and_cover_as_much():
    whole = strands()
    detail = Detail.of(face(whole), 0.4)
    vertices, _ = detail.posed(whole.vertices, whole.vertices)
    width = vertices[1, 0] - vertices[0, 0]
    count = len(vertices) // 15
    assert 1.5 < width < 2.3  # mm; was 1
    assert 0.8 < count * width / 100 < 1.2
    tips = vertices[14::15]
    np.testing.assert_allclose(tips, whole.vertices[detail.kept[14::15]])
