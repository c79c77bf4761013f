"""Normals from rings, beside the plain sum over triangles."""

from __future__ import annotations

import numpy as np
import pytest

from mien.face.normals import normals_of, ring_normals, rings_of


def summed(vertices, triangles, welded):
    """The same by adding up every triangle's cross product at its corners."""
    corner = vertices[triangles].astype(np.float64)
    across, total = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), np.zeros((len(vertices), 3))
    for column in range(3):
        np.add.at(total, welded[triangles[:, column]], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 1e-4, total / np.maximum(length, 1e-4), (0, 0, 1))[welded]


@pytest.mark.parametrize("seed", range(6))
def test_any_soup_of_triangles_has_the_normals_that_the_plain_sum_has(seed):
    """Holes, edges of many triangles, sheets that touch at a point, triangles twice, and welded vertices."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(6, 30))
    vertices = rng.normal(size=(count, 3)).astype(np.float32)
    triangles = np.array([rng.permutation(count)[:3] for _ in range(rng.integers(1, 80))], np.int32)
    welded = np.arange(count, dtype=np.int32)
    vertices[3], vertices[4], welded[3], welded[4] = vertices[1], vertices[2], 1, 2
    found = normals_of(vertices, triangles, welded)
    np.testing.assert_allclose(found, summed(vertices, triangles, welded), atol=2e-4)


def test_a_hub_with_more_spokes_than_are_chained():
    spokes = 300
    angle = np.linspace(0, 2 * np.pi, spokes, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.full(spokes, -0.5)], axis=1)
    vertices = np.vstack([np.zeros((1, 3)), rim]).astype(np.float32)
    others = np.arange(1, spokes + 1)
    triangles = np.stack([np.zeros(spokes, int), others, np.roll(others, -1)], axis=1).astype(np.int32)
    welded = np.arange(len(vertices), dtype=np.int32)
    found = normals_of(vertices, triangles, welded)
    np.testing.assert_allclose(found, summed(vertices, triangles, welded), atol=1e-5)
    np.testing.assert_allclose(found[0], (0, 0, 1), atol=1e-5)


def test_chosen_rings_leave_the_other_normals_alone():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [9, 9, 9]], np.float32)
    rings = rings_of(np.array([[0, 2, 1]], np.int32), np.array([0, 1, 2, 2, 4], np.int32))
    chosen = rings.of(np.array([True, False, True, True, True]))
    normals = np.full_like(vertices, 7)
    ring_normals(vertices, chosen.vertex, chosen.start, chosen.points, chosen.twins, normals)
    np.testing.assert_allclose(normals, [[0, 0, -1], [7, 7, 7], [0, 0, -1], [0, 0, -1], [0, 0, 1]], atol=1e-6)
