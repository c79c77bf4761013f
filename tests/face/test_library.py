from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.library import check_face, known_faces, load_face
from mien.face.model import Face
from mien.face.storage import read_face, write_face


def test_default_is_known_and_loads() -> None:
    assert "default" in known_faces()
    assert load_face().name == "default"


def test_unknown_name_suggests_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean 'default'"):
        load_face("defalt")


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no face file"):
        load_face(tmp_path / "none.npz")


def test_damaged_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "broken.npz"
    path.write_bytes(b"PK not a face")
    with pytest.raises(InputError, match=r"not an archive of arrays|cannot be read as a face of mien"):
        load_face(str(path))


def test_other_npz_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, numbers=np.arange(3))
    with pytest.raises(InputError, match=r"not an archive of arrays|cannot be read as a face of mien"):
        load_face(path)


def _same(one: Face, other: Face) -> bool:
    if (one.name, one.eyes, one.sites, one.head_pivot) != (other.name, other.eyes, other.sites, other.head_pivot):
        return False
    return all(
        a.name == b.name
        and np.allclose(a.vertices, b.vertices, atol=0.006)
        and np.array_equal(a.triangles, b.triangles)
        and set(a.targets) == set(b.targets)
        and all(np.allclose(a.targets[k].offsets, b.targets[k].offsets, atol=0.006) for k in a.targets)
        for a, b in zip(one.parts, other.parts, strict=True)
    )


def test_round_trip_keeps_the_face_and_its_bytes(tmp_path: Path) -> None:
    face = load_face()
    write_face(face, tmp_path / "one.npz")
    write_face(face, tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert _same(read_face(tmp_path / "one.npz"), face)


def test_faults_inside_a_file_are_named(tmp_path: Path) -> None:
    face = load_face()
    skin = face.part("skin")
    short = replace(skin, uv=skin.uv[:-1])
    bent = replace(
        face, parts=tuple(short if p.name == "skin" else p for p in face.parts), sites={"x": ("skin", 10**6)}
    )
    write_face(bent, tmp_path / "bent.npz")
    with pytest.raises(InputError, match="rows of uv") as caught:
        read_face(tmp_path / "bent.npz")
    assert "site 'x'" in str(caught.value)


def test_metres_are_not_taken_for_millimetres_of_a_giant(tmp_path: Path) -> None:
    face = load_face()
    skin = face.part("skin")
    giant = replace(face, parts=(replace(skin, vertices=skin.vertices * 1000),))
    with pytest.raises(InputError, match="farther than 327 mm"):
        write_face(giant, tmp_path / "giant.npz")


@pytest.mark.parametrize("call", [load_face, check_face])
def test_a_video_is_no_face(call: Callable[[str], object], tmp_path: Path) -> None:
    film = tmp_path / "line.mp4"
    film.write_bytes(b"")
    with pytest.raises(InputError, match=r"line\.mp4 is no face: .*'mien faces'.*\.glb.*not a \.mp4"):
        call(str(film))
