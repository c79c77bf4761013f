from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.obj import face_of_mesh, read_obj, write_obj
from mien.face.posing import Poser

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0\nvt 0.25 0.75\ng plate\nf 1/1 2/1 3/1 4/1\nf -4 -3 -1\n"


def written(folder: Path, text: str) -> Path:
    (folder / "a.obj").write_text(text, encoding="utf-8")
    return folder / "a.obj"


def test_polygons_are_cut_into_fans_and_negative_indices_count_back(tmp_path: Path) -> None:
    mesh = read_obj(written(tmp_path, SQUARE))
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 3]]
    assert mesh.uv.tolist() == [[0.25, 0.25]] * 4
    assert mesh.colours[2].tolist() == [1, 0, 0]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("f 1 2", "three corners or more, not 2"),
        ("f 1 2 9", "vertex 9 is not among the 4 so far"),
        ("f 0 1 2", "vertex 0"),
        ("v 1 2", "expected 3 to 7 numbers, got 2"),
        ("v 1 2 nan", "not finite"),
        ("f a b c", "invalid literal"),
        ("hello", "starts no line of an OBJ file"),
    ],
)
def test_faults_name_file_and_line(tmp_path: Path, line: str, told: str) -> None:
    with pytest.raises(InputError, match=r"a\.obj:9: .*" + told):
        read_obj(written(tmp_path, SQUARE + line + "\n"))


def test_empty_and_missing_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no vertices"):
        read_obj(written(tmp_path, "# nothing\n"))
    with pytest.raises(InputError, match="no such file"):
        read_obj(tmp_path / "none.obj")


def test_round_trip_and_a_face_of_odd_meshes(tmp_path: Path) -> None:
    """Unreferenced and duplicate vertices and faces without area are kept and can be posed."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [9, 9, 9]])
    triangles = np.array([[0, 1, 2], [2, 2, 3]])
    write_obj(tmp_path / "b.obj", points, triangles)
    mesh = read_obj(tmp_path / "b.obj")
    assert mesh.vertices.tolist() == points.tolist()
    assert mesh.triangles.tolist() == triangles.tolist()
    posed = Poser(face_of_mesh(mesh, "odd"), ()).pose([]).parts[0]
    assert np.isfinite(posed.normals).all()
