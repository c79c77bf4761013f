"""The public calls around files and recordings, and that nothing else shows in ``dir(mien)``."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import mien
from mien.cli.main import main
from tests.faces import tiny_animation

CALLS = {
    "align",
    "animate",
    "doctor",
    "evaluate",
    "express",
    "faces",
    "import_corpus",
    "learn",
    "load",
    "recolor",
    "save",
    "say",
    "score",
    "stimuli",
}  # fmt: skip


def test_dir_shows_the_public_calls_and_their_types_and_nothing_else() -> None:
    shown = subprocess.run(
        [sys.executable, "-c", "import mien; print(*dir(mien))"], capture_output=True, text=True, check=True
    ).stdout.split()
    assert {name for name in shown if name[0].islower()} == CALLS
    assert set(shown) - CALLS == {
        "Animation", "Audio", "Corpus", "Face", "InputError", "MienError", "Performer", "Take",
        "Utterance", "__version__",
    }  # fmt: skip


@pytest.mark.parametrize("name", sorted(CALLS))
def test_every_public_call_says_what_it_takes_and_raises(name: str) -> None:
    call = getattr(mien, name)
    documented = inspect.getdoc(call) or ""
    assert len(documented) > 30
    if inspect.signature(call).parameters and name not in ("score", "recolor"):
        assert "Raises" in documented


def test_what_was_saved_is_loaded(tmp_path: Path) -> None:
    animation = tiny_animation(40)
    mien.save(animation, tmp_path / "line.json", tmp_path / "line.csv")
    loaded = mien.load(tmp_path / "line.json")
    assert isinstance(loaded, mien.Animation)
    assert (loaded.channels.values == animation.channels.values).all()
    assert len(mien.load(tmp_path / "line.csv").channels) == len(animation.channels)


@pytest.mark.parametrize("name", ["line.mp3", "line", "missing.json", "missing.mien"])
def test_what_cannot_be_loaded_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    with pytest.raises(mien.InputError) as caught:
        mien.load(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_called_missing() -> None:
    with pytest.raises(mien.InputError, match="nix: no such file"):
        mien.load("nix")


def test_what_cannot_be_saved_is_refused(tmp_path: Path) -> None:
    with pytest.raises(mien.InputError, match="expected a path"):
        mien.save(tiny_animation(4))
    with pytest.raises(mien.InputError, match="expected an Animation to write, got int"):
        mien.save(5, tmp_path / "a.csv")  # type: ignore[arg-type]


@pytest.mark.parametrize("command", [["inspect"], ["say", "Hi.", "-o", "x.json", "--performer"]])
def test_a_file_that_is_no_performer_is_called_so(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rav.json").write_text("{}")
    assert main([*command, str(tmp_path / "rav.json")]) == 2
    assert "rav.json is not a performer: expected a file that ends in .mien" in capsys.readouterr().err


def test_a_performer_is_written_to_a_mien_file_only(tmp_path: Path) -> None:
    with pytest.raises(mien.InputError, match=r"\.mien"):
        mien.learn(tmp_path, tmp_path / "me.npz")
