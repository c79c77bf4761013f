"""``mien face check | tree | parameters`` and ``--deformer``, as a user calls them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.cli import main
from mien.face.obj import write_obj

BOX = np.array([[x, y, z] for x in (0.0, 90.0) for y in (-90.0, 90.0) for z in (0.0, 90.0)])
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]])
TREE = """mien-tree 1
parameter head
  rotation axis 0 1 0 pivot 0 0 0
  group skeletal
  drive headYaw 1
  all 1
parameter jaw
  translation 0 -20 0
  parent head
  drive jawOpen 1
  side 0 -1 0 of 0 0 0 soft 1
"""


def test_check_tells_faults_with_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_obj(tmp_path / "a.obj", BOX, SIDES)
    (tmp_path / "a.tree").write_text(TREE, encoding="utf-8")
    assert main(["face", "check", str(tmp_path / "a.tree"), "--mesh", str(tmp_path / "a.obj")]) == 0
    told = capsys.readouterr().out
    assert "parameters: 2, no faults" in told
    assert "  jaw " in told
    (tmp_path / "b.tree").write_text(TREE + "  weights mesh 99:1\n  parent nobody\n", encoding="utf-8")
    assert main(["face", "check", str(tmp_path / "b.tree"), "--mesh", str(tmp_path / "a.obj")]) == 2
    told = capsys.readouterr().out
    assert "b.tree:12: jaw: vertex 99 is beyond the 8 of part 'mesh'" in told
    assert "b.tree:7: jaw: its parent 'nobody' is not in the tree" in told


def test_an_obj_speaks_with_a_tree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import soundfile

    write_obj(tmp_path / "a.obj", BOX, SIDES)
    (tmp_path / "a.tree").write_text(TREE, encoding="utf-8")
    soundfile.write(tmp_path / "a.wav", np.random.default_rng(0).normal(0, 0.01, 8000), 16000)
    command = ["animate", str(tmp_path / "a.wav"), "--text", "Ah.", "--face", str(tmp_path / "a.obj")]
    assert main([*command, "-o", str(tmp_path / "x.png")]) == 2
    assert "has no morph targets that could move it: give --deformer X.tree" in capsys.readouterr().err
    outputs = ["-o", str(tmp_path / "x.png"), "--also", str(tmp_path / "x.glb"), "--fps", "10"]
    assert main([*command, "--deformer", str(tmp_path / "a.tree"), *outputs]) == 0
    assert (tmp_path / "x.png").stat().st_size > 1000
    assert "a GLB moves targets on straight lines" in capsys.readouterr().err
    assert main([*command, "--deformer", "regions", *outputs]) == 2
    assert "no part 'skin'" in capsys.readouterr().err
    assert main([*command, "--deformer", "bones", *outputs]) == 2
    assert "unknown deformer 'bones'" in capsys.readouterr().err


def test_parameters_from_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    poses = [tmp_path / f"{number}.obj" for number in range(3)]
    for number, path in enumerate(poses):
        write_obj(path, BOX + np.array([0, 0, 5.0 * number]) * (BOX[:, 1:2] < 0), SIDES)
    command = ["face", "parameters", *map(str, poses), "-o", str(tmp_path / "p.tree")]
    assert main(command) == 0
    assert "pose_1: 100.00 % of the variance" in capsys.readouterr().out
    assert main(["face", "check", str(tmp_path / "p.tree"), "--mesh", str(poses[0])]) == 0
    assert main(["face", "parameters", str(poses[0]), "-o", str(tmp_path / "q.tree")]) == 2
    assert not (tmp_path / "q.tree").exists()


def test_articulation_is_refused_before_work_where_markers_have_no_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_obj(tmp_path / "a.obj", BOX, SIDES)
    command = ["face", "articulation", str(tmp_path), "-o", str(tmp_path / "x.tree")]
    assert main([*command, "--face", str(tmp_path / "a.obj")]) == 2
    assert "no part 'skin' and no morph targets: markers have nothing to sit on" in capsys.readouterr().err
    assert main(command) == 2
    assert "expected a corpus" in capsys.readouterr().err
    assert not (tmp_path / "x.tree").exists()


def test_the_tree_of_a_face_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["face", "tree", "default", "-o", str(tmp_path / "d.tree")]) == 0
    assert "parameters: " in capsys.readouterr().out
    assert "parameter jaw\n  rotation axis 1 " in (tmp_path / "d.tree").read_text()
