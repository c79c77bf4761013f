from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.head_space import head_space
from mien.fit.landmarks import known_landmarks, needed_landmarks, other_side, read_landmarks


def test_sides_mirror_each_other_on_the_default_face():
    rest = head_space().rest
    for name, mark in known_landmarks().items():
        partner = known_landmarks()[other_side(name)].vertex
        np.testing.assert_allclose(rest[partner] * [-1, 1, 1], rest[mark.vertex], atol=0.6, err_msg=name)


def test_eight_are_needed():
    assert len(needed_landmarks()) == 8


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "name,x,y,z\nchin,733\nnose_tip,0,-35,42.5\n"),
        ("a.json", '{"chin": 733, "nose_tip": [0, -35, 42.5]}'),
        ("a.json", '{"landmarks": {"chin": [733], "nose_tip": [0, -35, 42.5]}}'),
        ("a.toml", "chin = 733\nnose_tip = [0, -35, 42.5]\n"),
    ],
)
def test_notations(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    assert read_landmarks(path) == {"chin": (733.0,), "nose_tip": (0.0, -35.0, 42.5)}


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.csv", "chin,1,2\n", "a.csv:1: chin: expected 3 numbers or one"),
        ("a.csv", "chn,1\n", "a.csv:1: unknown landmark 'chn': did you mean 'chin'"),
        ("a.csv", "chin,1\nchin,2\n", "a.csv:2: 'chin' comes twice"),
        ("a.csv", "chin,x,2,3\n", "a.csv:1: could not convert"),
        ("a.csv", "chin,nan,2,3\n", "expected numbers"),
        ("a.csv", "", "holds no landmarks"),
        ("a.json", "{", "no JSON"),
        ("a.json", "[1]", "expected names with their places"),
        ("a.json", '{"chin": 1, "chin": 2}', "comes twice"),
        ("a.json", '{"chin": "left"}', "expected numbers"),
        ("a.json", '{"chin": 1.5}', "one number is a vertex"),
        ("a.toml", "chin = [1, 2", "no TOML"),
        ("a.txt", "", "read from .csv, .json, .toml or .pts"),
    ],
)
def test_faults(tmp_path, name, text, told):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=told):
        read_landmarks(path)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_landmarks(tmp_path / "none.csv")


@pytest.mark.parametrize(("name", "numbered"), [("a.pts", False), ("a.csv", True)])
def test_ibug_68(tmp_path, name, numbered):
    points = np.arange(68 * 3).reshape(68, 3)
    if numbered:
        text = "x,y,z\n" + "\n".join(",".join(map(str, (i, *row))) for i, row in enumerate(points))
    else:
        text = "version: 1\nn_points: 68\n{\n" + "\n".join(" ".join(map(str, row)) for row in points) + "\n}\n"
    (tmp_path / name).write_text(text)
    found = read_landmarks(tmp_path / name)
    assert found["eye_outer_right"] == tuple(points[36])
    assert found["lid_upper_left"] == tuple((points[43] + points[44]) / 2)
    (tmp_path / "b.pts").write_text("1 2 3\n")
    with pytest.raises(InputError, match="68 rows"):
        read_landmarks(tmp_path / "b.pts")
