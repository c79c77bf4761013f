"""Posing, on faces small enough to reckon by hand."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.face.model import Eye, Face, Material, Part, Target
from mien.face.posing import Poser, eye_rotation, head_rotation, pose_reference

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float32)
# Each side of the cube as two triangles, counter-clockwise from outside.
SIDES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ],
    dtype=np.int32,
)  # fmt: skip


def part(name: str, vertices, triangles=SIDES, head_weight=1.0, targets=None) -> Part:
    vertices = np.asarray(vertices, dtype=np.float32)
    count = len(vertices)
    return Part(
        name, vertices, triangles, np.zeros((count, 2), np.float32), np.ones((count, 3), np.float32),
        Material(name), np.full(count, head_weight, np.float32), targets or {},
    )  # fmt: skip


def face(*parts: Part, eyes=(), pivot=(0.0, 0.0, 0.0)) -> Face:
    return Face("test", parts, tuple(eyes), pivot, {}, "CC0-1.0")


LEFT = Eye("eye", "Left", (30.0, 0.0, 0.0), 20.0, 30.0, 40.0, 50.0)
RIGHT = Eye("eye", "Right", (-30.0, 0.0, 0.0), 20.0, 30.0, 40.0, 50.0)


def test_a_target_moves_its_vertices_by_weight():
    targets = {"jawOpen": Target(np.array([2, 5], np.int32), np.array([[0, -2, 0], [1, 0, 4]], np.float32))}
    posed = Poser(face(part("skin", CORNERS, targets=targets)), ("jawOpen",)).pose([0.5])
    expected = CORNERS.copy()
    expected[2, 1] -= 1.0
    expected[5] += (0.5, 0.0, 2.0)
    np.testing.assert_allclose(posed.parts[0].vertices, expected)


def test_the_normals_of_a_cube_point_out_of_its_corners():
    # One triangle of each side may touch a corner, or two: weigh by hand at a corner that two + two + two share.
    normals = Poser(face(part("skin", CORNERS)), ()).pose([]).parts[0].normals
    np.testing.assert_allclose(normals[0], -np.ones(3) / np.sqrt(3), atol=1e-6)
    assert (np.sum(normals * CORNERS, axis=1) > 1.3).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)


def test_seam_vertices_share_a_normal_and_touching_lips_do_not():
    roof = np.array([[0, 0, 0], [0, 0, 1], [-1, -1, 0], [0, 0, 0], [0, 0, 1], [1, -1, 0]], dtype=np.float32)
    triangles = np.array([[0, 1, 2], [3, 5, 4]], dtype=np.int32)
    seam = Poser(face(part("skin", roof, triangles)), ()).pose([]).parts[0].normals
    np.testing.assert_array_equal(seam[:2], seam[3:5])
    np.testing.assert_allclose(np.abs(seam[0]), (0, 1, 0), atol=1e-6)
    opening = {"jawOpen": Target(np.array([3, 4], np.int32), np.array([[0, -1, 0]] * 2, np.float32))}
    lips = Poser(face(part("skin", roof, triangles, targets=opening)), ("jawOpen",)).pose([0]).parts[0].normals
    assert not np.allclose(lips[0], lips[3])


@pytest.mark.parametrize(
    ("angles", "vector", "expected"),
    [
        ((90, 0, 0), (0, 0, 1), (1, 0, 0)),  # yaw: the face turns to the speaker's left, +x
        ((0, 90, 0), (0, 0, 1), (0, 1, 0)),  # pitch: looks up
        ((0, 0, 90), (0, 1, 0), (1, 0, 0)),  # roll: the crown tips to the left shoulder
        ((90, 90, 0), (0, 0, 1), (0, 1, 0)),  # intrinsic: pitch about the turned axis
        ((90, 0, 90), (0, 1, 0), (0, 0, -1)),
    ],
)
def test_head_rotation(angles, vector, expected):
    np.testing.assert_allclose(head_rotation(*angles) @ vector, expected, atol=1e-12)


def test_the_head_turns_about_its_pivot_and_the_trunk_stays():
    skin = part("skin", [[0, 0, 10], [0, 0, 10], [0, 0, 10]], np.array([[0, 1, 2]], np.int32))
    skin.head_weight[:] = (0.0, 0.5, 1.0)
    posed = Poser(face(skin, pivot=(0, 0, 4)), ("headYaw",)).pose([90]).parts[0].vertices
    np.testing.assert_allclose(posed, [[0, 0, 10], [3, 0, 7], [6, 0, 4]], atol=1e-5)


@pytest.mark.parametrize(("eye", "nose"), [(LEFT, -1), (RIGHT, 1)])
def test_an_eye_turns_inward_to_the_nose(eye, nose):
    gaze = eye_rotation(eye, 0, 0, 0.5, 0) @ (0, 0, 1)
    np.testing.assert_allclose(gaze, (nose * np.sin(np.deg2rad(20)), 0, np.cos(np.deg2rad(20))), atol=1e-12)
    out = eye_rotation(eye, 0, 0, 0, 1) @ (0, 0, 1)
    np.testing.assert_allclose(out[0], -nose * np.sin(np.deg2rad(50)), atol=1e-12)
    np.testing.assert_allclose((eye_rotation(eye, 1, 0, 0, 0) @ (0, 0, 1))[1], np.sin(np.deg2rad(20)), atol=1e-12)
    np.testing.assert_allclose((eye_rotation(eye, 0, 1, 0, 0) @ (0, 0, 1))[1], -np.sin(np.deg2rad(30)), atol=1e-12)


def test_eyes_turn_in_their_sockets_then_with_the_head():
    ball = part("eye", CORNERS + np.float32([30, 0, 0]), head_weight=0.0)  # eyeballs follow the head whatever it says
    poser = Poser(face(ball, eyes=[LEFT], pivot=(0.0, 0.0, 0.0)), ("eyeLookInLeft", "headYaw"))
    turned = CORNERS @ head_rotation(-40, 0, 0).T + (30, 0, 0)
    np.testing.assert_allclose(poser.pose([1, 0]).parts[0].vertices, turned, atol=1e-5)
    np.testing.assert_allclose(poser.pose([1, 25]).parts[0].vertices, turned @ head_rotation(25, 0, 0).T, atol=1e-5)


def random_face(seed: int) -> Face:
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(60, 3)).astype(np.float32) * 20
    triangles = rng.permuted(np.tile(np.arange(60, dtype=np.int32), (100, 1)), axis=1)[:, :3]
    targets = {
        name: Target(rng.permutation(60)[:20].astype(np.int32), rng.normal(size=(20, 3)).astype(np.float32))
        for name in ("jawOpen", "eyeBlinkLeft", "tongueTipUp")
    }
    skin = part("skin", vertices, np.ascontiguousarray(triangles), targets=targets)
    skin.head_weight[:] = rng.uniform(size=60)
    return face(skin, part("eye", CORNERS), eyes=[LEFT], pivot=(0.0, -60.0, -20.0))


@pytest.mark.parametrize("seed", range(3))
def test_kernel_and_reference_agree(seed):
    poser = Poser(random_face(seed), ALL)
    row = np.random.default_rng(seed + 10).uniform(0, 1, len(ALL))
    row[-3:] = (20, -15, 8)
    for fast, plain in zip(poser.pose(row).parts, pose_reference(poser, row).parts, strict=True):
        np.testing.assert_allclose(fast.vertices, plain.vertices, atol=2e-4)
        np.testing.assert_allclose(fast.normals, plain.normals, atol=2e-3)
        assert fast.vertices.dtype == fast.normals.dtype == np.float32


def test_the_same_row_gives_the_same_bits():
    poser, row = Poser(random_face(1), ALL), np.linspace(0, 1, len(ALL))
    first, second = poser.pose(row), poser.pose(row)
    assert all(a.normals.tobytes() == b.normals.tobytes() for a, b in zip(first.parts, second.parts, strict=True))


def test_unknown_channels_and_wrong_rows_are_refused():
    with pytest.raises(InputError, match="did you mean 'jawOpen'"):
        Poser(random_face(0), ("jawOpne",))
    with pytest.raises(InputError, match="repeat"):
        Poser(random_face(0), ("jawOpen", "jawOpen"))
    with pytest.raises(InputError, match=r"2 channels.*\(3,\)"):
        Poser(random_face(0), ("jawOpen", "headYaw")).pose([0, 1, 2])
