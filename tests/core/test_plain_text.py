"""Texts as people save them."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.core.plain_text import decode_text, read_plain_text, text_lines

TEXT = "Hyvää päivää, naïve café.\nZwei Zeilen."


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_unicode_in_all_its_forms(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "a.txt").write_bytes(TEXT.replace("\n", "\r\n").encode(encoding))
    assert read_plain_text(tmp_path / "a.txt") == (TEXT, ())


def test_big_endian_with_its_mark() -> None:
    assert decode_text(codecs.BOM_UTF16_BE + TEXT.encode("utf-16-be"), "a")[0] == TEXT


def test_windows_text_is_read_with_a_note(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes((TEXT + " – “quoted”").encode("cp1252"))
    text, (note,) = read_plain_text(tmp_path / "a.txt")
    assert text == TEXT + " – “quoted”"
    assert note.message == "a.txt is not in UTF-8: read as Windows-1252 (Western European)"


@pytest.mark.parametrize("content", [bytes(range(256)), b"\xff\xfe\x00", b"\xef\xbb\xbf\xff", b"RIFF\xff\x00\x00\x00"])
def test_what_is_no_text_is_refused(content: bytes) -> None:
    with pytest.raises(InputError, match=r"a\.txt: expected a table in"):
        decode_text(content, "a.txt", "a table")


def test_texts_have_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MIEN_MOST_TEXT", "10")
    with pytest.raises(InputError, match="MIEN_MOST_TEXT"):
        decode_text(b"x" * 11, "a.txt")


def test_long_texts_come_line_by_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.obj"
    path.write_bytes(b"v 1\r\nv 2\rv 3\n\xff")
    assert list(text_lines(path, "mesh")) == ["v 1", "v 2", "v 3", "\ufffd"]
    monkeypatch.setenv("MIEN_MOST_ROWS", "3")
    with pytest.raises(InputError, match="MIEN_MOST_ROWS"):
        list(text_lines(path, "mesh"))
    path.write_bytes(b"a" * 2_000_000)
    with pytest.raises(InputError, match=r"a\.obj:1: a line of more than a million characters"):
        list(text_lines(path, "mesh"))
