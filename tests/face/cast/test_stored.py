from pathlib import Path

import pytest

from mien.face.cast import stored
from mien.face.cast.made_person import person_named
from mien.face.default_face import default_face


def test_a_face_is_made_once_and_read_afterwards(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(stored, "make_face", lambda person: made.append(person.name) or default_face())
    for _ in range(2):
        assert stored.face_of_person(person_named("mei")).part("skin").targets
    assert made == ["mei"]
    (kept,) = (tmp_path / "mien" / "faces").glob("*.npz")
    kept.write_bytes(b"broken")
    stored.face_of_person(person_named("mei"))
    assert made == ["mei", "mei"]


def test_without_a_home_it_is_made_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr(stored, "make_face", lambda person: default_face())
    assert stored.face_of_person(person_named("mei")).name == "default"
