"""A head whose truth is known: the default skin reshaped, in metres, z up, its vertices and triangles shuffled."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.face.storage import read_face, write_face
from mien.fit.fit_head import fit_head
from mien.fit.head_mesh import outward
from mien.fit.head_search import find_head
from mien.fit.landmarks import known_landmarks
from tests.fit.heads import Z_UP, icosahedron, marks_of, mesh_of, other_shape


@pytest.fixture(scope="module")
def shuffled():
    shape = other_shape()
    order = np.random.default_rng(0).permutation(len(shape))
    number = np.argsort(order)
    moved = shape @ Z_UP.T / 1000 + 0.25
    mesh = mesh_of(moved[order], number[head_space().triangles].astype(np.int32))
    return shape, order, fit_head(mesh, marks_of(moved), "shuffled")


def test_the_head_is_found_without_landmarks():
    """On a mesh in metres, z up, its triangles turned round."""
    shape = other_shape()
    moved = shape @ Z_UP.T / 1000 + 0.25
    mesh = mesh_of(moved, head_space().triangles[:, ::-1])
    found = find_head(mesh.vertices, outward(mesh.vertices, mesh.triangles), head_space(), "a")
    away = [1000 * np.linalg.norm(found.places[n] - moved[m.vertex]) for n, m in known_landmarks().items()]
    assert np.median(away) < 3.0
    assert max(away) < 12.0


def test_what_is_no_head_is_refused():
    ball = icosahedron(2)
    with pytest.raises(InputError, match="no head was found"):
        fit_head(mesh_of(*ball))


def test_unit_and_axes_are_found(shuffled):
    shape, order, done = shuffled
    assert done.alignment.unit == "m"
    skin = done.face.part("skin").vertices
    gap = skin - shape[order]
    np.testing.assert_allclose(gap - gap.mean(0), 0, atol=0.02)  # turned upright, in millimetres, nothing else changed


def test_eyes_lie_at_the_origin_and_inside_the_lids(shuffled):
    _, _, done = shuffled
    centres = np.array([eye.centre for eye in done.face.eyes])
    np.testing.assert_allclose(centres.mean(0), 0, atol=0.3)


def test_shapes_are_those_of_the_reshaped_default_face(shuffled):
    shape, order, done = shuffled
    truth = reshaped_face(head_space(), shape, "truth").targets
    got = done.face.part("skin").targets
    assert set(head_space().skin.targets) <= set(got)
    for name in ("jawOpen", "mouthSmileLeft", "eyeBlinkRight", "browInnerUp", "mouthFunnel"):
        offsets = np.zeros_like(shape)
        offsets[got[name].vertices] = got[name].offsets
        error = np.linalg.norm(offsets - truth[name][order], axis=1)
        moving = np.linalg.norm(truth[name][order], axis=1) > 0.5
        assert error[moving].mean() < 0.5, name


def test_lips_and_lids_meet(shuffled):
    _, _, done = shuffled
    assert done.lip_gap < 1.2  # (at the very corners)
    assert done.lid_gap < 1.0


def test_lips_move_apart_by_their_own_side(shuffled):
    """No vertex of the upper lip goes with the jaw."""
    shape, order, done = shuffled
    number = np.argsort(order)
    jaw = np.zeros_like(shape)
    target = done.face.part("skin").targets["jawOpen"]
    jaw[target.vertices] = target.offsets
    sites = head_space().face.sites
    truth = reshaped_face(head_space(), shape, "truth").targets["jawOpen"]
    for name in ("lip_upper_inner", "lip_upper_inner_l1", "lip_upper_inner_r2"):
        assert abs(jaw[number[sites[name][1]], 1] - truth[sites[name][1], 1]) < 1.5
    for name in ("lip_lower_inner", "lip_lower_inner_l1", "lip_lower_inner_r2"):
        assert jaw[number[sites[name][1]], 1] < -12.0


def test_the_face_can_be_kept(shuffled, tmp_path):
    _, _, done = shuffled
    write_face(done.face, tmp_path / "head.npz")
    again = read_face(tmp_path / "head.npz")
    assert [part.name for part in again.parts] == [part.name for part in done.face.parts]


def test_joined_lips_are_cut_apart():
    """A grid of the foremost surface, as a scan gives it, holds the lips together."""
    from mien.face.surface import Surface

    space = head_space()
    outer = np.flatnonzero((space.inside_mouth < 0.5) & (space.rest[:, 2] > -30) & (np.abs(space.rest[:, 1]) < 108))
    chosen = np.isin(space.triangles, outer).all(axis=1)
    surface = Surface(space.rest, space.triangles, chosen)
    x, y = np.meshgrid(np.arange(-56, 57, 2.4), np.arange(-104, 60, 2.4))
    start = np.stack([x.ravel(), y.ravel(), np.full(x.size, 60.0)], axis=1)
    for _ in range(40):  # slide towards the face along z
        found = surface.closest(start, np.tile([0.0, 0, 1], (len(start), 1)))
        start[:, 2] -= 0.7 * (start[:, 2] - found.points[:, 2])
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    marks = marks_of(space.rest, ("eye_", "lip", "lid"))
    done = fit_head(mesh_of(start, triangles.astype(np.int32)), marks, "mask")
    assert any("cut apart" in note.message for note in done.notes)
    assert any(part.name == "mouth" for part in done.face.parts)
    assert len(done.kept) > x.size


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda marks: _swapped(marks, marks), "left and right are swapped in all landmarks"),
        (lambda marks: _swapped(marks, ("eye_outer_left",)), "eye_outer_left and eye_outer_right look swapped"),
        (lambda marks: marks | {"chin": (0.0, 90.0, 20.0)}, "chin lies"),
        (lambda marks: marks | {"chin": (99999.0,)}, "vertex 99999 is not among"),
        (lambda marks: dict.fromkeys(marks, (1.0, 2.0, 3.0)), "on one point or line"),
    ],
)
def test_landmarks_that_cannot_be_are_refused(change, told):
    space = head_space()
    with pytest.raises(InputError, match=told):
        fit_head(mesh_of(space.rest), change(marks_of(space.rest)))


def _swapped(marks, names):
    from mien.fit.landmarks import other_side

    changed = dict(marks)
    for name in names:
        if other_side(name) in marks:
            changed[name], changed[other_side(name)] = marks[other_side(name)], marks[name]
    return changed


def test_a_mesh_without_area_is_refused():
    points = np.zeros((100, 3))
    with pytest.raises(InputError, match="no faces with an area"):
        fit_head(mesh_of(points, np.array([[0, 1, 2]], np.int32)), marks_of(head_space().rest))


def test_landmarks_of_another_mesh_are_refused():
    space = head_space()
    with pytest.raises(InputError, match="off the mesh"):
        fit_head(mesh_of(space.rest + np.array([0, 200.0, 0])), marks_of(space.rest))
