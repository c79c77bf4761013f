"""Tree configurations as text: what is read is what was written, and faults name their line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.library import load_face
from mien.face.tree_config import check_tree, read_tree, tree_text, write_tree
from mien.face.tree_of_face import tree_of_face
from tests.faces import tiny_face

BOX = {"mesh": np.array([[x, y, z] for x in (0.0, 10.0) for y in (0.0, 10.0) for z in (0.0, 10.0)])}
GOOD = """# a remark
mien-tree 1
parameter head
  rotation axis 0 1 0 pivot 0 -90 -40   # degrees
  group skeletal
  drive headYaw 1
  limits -60 60
  all 1
parameter smile
  translation 3 4 -1
  parent head
  drive mouthSmileLeft 1
  drive mouthDimpleLeft 0.25
  sphere 0 0 0 radius 1 soft 18
  weights mesh 7:0.5 2-3:1
parameter lid
  rotation axis 1 0 0 pivot 0 0 0
  parent head
  side 0 1 0 of 0 10 0 soft 0 weight 0.25
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "a.tree"
    path.write_text(text, encoding="utf-8")
    return path


def test_statements_mean_what_they_say(tmp_path: Path) -> None:
    tree = read_tree(written(tmp_path, GOOD)).on(BOX)
    head, smile, lid = tree.parameters
    assert (head.skeletal, smile.skeletal, lid.skeletal) == (True, False, False)
    assert head.limits == (-60, 60)
    assert head.pivot == (0, -90, -40)
    assert smile.parent == "head"
    assert smile.vector == (3, 4, -1)
    assert smile.drives == {"mouthSmileLeft": 1, "mouthDimpleLeft": 0.25}
    weights = np.zeros(8)
    weights[smile.influences["mesh"].vertices] = smile.influences["mesh"].weights
    assert weights[0] == 1  # in the sphere
    assert 0.4 < weights[1] < 0.6  # 10 mm off: half way through the soft edge, by a smooth step
    assert weights[[2, 3, 7]].tolist() == [1, 1, 0.5]  # the last line that names a vertex holds
    assert lid.influences["mesh"].vertices.tolist() == [2, 3, 6, 7]
    assert set(lid.influences["mesh"].weights.tolist()) == {0.25}


def test_groups_follow_the_tree_where_nothing_is_said(tmp_path: Path) -> None:
    text = "mien-tree 1\nparameter a\nrotation axis 0 1 0 pivot 0 0 0\nparameter b\ntranslation 1 0 0\nparent a\n"
    tree = read_tree(written(tmp_path, text)).on(BOX)
    assert [parameter.skeletal for parameter in tree.parameters] == [True, False]


@pytest.mark.parametrize(
    ("line", "text", "told"),
    [
        (4, "  rotation axis 0 1 pivot 0 -90 -40", "expected 'rotation axis X Y Z pivot X Y Z'"),
        (4, "  rotation axis 0 0 0 pivot 0 0 0", "no length"),
        (4, "  rotation axis 0 one 0 pivot 0 0 0", "expected a number, got 'one'"),
        (4, "  # nothing", "needs a line 'rotation', 'translation' or 'fixed'"),
        (5, "  group bony", "expected 'group skeletal' or 'group surface'"),
        (6, "  drive headYaw", "expected 'drive CHANNEL GAIN'"),
        (7, "  limits 60 -60", "limits run from 60 down to -60"),
        (7, "  limit -60 60", "unknown statement 'limit'"),
        (10, "  translation nan 1 1", "finite"),
        (11, "  parent haed", "its parent 'haed' is not in the tree"),
        (13, "  drive mouthSmileLeft 2", "drives smile already"),
        (14, "  sphere 0 0 0 radius -1 soft 18", "not negative"),
        (15, "  weights mesh 7:0.5 8:1", "vertex 8 is beyond the 8 of part 'mesh'"),
        (15, "  weights skin 7:0.5", "the mesh has no part 'skin'; it has mesh"),
        (15, "  weights mesh 7", "expected VERTEX:WEIGHT"),
        (15, "  weights mesh 3-2:1", "runs backwards"),
        (9, "parameter head", "the name is taken twice"),
        (3, "drive headYaw 1", "comes before the first 'parameter'"),
    ],
)
def test_faults_name_their_line(tmp_path: Path, line: int, text: str, told: str) -> None:
    lines = GOOD.splitlines()
    lines[line - 1] = text
    config = read_tree(written(tmp_path, "\n".join(lines)))
    with pytest.raises(InputError, match=r"a\.tree:\d+: ") as caught:
        config.on(BOX)
    assert told in str(caught.value)
    if "no length" not in told and "needs a line" not in told and "parent" not in told and "limits run" not in told:
        expected = line if "taken twice" not in told else 9
        assert f"a.tree:{expected}: " in str(caught.value)
    assert any(told in fault for _, fault in check_tree(config, BOX))


def test_every_fault_is_told_at_once(tmp_path: Path) -> None:
    text = "mien-tree 1\nparameter a\nrotation nonsense\nparameter b\ntranslation 1 2\n"
    assert [line for line, _ in check_tree(read_tree(written(tmp_path, text)), None)] == [3, 5]


def test_files_that_are_no_trees_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_tree(tmp_path / "none.tree")
    with pytest.raises(InputError, match=r"a\.tree:1: expected 'mien-tree 1'"):
        read_tree(written(tmp_path, "mien-tree 2\n"))
    (tmp_path / "b.tree").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        read_tree(tmp_path / "b.tree")


@pytest.mark.parametrize("name", ["tiny", "default"])
def test_round_trip(tmp_path: Path, name: str) -> None:
    face = tiny_face() if name == "tiny" else load_face()
    tree = tree_of_face(face)
    write_tree(tree, tmp_path / "a.tree", "made by a test\nin two lines")
    vertices = {part.name: part.vertices for part in face.parts}
    again = read_tree(tmp_path / "a.tree").on(vertices)
    assert [p.name for p in again.parameters] == [p.name for p in tree.parameters]
    for one, other in zip(tree.parameters, again.parameters, strict=True):
        assert (one.kind, one.parent, one.skeletal) == (other.kind, other.parent, other.skeletal)
        np.testing.assert_allclose([*one.vector, *one.pivot], [*other.vector, *other.pivot], rtol=1e-7, atol=1e-7)
        assert one.drives == pytest.approx(dict(other.drives))
        for part, influence in one.influences.items():
            dense = np.zeros((2, len(vertices[part])))
            dense[0, influence.vertices] = influence.weights
            if part in other.influences:
                dense[1, other.influences[part].vertices] = other.influences[part].weights
            assert np.abs(dense[0] - dense[1]).max() < 6e-4
    if name == "tiny":
        once = tree_text(again)
        (tmp_path / "b.tree").write_text(once, encoding="utf-8")
        assert tree_text(read_tree(tmp_path / "b.tree").on(vertices)) == once
