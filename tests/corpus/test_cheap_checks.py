"""What is missing is said before a costly step begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.corpus.cheap_checks import cheap_faults, check_cheaply
from mien.corpus.readers import Found


def found(folder: Path, *names: str) -> Found:
    for name in names:
        (folder / name).write_bytes(b"x")
    sound = next((folder / n for n in names if n.endswith(".wav")), None)
    text = next((folder / n for n in names if n.endswith(".txt")), None)
    return Found("a", folder / names[0], sound, text)


def test_a_recording_without_a_text_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.c3d: no transcript: expected a\.txt"):
        check_cheaply(found(tmp_path, "a.c3d", "a.wav"), "", "a.c3d")
    check_cheaply(found(tmp_path, "a.c3d", "a.wav"), "hello", "a.c3d")
    check_cheaply(found(tmp_path, "a.c3d", "a.wav", "a.txt"), "", "a.c3d")


def test_an_empty_file_and_a_video_that_is_none_are_refused(tmp_path: Path) -> None:
    empty = found(tmp_path, "a.c3d", "a.wav", "a.txt")
    (tmp_path / "a.wav").write_bytes(b"")
    with pytest.raises(InputError, match=r"a\.wav is empty"):
        check_cheaply(empty, "", "a.c3d")
    with pytest.raises(InputError, match="expected a video"):
        check_cheaply(found(tmp_path, "a.mp4", "a.txt"), "", "a.mp4")


def test_the_others_go_on(tmp_path: Path) -> None:
    good, bad = found(tmp_path, "a.c3d", "a.wav", "a.txt"), Found("b", tmp_path / "b.c3d")
    (tmp_path / "b.c3d").write_bytes(b"x")
    passed, failed = cheap_faults({"a": good, "b": bad}, {"a": {}, "b": {}}, tmp_path)
    assert list(passed) == ["a"]
    assert [(f.name, f.reason.split(":")[1]) for f in failed] == [("b", " no transcript")]
