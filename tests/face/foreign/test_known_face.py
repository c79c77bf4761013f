"""A face of another maker as a face of mien's own, with every deformer; and what cannot move."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.cli.main import main
from mien.core.errors import InputError
from mien.face.deformers import deformed_by
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.known_face import known_face
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.tree_posing import TreePoser
from tests.zoo import ZOO


def test_a_glb_is_moved_by_the_tree_of_its_targets(tmp_path: Path) -> None:
    path = ZOO["arkit"](tmp_path).path
    face = load_face(path)
    named = {name for part in face.parts for name in part.targets}
    assert {"jawOpen", "mouthSmileLeft"} <= named
    assert not any(" " in part.name for part in face.parts)
    assert len(drawn_face(known_face(path)).origins) == len(face.parts)
    by_tree = deformed_by(face, "tree")
    for row in ([1.0, 0.0], [0.0, 1.0]):
        names = ["jawOpen", "mouthSmileLeft"]
        one, other = TreePoser(by_tree, names).pose(np.array(row)), Poser(face, names).pose(np.array(row))
        for a, b in zip(one.parts, other.parts, strict=True):
            np.testing.assert_allclose(a.vertices, b.vertices, atol=0.2)


def test_its_tree_is_written_and_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(ZOO["arkit"](tmp_path).path)
    assert main(["face", "tree", path, "-o", str(tmp_path / "x.tree")]) == 0
    assert main(["face", "check", str(tmp_path / "x.tree"), "--face", path]) == 0
    assert "no faults" in capsys.readouterr().out


def test_a_face_that_cannot_move_ends_with_two(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "still.gltf"
    path.write_text('{"asset": {"version": "2.0"}, "nodes": [], "meshes": []}')
    assert main(["face", "inspect", str(path)]) == 2
    told = capsys.readouterr()
    assert "nothing of this face can move" in told.out
    assert "no morph targets" in told.err
    with pytest.raises(InputError, match="nothing could move"):
        load_face(path)


def test_a_bare_mesh_is_sent_to_face_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "head.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert main(["face", "inspect", str(path)]) == 2
    assert f"'mien face fit {path} -o FACE.npz'" in capsys.readouterr().err


def test_a_face_file_of_miens_is_sent_to_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "me.npz"
    np.savez(path, a=np.zeros(1))
    assert main(["face", "inspect", str(path)]) == 2
    assert f"'mien say Hi --face {path} -o X.glb'" in capsys.readouterr().err
