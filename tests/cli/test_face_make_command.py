from pathlib import Path

import pytest

from mien.cli.main import main
from mien.face.cast import stored
from mien.face.default_face import default_face


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--seed", "x"], "--seed: expected a whole number"),
        (["--age", "old"], "--age: expected a number"),
        (["--origin", "mars"], "unknown origin 'mars'"),
        (["--blend", "amara"], "expected NAME+NAME"),
        (["--blend", "amara+mei", "--age", "30"], "leave out"),
        (["--feature", "nose-width1-incr=big"], "--feature nose-width1-incr"),
    ],
)
def test_what_cannot_be_is_one_line_before_work(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["face", "make", "-o", str(tmp_path / "x.npz"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_face_and_its_picture_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("mien.face.cast.stored.face_of_person", lambda person: default_face())
    also = tmp_path / "x.png"
    assert main(["face", "make", "--age", "62", "--sex", "f", "-o", str(tmp_path / "x.npz"), "--also", str(also)]) == 0
    assert stored.face_of_person is not None
    assert "woman, 62" in capsys.readouterr().out
    assert also.stat().st_size > 1000
