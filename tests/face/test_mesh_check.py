"""Odd meshes and damaged face files: handled with a line that names the place, or refused with one."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.cli import main
from mien.core.errors import InputError
from mien.face.mesh_check import mesh_notes
from mien.face.model import Face, Target
from mien.face.obj import Mesh, face_of_mesh, read_obj, write_obj
from mien.face.parameter_tree import Parameter, ParameterTree
from mien.face.posing import Poser
from mien.face.storage import read_face, write_face
from mien.face.tree_config import parse_tree
from mien.face.tree_report import tree_report
from tests.faces import tiny_face

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 10) for y in (0, 10) for z in (0, 10))
SIDES = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")


def face_of(text: str, tmp_path: Path) -> Face:
    (tmp_path / "a.obj").write_text(text)
    return face_of_mesh(read_obj(tmp_path / "a.obj"), "a")


STRAY = Target(np.array([60_000], np.int32), np.zeros((1, 3), np.float32))


def with_skin(face: Face, **changes: object) -> Face:
    return replace(face, parts=(replace(face.parts[0], **changes), *face.parts[1:]))  # type: ignore[arg-type]


def faces(*sides: str) -> str:
    return "".join(f"f {side}\n" for side in sides)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (CUBE + faces(*SIDES[1:]), "1 open edge loop .* the first at vertex 0"),
        (CUBE + faces(*SIDES[2:]), "2 open edge loops"),
        (CUBE + "v 9 9 9\n" + faces(*SIDES), "no triangle uses 1 of 9 vertices, first 8"),
        (CUBE + "v 0 0 0\n" + faces("9 2 4 3", *SIDES[1:]), "1 vertices lie where another one does, first 8 on 0"),
        (CUBE + faces(*SIDES, "1 2 2"), "1 of 13 triangles have no area, first 12"),
        (CUBE + faces(*SIDES, "1 2 8"), "edges have more than two triangles"),
        (CUBE, "has no triangles"),
    ],
)
def test_odd_meshes_are_taken_and_told(text: str, told: str, tmp_path: Path) -> None:
    face = face_of(text, tmp_path)
    assert any(re.search(told, note) for note in mesh_notes(face)), mesh_notes(face)
    posed = Poser(face, ()).pose([]).parts[0]
    assert np.isfinite(posed.normals).all()


def test_a_whole_cube_of_polygons_is_told_nothing_but_that_nothing_moves_it(tmp_path: Path) -> None:
    assert mesh_notes(face_of(CUBE + faces(*SIDES), tmp_path)) == [
        "no part has morph targets: only a parameter tree can move this face"
    ]


def test_a_polygon_of_many_corners_is_cut_without_loss(tmp_path: Path) -> None:
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    text = "".join(f"v {x:.9f} {y:.9f} 0\n" for x, y in zip(np.cos(angle), np.sin(angle), strict=True))
    face = face_of(text + "f " + " ".join(map(str, range(1, 41))) + "\n", tmp_path)
    corner = face.parts[0].vertices[face.parts[0].triangles].astype(float)
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(40 / 2 * np.sin(2 * np.pi / 40), rel=1e-5)


def test_a_million_vertices_are_posed(tmp_path: Path) -> None:
    side = 1000
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], axis=1)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    triangles = np.vstack(
        [np.c_[corner, corner + 1, corner + side], np.c_[corner + 1, corner + side + 1, corner + side]]
    )
    mesh = Mesh(points, triangles.astype(np.int32), np.zeros((side * side, 2)), np.ones((side * side, 3)))
    face = face_of_mesh(mesh, "plain")
    moved = Target(np.arange(0, side * side, 2, dtype=np.int32), np.tile(np.float32([0, 0, 1]), (side * side // 2, 1)))
    face = replace(face, parts=(replace(face.parts[0], targets={"jawOpen": moved}),))
    posed = Poser(face, ("jawOpen",)).pose([0.5]).parts[0]
    assert posed.vertices[::2, 2].min() == posed.vertices[::2, 2].max() == 0.5
    assert np.isfinite(posed.normals).all()
    assert posed.vertices[1::2, 2].max() == 0.0


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda f: replace(f, parts=(*f.parts, f.parts[0])), "part 'skin' is there twice"),
        (lambda f: replace(f, parts=(), eyes=(), sites={}), "it has no parts"),
        (lambda f: replace(f, eyes=(replace(f.eyes[0], side="left"),)), "its side is 'left', not Left or Right"),
        (lambda f: replace(f, eyes=(replace(f.eyes[0], part="ball"),)), "eye 'ball' is no part"),
        (lambda f: replace(f, head_pivot=(0.0, float("nan"), 0.0)), "three finite numbers"),
        (lambda f: replace(f, sites={"nose": ("skin", 10**6)}), "site 'nose' is on no vertex"),
        (lambda f: with_skin(f, triangles=np.array([[0, 1, 10**5]], np.int32)), "a triangle names a vertex beyond"),
        (lambda f: with_skin(f, targets={"jawOpen": STRAY}), "target 'jawOpen' does not fit its vertices"),
    ],
)
def test_damaged_faces_are_refused_with_the_place(damage: Callable[[Face], Face], told: str, tmp_path: Path) -> None:
    write_face(damage(tiny_face()), tmp_path / "a.npz")
    with pytest.raises(InputError, match=told):
        read_face(tmp_path / "a.npz")


def test_a_chain_deeper_than_pythons_stack_is_a_tree_all_the_same() -> None:
    names = [f"p{k}" for k in range(3000)]
    chain = [
        Parameter(name, "translation", (0.001, 0, 0), parent=names[k - 1] if k else None, skeletal=True)
        for k, name in enumerate(names)
    ]
    assert ParameterTree(chain[::-1]).parameters[-1].name == "p2999"


def test_a_ring_of_parents_is_told_and_no_endless_walk() -> None:
    ring = [Parameter(f"p{k}", "fixed", parent=f"p{(k + 1) % 400}", skeletal=True) for k in range(400)]
    with pytest.raises(InputError, match="its parents run in a circle"):
        ParameterTree(ring)


def test_weights_that_do_not_sum_are_normalised_and_told(tmp_path: Path) -> None:
    face = face_of(CUBE + faces(*SIDES), tmp_path)
    vertices = {part.name: part.vertices for part in face.parts}
    text = "mien-tree 1\nparameter a\ntranslation 4 0 0\ngroup skeletal\nweights mesh 0:3 1:1\nparameter b\nfixed\n"
    tree = parse_tree(text + "group skeletal\nweights mesh 0:1\n").on(vertices)
    report = tree_report(tree, face)
    assert (
        "skeletal weights of 1 vertices do not sum to 1 and are normalised, the farthest off 4.00 at vertex 0" in report
    )
    moved = tree.deform("mesh", face.parts[0].vertices, [1.0, 0.0])
    assert (moved - face.parts[0].vertices)[:2, 0].tolist() == pytest.approx([3.0, 4.0])


def test_face_check_tells_about_the_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.obj").write_text(CUBE + faces(*SIDES[1:]))
    (tmp_path / "a.tree").write_text(
        "mien-tree 1\nparameter head\nrotation axis 0 1 0 pivot 0 0 0\ndrive headYaw 1\nall 1\n"
    )
    assert main(["face", "check", str(tmp_path / "a.tree"), "--mesh", str(tmp_path / "a.obj")]) == 0
    assert "part 'mesh': 1 open edge loop" in capsys.readouterr().out


def test_a_written_mesh_comes_back(tmp_path: Path) -> None:
    skin = tiny_face().part("skin")
    write_obj(tmp_path / "b.obj", skin.vertices, skin.triangles)
    assert read_obj(tmp_path / "b.obj").triangles.tolist() == skin.triangles.tolist()
