"""One rule for all commands: what is text, and what is the name of a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.pipeline.inputs import read_text, script_of, text_or_file


def test_names_and_texts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my lines.txt").write_text("Read me.", encoding="utf-8")
    (tmp_path / "hello").write_text("Not me.", encoding="utf-8")
    assert text_or_file("my lines.txt") == Path("my lines.txt")
    assert text_or_file("nowhere.txt") == Path("nowhere.txt")
    assert text_or_file("line.TextGrid") == Path("line.TextGrid")
    for text in ("hello", "and/or", "I read file.txt", "Two.\nLines.txt", "x" * 10_000, "either / or"):
        assert text_or_file(text) == text
    assert text_or_file(str(tmp_path / "hello")) == tmp_path / "hello"


def test_a_word_that_is_also_a_file_is_spoken_with_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hello").write_text("Not me.", encoding="utf-8")
    script = script_of("hello")
    assert script.text == "hello"
    assert "is spoken as a word" in script.notes[0].message
    assert script_of("hello there").notes == ()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_files_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "a.txt").write_text("A café.", encoding=encoding)
    assert read_text(str(tmp_path / "a.txt")) == "A café."
    script = script_of(tmp_path / "a.txt")
    assert script.text == "A café."
    assert len(script.notes) == (encoding == "cp1252")


def test_what_cannot_be_read(tmp_path: Path) -> None:
    for name, words in (("none.txt", "no such text file"), ("a.TextGrid", "goes with its recording")):
        with pytest.raises(InputError, match=words):
            script_of(tmp_path / name)
    with pytest.raises(InputError, match="got a folder"):
        script_of(tmp_path)
