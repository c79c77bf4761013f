from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from mien.cli import main
from mien.motion.performer_file import save_learned
from tests.inspection.performers import small_performer


@pytest.fixture(scope="module")
def performer(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("performer") / "small.mien"
    save_learned(small_performer(), path)
    return str(path)


def test_words_alone(performer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = tmp_path / "text.txt"
    text.write_text("blue\n")
    assert main(["inspect", performer, "--text", str(text)]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("performer           small\n")
    assert "1 sentences, 4 phone pairs (4 different) rest on" in out
    assert err == ""
    assert main(["inspect", "default"]) == 0
    assert capsys.readouterr().out.startswith("performer           default\n")


def test_words_and_pictures(performer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "learned"
    sequence = "SIL " + next(
        b for a, b in (k for k in small_performer().coarticulation.curves_ if len(k) == 2) if a == "SIL"
    )
    assert main(["inspect", performer, "-o", str(folder), "--phones", sequence, "--word", "blue"]) == 0
    out = capsys.readouterr().out
    told = (folder / "summary.txt").read_text()
    assert out.startswith(told)
    drawn = sorted(path.name for path in folder.glob("*.png"))
    assert drawn == [
        "coverage.png", "diphones.png", "expressions-hand-made.png", "fitting-cost.png", "influence.png",
        "key-shapes-classes.png", "key-shapes-face.png", "key-shapes-speaker.png",
    ]  # fmt: skip
    assert all(name in out for name in drawn)
    for name in drawn:
        with Image.open(folder / name) as image:
            assert min(image.size) > 200
            assert len(image.getcolors(2**24) or []) > 10
    assert len(list(folder.iterdir())) == len(drawn) + 1


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--word", "blue"], "--phones and --word choose what is drawn: say where to with -o FOLDER"),
        (["--phones", "P AA"], "say where to with -o FOLDER"),
        (["--text", "missing.txt"], "missing.txt: no such text file or folder"),
        (["-o", "OUT", "--phones", "P"], "two or three phones"),
        (["-o", "OUT", "--phones", "OY ZH"], "no curves were learned for OY ZH"),
        (["-o", "OUT", "--word", "。"], "word"),
        (["-o", "OUT/deeper/still"], "cannot make the folder"),
    ],
)
def test_refusals(
    performer: str, options: list[str], reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [option.replace("OUT", str(tmp_path / "out")) for option in options]
    assert main(["inspect", performer, *given]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert err.count("\n") == 1
    assert not list(tmp_path.rglob("*.png"))


def test_a_performer_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", "hand-made"]) == 2
    assert "unknown learned performer 'hand-made'" in capsys.readouterr().err
