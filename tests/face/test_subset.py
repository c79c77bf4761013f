import numpy as np

from mien.face.library import load_face
from mien.face.subset import nearest_to_middle, subset, without_flat


def test_the_nearest_to_the_middle_of_each_group() -> None:
    points = np.array([[0, 0, 0], [9, 0, 0], [4, 0, 0], [7, 7, 7]], np.float32)
    assert nearest_to_middle(points, np.array([1, 1, 1, 0])).tolist() == [3, 2]


def test_flat_triangles_go() -> None:
    assert without_flat(np.array([[0, 1, 2], [3, 3, 1], [4, 5, 4], [6, 7, 7]])).tolist() == [[0, 1, 2]]


def test_a_subset_keeps_what_its_vertices_have() -> None:
    part = load_face().part("tongue")
    order = np.unique(part.triangles[:10])
    less = subset(part, order, np.searchsorted(order, part.triangles[:10]))
    assert np.array_equal(less.vertices[less.triangles], part.vertices[part.triangles[:10]])
    for name, target in less.targets.items():
        moved, given = np.zeros_like(part.vertices), part.targets[name]
        moved[given.vertices] = given.offsets
        assert np.array_equal(moved[order[target.vertices]], target.offsets)
