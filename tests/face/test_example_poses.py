"""Parameters from example poses: made-up poses of known parameters come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.deformers import with_tree
from mien.face.example_poses import parameters_of_poses, read_poses
from mien.face.obj import MESH, Mesh, face_of_mesh, write_obj
from mien.face.tree_config import read_tree, write_tree
from mien.face.tree_posing import TreePoser

POINTS = np.random.default_rng(0).uniform(-50, 50, (40, 3))
REST = Mesh(POINTS, np.array([[0, 1, 2], [2, 3, 4]], np.int32), np.zeros((40, 2)), np.ones((40, 3)))
FIELDS = np.random.default_rng(1).normal(size=(2, 40, 3))


def posed(values) -> np.ndarray:
    return POINTS + np.einsum("pk,knd->pnd", np.asarray(values, dtype=float), FIELDS)


def test_two_hidden_motions_are_found_and_every_pose_comes_back() -> None:
    poses = posed([[0, 0], [3, 0], [0, 1], [3, 1], [1.5, 0.2]])
    found = parameters_of_poses(REST, poses, variance=1.0)
    assert len(found.shares) == 2
    assert sum(found.shares) == pytest.approx(1.0)
    assert found.errors.max() < 1e-3
    np.testing.assert_allclose(found.scores.std(axis=0), 1, atol=1e-9)


def test_one_direction_is_the_papers_and_loses_what_it_must() -> None:
    poses = posed([[0, 0], [3, 0], [0, 1], [3, 1]])
    exact, plain = (parameters_of_poses(REST, poses, variance=1.0, directions=n) for n in (3, 1))
    assert len(plain.tree) < len(exact.tree)
    assert plain.errors.max() > 10 * exact.errors.max()
    straight = POINTS + np.arange(3)[:, None, None] * np.outer(np.linspace(0, 1, 40), [1, 2, 0])
    assert parameters_of_poses(REST, straight, directions=1).errors.max() < 1e-3


def test_fewer_components_explain_less() -> None:
    poses = posed(np.random.default_rng(3).normal(size=(6, 2)) * [3, 1])
    found = parameters_of_poses(REST, poses, count=1)
    assert len(found.shares) == 1
    assert 0.7 < found.shares[0] < 1.0


def test_through_files_and_onto_a_face(tmp_path: Path) -> None:
    poses = posed([[0, 0], [3, 0], [0, 1], [3, 1]])
    names = []
    for number, pose in enumerate(poses):
        names.append(tmp_path / f"{number}.obj")
        write_obj(names[-1], pose, REST.triangles)
    rest, read = read_poses(names)
    found = parameters_of_poses(rest, read, variance=1.0)
    write_tree(found.tree, tmp_path / "a.tree", found.about)
    face = face_of_mesh(rest, "x")
    moved = with_tree(face, read_tree(tmp_path / "a.tree").on({MESH: face.parts[0].vertices}))
    names_ = ("pose_mean", "pose_1", "pose_2")
    for pose, score in zip(poses, found.scores, strict=True):
        np.testing.assert_allclose(TreePoser(moved, names_).pose([1, *score]).parts[0].vertices, pose, atol=0.02)


def test_poses_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    write_obj(tmp_path / "a.obj", POINTS, REST.triangles)
    write_obj(tmp_path / "b.obj", POINTS[:-1], REST.triangles)
    write_obj(tmp_path / "c.obj", POINTS, REST.triangles[:1])
    with pytest.raises(InputError, match=r"b\.obj: 39 vertices.*a\.obj has 40"):
        read_poses([tmp_path / "a.obj", tmp_path / "b.obj"])
    with pytest.raises(InputError, match="its faces are not those"):
        read_poses([tmp_path / "a.obj", tmp_path / "c.obj"])
    with pytest.raises(InputError, match="two poses or more"):
        parameters_of_poses(REST, POINTS[None])
    with pytest.raises(InputError, match="all poses are alike"):
        parameters_of_poses(REST, np.array([POINTS, POINTS]))
    with pytest.raises(InputError, match="1 to 1 components, not 4"):
        parameters_of_poses(REST, posed([[0, 0], [1, 0]]), count=4)
