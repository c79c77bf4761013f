"""The parameter tree against cases reckoned by hand (Frydrych et al. 2003, section 2.2)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.channels import ALL, WEIGHTS
from mien.core.errors import InputError
from mien.face.deformers import deformed_by, lost_by_targets, poser_for, with_tree
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.obj import MESH, Mesh, face_of_mesh
from mien.face.parameter_tree import Influence, Parameter, ParameterTree, rotation_matrix, translation_matrix
from mien.face.posing import Poser
from mien.face.tree_of_face import jaw_motion, translations_of, tree_of_face
from mien.face.tree_posing import TreePoser
from tests.faces import tiny_face


def on(weights: dict[int, float]) -> dict[str, Influence]:
    return {MESH: Influence(np.array(list(weights), np.int32), np.array(list(weights.values()), np.float32))}


def turn(name: str, weights: dict[int, float], parent: str | None = None, axis=(0, 1, 0), pivot=(0, 0, 0)) -> Parameter:
    return Parameter(name, "rotation", axis, pivot, parent, True, {name: 1.0}, influences=on(weights))


def slide(name: str, vector, weights: dict[int, float], parent: str | None = None) -> Parameter:
    return Parameter(name, "translation", vector, parent=parent, drives={name: 1.0}, influences=on(weights))


def test_a_translation_moves_by_weight_and_value() -> None:
    """Equation 1: P + w (P T(v) - P); half of twice (0, 0, 3)."""
    tree = ParameterTree([slide("a", (0, 0, 3), {0: 0.5})])
    np.testing.assert_allclose(tree.deform(MESH, [[1, 2, 3], [1, 2, 3]], [2.0]), [[1, 2, 6], [1, 2, 3]])


def test_a_rotation_is_right_handed_about_its_pivot_and_weighs_along_the_chord() -> None:
    """A quarter turn about +y takes +z to +x; at half weight the point stands in the middle of the chord."""
    points = [[0, 0, 20], [0, 0, 20]]
    tree = ParameterTree([turn("a", {0: 1.0}, pivot=(0, 0, 10)), slide("b", (0, 0, 0), {1: 1.0})])
    np.testing.assert_allclose(tree.deform(MESH, points, tree.values({"a": 90}))[0], [10, 0, 10], atol=1e-12)
    half = ParameterTree([Parameter("a", "rotation", (0, 1, 0), (0, 0, 10), drives={"a": 1}, influences=on({0: 0.5}))])
    np.testing.assert_allclose(half.deform(MESH, points, [90])[0], [5, 0, 15], atol=1e-12)


def test_several_surface_parameters_are_superposed() -> None:
    """Equation 2: the moves of single parameters add up."""
    tree = ParameterTree([slide("a", (1, 0, 0), {0: 1.0}), slide("b", (0, 2, 0), {0: 0.25})])
    np.testing.assert_allclose(tree.deform(MESH, [[5, 5, 5]], [3, 4]), [[8, 7, 5]])


def test_children_move_with_their_parents() -> None:
    """T'_child = T_child T_parent, row vectors: the jaw turns about x first, then the head about y.

    (0, 0, 10): -90 degrees about x take +z to +y ... the jaw's +90 take it to -y, which the head leaves alone.
    (10, 0, 0) with the jaw at 0: the head's 90 degrees take +x to -z.
    """
    tree = ParameterTree([turn("head", {}), turn("jaw", {0: 1.0, 1: 1.0}, "head", axis=(1, 0, 0))])
    moved = tree.deform(MESH, [[0, 0, 10], [10, 0, 0]], tree.values({"head": 90, "jaw": 90}))
    np.testing.assert_allclose(moved, [[0, -10, 0], [0, 0, -10]], atol=1e-12)


def test_skeletal_weights_are_normalised_and_unclaimed_vertices_stay() -> None:
    """Weights 1 and 3 become a quarter and three quarters; vertex 1 has none and stays."""
    slides = [
        Parameter("a", "translation", (4, 0, 0), skeletal=True, influences=on({0: 1.0})),
        Parameter("b", "translation", (0, 4, 0), skeletal=True, influences=on({0: 3.0})),
    ]
    tree = ParameterTree(slides)
    np.testing.assert_allclose(tree.skeletal_weights(MESH, 2), [[0.25, 0], [0.75, 0]])
    np.testing.assert_allclose(tree.deform(MESH, [[0, 0, 0], [7, 7, 7]], [1, 1]), [[1, 3, 0], [7, 7, 7]])


def test_a_leaf_moves_in_the_axes_of_its_turned_parent() -> None:
    """Head turned by 90 degrees about y: a leaf that moves +z at rest now moves +x."""
    tree = ParameterTree([turn("head", {0: 1.0}), slide("smile", (0, 0, 2), {0: 1.0}, "head")])
    moved = tree.deform(MESH, [[0, 0, 10]], tree.values({"head": 90, "smile": 1}))
    np.testing.assert_allclose(moved, [[12, 0, 0]], atol=1e-12)


def test_the_literal_second_stage_turns_vertices_twice() -> None:
    """Frydrych et al. 2003: a leaf at zero with weight .5 under a head turned by 20 degrees moves a vertex 80 mm off
    by 13.9 mm."""
    parameters = [turn("head", {0: 1.0}), slide("smile", (0, 0, 2), {0: 0.5}, "head")]
    values = {"head": 20.0, "smile": 0.0}
    once = ParameterTree(parameters[:1]).deform(MESH, [[0, 0, 80]], [20.0])
    corrected, literal = (ParameterTree(parameters, literal=literal) for literal in (False, True))
    np.testing.assert_allclose(corrected.deform(MESH, [[0, 0, 80]], corrected.values(values)), once, atol=1e-12)
    twice = literal.deform(MESH, [[0, 0, 80]], literal.values(values))
    assert np.linalg.norm(twice - once) == pytest.approx(0.5 * 2 * 80 * np.sin(np.deg2rad(10)), abs=1e-9)
    assert np.linalg.norm(twice - once) == pytest.approx(13.9, abs=0.05)


angles = st.floats(-80, 80)


@given(st.tuples(angles, angles, angles), st.lists(st.floats(-1, 1), min_size=6, max_size=6))
def test_a_leaf_at_zero_changes_nothing_under_any_head_turn(turns, weights) -> None:
    rest = np.random.default_rng(0).normal(0, 60, (6, 3))
    everywhere = dict.fromkeys(range(6), 1.0)
    chain = [
        turn("yaw", {}, pivot=(0, -90, -40)),
        turn("pitch", {}, "yaw", axis=(1, 0, 0)),
        turn("roll", everywhere, "pitch", axis=(0, 0, 1)),
    ]
    leaf = slide("leaf", (3, 4, 5), dict(enumerate(weights)), "roll")
    spin = Parameter("spin", "rotation", (1, 1, 0), (0, 5, 9), "roll", False, {"spin": 1}, None, on({0: 0.7}))
    values = dict(zip(("yaw", "pitch", "roll"), turns, strict=True))
    with_leaves = ParameterTree([*chain, leaf, spin])
    bare = ParameterTree(chain)
    np.testing.assert_allclose(
        with_leaves.deform(MESH, rest, with_leaves.values(values)),
        bare.deform(MESH, rest, bare.values(values)),
        atol=1e-9,
    )


def test_limits_and_several_drives() -> None:
    parameter = Parameter("a", "rotation", (0, 1, 0), drives={"x": 10.0, "y": -5.0}, limits=(-3, 12))
    assert parameter.value({"x": 1.0, "y": 0.5}) == 7.5
    assert parameter.value({"x": 2.0}) == 12
    assert parameter.value({"y": 2.0}) == -3


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ([slide("a", (1, 0, 0), {}), slide("a", (1, 0, 0), {})], "a: the name is taken twice"),
        ([slide("a", (1, 0, 0), {}, "b")], "its parent 'b' is not in the tree"),
        ([turn("a", {}, "b"), turn("b", {}, "a")], "run in a circle"),
        ([turn("a", {}, "a")], "run in a circle"),
        ([slide("a", (1, 0, 0), {}), slide("b", (1, 0, 0), {}, "a")], "only skeletal ones have children"),
        ([turn("a", {}, axis=(0, 0, 0))], "no length"),
        ([turn("a", {0: -1.0})], "cannot be negative"),
        ([slide("a", (np.nan, 0, 0), {})], "not finite"),
    ],
)
def test_faulty_trees_are_refused(parameters, told) -> None:
    with pytest.raises(InputError, match=told):
        ParameterTree(parameters)


def grid() -> Face:
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0))
    points = np.column_stack([x.ravel(), y.ravel(), np.sin(x.ravel())]) * 20
    a = (np.arange(4)[:, None] * 6 + np.arange(5)).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + 7], 1), np.stack([a, a + 7, a + 6], 1)]).astype(np.int32)
    return face_of_mesh(Mesh(points, triangles, np.zeros((30, 2)), np.ones((30, 3))), "grid")


@pytest.mark.parametrize("seed", range(3))
def test_the_fast_poser_agrees_with_the_equations(seed: int) -> None:
    rng = np.random.default_rng(seed)

    def some() -> dict[int, float]:
        return dict(zip(rng.permutation(30)[:12].tolist(), rng.uniform(0.1, 1, 12).tolist(), strict=True))

    tree = ParameterTree(
        [
            turn("headYaw", some(), pivot=(3, 4, 5)),
            turn("jaw", some(), "headYaw", axis=(1, 0, 0)),
            slide("smile", (1, 2, 3), some(), "jaw"),
            Parameter("lid", "rotation", (1, 0, 0), (0, 3, 0), "headYaw", False, {"lid": 40.0}, None, on(some())),
        ],
        literal=bool(seed == 2),
    )
    face = with_tree(grid(), tree)
    names = ("headYaw", "jaw", "smile", "lid")
    row = rng.uniform(-1, 1, 4) * [40, 20, 1, 1]
    posed = TreePoser(face, names).pose(row).parts[0]
    expected = tree.deform(MESH, face.parts[0].vertices, tree.values(dict(zip(names, row, strict=True))))
    np.testing.assert_allclose(posed.vertices, expected, atol=2e-4)
    np.testing.assert_allclose(np.linalg.norm(posed.normals, axis=1), 1, atol=1e-5)


def test_action_units_reach_a_tree_by_channels_or_by_their_own_name() -> None:
    face = grid()
    by_channel = with_tree(face, ParameterTree([slide("mouthSmileLeft", (0, 0, 2), {0: 1.0})]))
    assert TreePoser(by_channel, ("AU12L",)).values([0.5]).tolist() == [0.5]
    muscle = Parameter("zygomaticus", "translation", (0, 0, 2), drives={"AU12L": 1.0}, influences=on({0: 1.0}))
    by_name = with_tree(face, ParameterTree([muscle]))
    assert TreePoser(by_name, ("AU12L", "jawOpen")).values([0.5, 1]).tolist() == [0.5]
    with pytest.raises(InputError, match="did you mean 'jawOpen'"):
        TreePoser(by_name, ("jawOpne",))


def test_translations_hold_any_field_of_offsets() -> None:
    rng = np.random.default_rng(4)
    field = {"a": rng.normal(size=(20, 3)), "b": rng.normal(size=(7, 3))}
    tree = ParameterTree(translations_of("x", field, {"x": 1.0}, None, kept=1.0))
    assert len(tree) == 3
    for part, offsets in field.items():
        np.testing.assert_allclose(tree.deform(part, np.zeros_like(offsets), tree.values({"x": 1})), offsets, atol=6e-3)
    assert len(translations_of("x", {"a": np.outer(rng.normal(size=9), [1, 2, 3])}, {}, None)) == 1
    assert translations_of("x", {"a": np.zeros((4, 3))}, {}, None) == []


def test_the_jaw_of_the_default_face_is_a_rotation() -> None:
    """The target is a straight line; the rows of teeth at its end stand where one turn about a hinge takes them."""
    face = load_face()
    lower = face.part("teeth_lower")
    offsets = np.zeros((len(lower.vertices), 3))
    offsets[lower.targets["jawOpen"].vertices] = lower.targets["jawOpen"].offsets
    screw = jaw_motion({"teeth_lower": offsets}, {"teeth_lower": lower.vertices.astype(float)})
    assert screw is not None
    assert screw.misfit < 0.02
    assert 15 < screw.degrees < 35
    assert abs(screw.axis[0]) > 0.999
    assert (
        jaw_motion({"a": np.tile([0.0, -5.0, 0.0], (20, 1))}, {"a": np.random.default_rng(0).normal(size=(20, 3))})
        is None
    )


def _distance(one, other) -> float:
    return max(
        float(np.linalg.norm(a.vertices - b.vertices, axis=1).max())
        for a, b in zip(one.parts, other.parts, strict=True)
    )


def test_the_tree_of_the_default_face_meets_its_targets_and_keeps_teeth_rigid() -> None:
    face = load_face()
    moved = deformed_by(face, "tree")
    plain, by_tree = Poser(face, ALL), poser_for(moved, ALL)
    for name in WEIGHTS:
        row = np.zeros(len(ALL))
        row[ALL.index(name)] = 1.0
        assert _distance(plain.pose(row), by_tree.pose(row)) < 0.02, name
    row = np.zeros(len(ALL))
    row[-3:] = (25, -12, 8)
    assert _distance(plain.pose(row), by_tree.pose(row)) < 0.01
    row[:] = 0
    row[ALL.index("jawOpen")] = 0.5
    number = [part.name for part in face.parts].index("teeth_lower")
    rest = face.parts[number].vertices
    asked = np.linalg.norm(rest[::50] - rest[0], axis=1)

    def bent(poser) -> float:
        points = poser.pose(row).parts[number].vertices
        return float(np.abs(np.linalg.norm(points[::50] - points[0], axis=1) - asked).max())

    assert bent(by_tree) < 0.02  # rigid
    assert bent(plain) > 0.2  # on a straight line the row shrinks on the way


def test_what_targets_lose_of_a_tree_is_measured() -> None:
    moved = deformed_by(load_face(), "tree")
    row = np.zeros(len(ALL))
    assert lost_by_targets(moved, ALL, [row]) == 0
    row[ALL.index("jawOpen")] = 0.5
    assert 1.0 < lost_by_targets(moved, ALL, [row]) < 4.0
    assert lost_by_targets(load_face(), ALL, [row]) == 0


def test_a_face_without_a_jaw_target_still_gets_a_tree() -> None:
    bare = tree_of_face(
        face_of_mesh(Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32), np.zeros((3, 2)), np.ones((3, 3))), "x")
    )
    assert [parameter.name for parameter in bare.parameters][:2] == ["headYaw", "trunk"] or len(bare) == 4
    assert len(tree_of_face(tiny_face())) > 60


def test_matrices_are_for_row_vectors() -> None:
    point = np.array([1.0, 0, 0, 1])
    np.testing.assert_allclose(
        point @ rotation_matrix((0, 0, 1), (0, 0, 0), 90) @ translation_matrix((0, 0, 5)), [0, 1, 5, 1], atol=1e-12
    )
