from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.corpus.transcripts import read_table, read_transcript
from tests.corpus.recordings import write_speech


def test_plain_text_in_any_encoding(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("  He said:\n “no”.\n", encoding="utf-8")
    assert read_transcript(path).text == "He said: “no”."
    path.write_bytes("caf\u00e9 \u2013 now".encode("cp1252"))
    transcript = read_transcript(path)
    assert transcript.text == "café – now"
    assert "a.txt is not in UTF-8: read as Windows-1252" in transcript.notes[0].message
    path.write_text("bin blue", encoding="utf-16")
    assert read_transcript(path).text == "bin blue"


def test_align_and_lab_give_words_with_times(tmp_path: Path) -> None:
    align = tmp_path / "a.align"
    align.write_text("0 23750 sil\n23750 29500 bin\n29500 34000 blue\n34000 74500 sil\n")
    transcript = read_transcript(align)
    assert transcript.text == "bin blue"
    assert transcript.words is not None
    assert transcript.words.intervals[0].start == pytest.approx(0.95)
    lab = tmp_path / "a.lab"
    lab.write_text("0 5000000 sil\n5000000 9000000 bin\n")
    transcript = read_transcript(lab)
    assert transcript.words is not None
    assert (transcript.text, transcript.words.intervals[0].end) == ("bin", pytest.approx(0.9))
    lab.write_text("just the words\n")
    assert read_transcript(lab).text == "just the words"


def test_a_textgrid_gives_words_and_phones_without_stress(tmp_path: Path) -> None:
    write_speech(tmp_path, "a")
    transcript = read_transcript(tmp_path / "a.TextGrid")
    assert transcript.text == "bin ma"
    assert transcript.phones is not None
    assert [i.label for i in transcript.phones] == ["SIL", "B", "IH", "N", "M", "AA", "SIL"]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", b" \n", "the file has no words"),
        ("a.txt", b"a\x00b", "character 1 is 0"),
        ("a.align", b"0 100 bin\n100 blue\n", "line 2: expected 'start end word'"),
        ("a.align", b"200 100 bin\n", "line 1: interval 'bin' must run forward"),
        ("a.lab", b"0 100 b\n100 200 ih1\n200 300 n\n", "labels are phones, not words"),
    ],
)
def test_what_cannot_be_used_is_named_with_its_line(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_transcript(path)


def test_a_phone_that_is_none_is_named(tmp_path: Path) -> None:
    write_speech(tmp_path, "a")
    grid = tmp_path / "a.TextGrid"
    grid.write_text(grid.read_text(encoding="utf-8").replace('"IH1"', '"ɪ"'), encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.TextGrid, at 0\.600 s: 'ɪ' is not an ARPAbet phone"):
        read_transcript(grid)


def test_tables_with_any_separator(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("Name;emotion;text\na;W;well, now\nb;;yes\n", encoding="utf-8")
    rows, notes = read_table(table)
    assert rows == {"a": {"emotion": "W", "text": "well, now"}, "b": {"text": "yes"}}
    assert not notes
    table.write_text("name\tspeaker\na\ts1\n", encoding="utf-8")
    assert read_table(table)[0] == {"a": {"speaker": "s1"}}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("name,emotion\na,happy\na,sad\n", "line 3: the name 'a' is there twice"),
        ("name,emotoin\na,happy\n", "did you mean 'emotion'"),
        ("file,emotion\na,happy\n", "expected a header line with 'name'"),
        ("name,text\na,well, now\n", "line 2: more cells than columns"),
        ("", "expected a header"),
    ],
)
def test_mistakes_in_a_table_are_named(tmp_path: Path, content: str, message: str) -> None:
    table = tmp_path / "t.csv"
    table.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_table(table)
