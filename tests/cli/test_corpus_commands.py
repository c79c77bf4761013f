from __future__ import annotations

from pathlib import Path

import pytest

from mien.cli import main
from tests.corpus import recordings as made


def test_import_check_show(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made.write_npz(tmp_path / "in", "a")
    made.write_speech(tmp_path / "in", "a")
    made.write_npz(tmp_path / "in", "mute")
    out = str(tmp_path / "out")
    assert main(["corpus", "import", str(tmp_path / "in"), "-o", out, "--workers", "0", "--emotion", "sad"]) == 0
    told = capsys.readouterr()
    assert told.out == f"{out}: 1 takes (1 new, 1 could not be used)\n"
    assert "mien: not imported: mute: mute.npz: no transcript: expected mute.txt" in told.err
    assert main(["corpus", "import", str(tmp_path / "in"), "-o", out, "--workers", "0", "--emotion", "sad"]) == 0
    assert "1 takes (0 new, 1 were there, 1 could not be used)" in capsys.readouterr().out
    assert main(["corpus", "check", out]) == 1
    table = capsys.readouterr().out
    assert "emotions                       sad 1\n" in table
    assert "fault: mute.npz: not in the corpus" in table
    picture = tmp_path / "a.png"
    assert main(["corpus", "show", out, "a", "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["corpus", "import", "nowhere", "-o", "out"], "nowhere: expected a folder of recordings"),
        (["corpus", "import", ".", "-o", "out", "--recipe", "c4d"], "did you mean 'c3d'"),
        (
            ["corpus", "import", ".", "-o", "out", "--recipe", "tracks", "--name-pattern", "("],
            "not a valid regular expression",
        ),
        (["corpus", "check", "nowhere"], "make one with 'mien corpus import'"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
