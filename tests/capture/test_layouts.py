from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.capture.layouts import GROUPS, find_layout, known_layouts, load_layout
from mien.core.errors import InputError
from mien.face.library import load_face

RIGID = {33, 133, 362, 263, 168, 6, 197, 195, 5, 10, 151, 9, 8, 1, 4, 98, 327}


@pytest.mark.parametrize(
    ("name", "count"), [("mediapipe-218", 218), ("mpeg4-32", 32), ("face-102", 102), ("expression-109", 109)]
)
def test_every_layout_has_its_markers_in_groups_on_the_face(name: str, count: int) -> None:
    layout = load_layout(name)
    assert len(layout.markers) == len(set(layout.markers)) == count
    assert sorted(m for group in GROUPS for m in layout.groups[group]) == sorted(layout.markers)
    assert len(layout.rigid) >= 7
    face = load_face()
    surface = np.concatenate([face.part(part).vertices for part in ("skin", "eye_left", "eye_right")])
    away = [np.linalg.norm(surface - place, axis=1).min() for place in layout.places]
    assert max(away) < 6.0  # mm: on the surface, if not on a vertex
    groups = layout.motion_groups()
    assert set(groups.names) <= set(layout.markers)


@pytest.mark.parametrize("name", known_layouts())
def test_left_is_left_and_the_sides_mirror_each_other(name: str) -> None:
    layout = load_layout(name)
    for left, right in (("8.3", "8.4"), ("3.7", "3.12"), ("4.3", "4.4"), ("9.1", "9.2"), ("5.1", "5.2")):
        assert layout.place(left)[0] > 5
        assert np.allclose(layout.place(left) * [-1, 1, 1], layout.place(right), atol=1.0)
    assert layout.place("8.1")[1] > layout.place("8.2")[1] > layout.place("2.1")[1]
    assert layout.place("9.3")[2] > layout.place("3.7")[2]


def test_the_landmarks_of_the_scoring_are_there() -> None:
    layout = load_layout("mediapipe-218")
    assert {number for number, marker in layout.landmarks.items() if marker in layout.rigid} == RIGID
    assert len(layout.groups["mouth"]) == 48
    assert layout.landmarks[13] == "2.2"
    assert layout.landmarks[7] == "mp_007"


def test_a_recording_finds_the_smallest_layout_with_its_markers() -> None:
    assert find_layout(load_layout("mpeg4-32").markers).name == "mpeg4-32"
    assert find_layout(["2.2", "mp_007"]).name == "mediapipe-218"
    with pytest.raises(InputError, match=r"take\.c3d: its 2 markers .* such as LIP_L, LIP_R"):
        find_layout(["LIP_L", "LIP_R"], "take.c3d")


def test_a_layout_of_ones_own_is_read_and_a_broken_one_refused(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    lines = [f'm{i} = {{ group = "upper", place = [{i}.0, {i * i}.0, 0.0], rigid = true }}' for i in range(3)]
    own.write_text('name = "own"\nabout = "three"\n[markers]\n' + "\n".join(lines))
    assert load_layout(str(own)).markers == ("m0", "m1", "m2")
    broken = tmp_path / "broken.toml"
    broken.write_text(own.read_text().replace("rigid = true", "rigid = false", 1))
    with pytest.raises(InputError, match="three markers or more must be rigid"):
        load_layout(str(broken))
    with pytest.raises(InputError, match="unknown marker layout 'mpeg4-31': did you mean 'mpeg4-32'"):
        load_layout("mpeg4-31")
