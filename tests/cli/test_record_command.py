from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from mien.cli import main
from mien.cli.record_command import Terminal
from mien.core.errors import Note
from tests.corpus.test_recording import FakeDevices, speech


def test_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", "--list"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert 50 <= len(told) < 60
    assert told[0].startswith("001  ")
    assert main(["record", "--list", "--language", "fi"]) == 0
    assert "Hyvää huomenta" in capsys.readouterr().out


def test_prepared_session(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "mine.txt").write_text("Hello there.\nGood bye.\n", encoding="utf-8")
    speech().write(tmp_path / "in" / "001.wav")
    out = str(tmp_path / "out")
    command = ["record", "-o", out, "--from", str(tmp_path / "in"), "--script", str(tmp_path / "mine.txt")]
    assert main([*command, "--emotion", "Sad", "--speaker", "anna"]) == 0
    told = capsys.readouterr()
    assert told.out == f"{out}: 1 sentences, 1 to go\n"
    assert "mien: not taken: sentence 2: " in told.err
    assert "sound alone moves no face" in told.err
    assert "anna-sad-mine-001,Hello there.,sad,mine-001,anna" in (tmp_path / "out" / "table.csv").read_text()
    (tmp_path / "in" / "001.wav").rename(tmp_path / "in" / "009.wav")
    assert main([*command, "--emotion", "happy", "--speaker", "anna"]) == 2  # nothing could be taken
    assert capsys.readouterr().out == f"{out}: 0 sentences, 2 to go\n"
    speech().write(tmp_path / "in" / "002.wav")
    assert main([*command, "--emotion", "sad", "--speaker", "anna"]) == 0
    assert f"1 sentences, 1 were there\nnext: mien corpus import {out}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "needs -o SESSION"),
        (["-o", "out", "--from", "nowhere"], "nowhere: expected a folder of recordings named 001.mp4"),
        (["-o", ".", "--from", "."], "are the same folder"),
        (["-o", "out", "--from", ".", "--no-camera"], "--from takes prepared files"),
        (["-o", "out", "--no-camera", "--camera", "x"], "contradict"),
        (["-o", "out", "--speaker", "a/b", "--from", "."], "the speaker goes into names of files"),
        (["--list", "--language", "eng"], "unknown language 'eng': did you mean 'en'?"),
        (["--list", "--script", "gone.txt"], "gone.txt: no such file"),
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
    assert main(["record", *arguments]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_a_microphone_it_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    assert main(["record", "-o", str(tmp_path / "out")]) == 2
    assert "pip install sounddevice, or record otherwise and give the files with --from" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_terminal_asks_until_a_known_key_comes_and_ends_with_its_input() -> None:
    screen = io.StringIO()
    terminal = Terminal(io.StringIO("x\nRetake\n\n"), screen)
    assert [terminal.key("?", "\nrq") for _ in range(3)] == ["r", "\n", "q"]
    assert screen.getvalue().count("?") == 4


def test_live_session_by_keys(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Record the first (again, once), skip the second, quit at the third."""
    note = Note("warning", "no camera found")
    monkeypatch.setattr("mien.corpus.recording.devices.open_devices", lambda camera, wants: (FakeDevices(), (note,)))
    monkeypatch.setattr("mien.corpus.recording.session.COUNTDOWN", 0)
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\nr\n" + "\n\n" + "s\nq\n"))
    out = str(tmp_path / "session")
    assert main(["record", "-o", out, "--speaker", "anna"]) == 0
    told = capsys.readouterr()
    assert "1/59 [neutral]  " in told.out
    assert "4/59" not in told.out
    assert told.out.endswith(f"{out}: 1 sentences, 58 to go\n")
    assert told.err.splitlines()[0] == "mien: warning: no camera found"
    assert sorted(p.name for p in Path(out).iterdir()) == ["anna-neutral-english-001.wav", "table.csv"]
