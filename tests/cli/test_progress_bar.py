"""Long work tells how far it has come: a line now and then where nobody looks at a terminal."""

from __future__ import annotations

import threading

import pytest

from mien.cli import progress_bar as progress
from mien.core.progress import tell


def test_a_log_gets_a_line_now_and_then(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([0.0, 4.0, 11.0, 11.0, 12.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    with progress.telling():
        for done in (1, 2, 3):
            tell("speaking", done, 3)
    tell("speaking", 3, 3)
    assert capsys.readouterr().err == "mien: speaking: 2 of 3\n"


def test_quiet_is_quiet(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN_LINES", 0.0)
    with progress.telling(quiet=True):
        tell("speaking", 1, 2)
    assert capsys.readouterr().err == ""


def test_a_terminal_gets_a_bar(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress.sys.stderr, "isatty", lambda: True)
    with progress.telling():
        tell("speaking", 1, 2)
        tell("finding the times", 1, 1)
        tell("finding the times", 1, 3)
    assert "speaking" in capsys.readouterr().err


def test_drawing_gives_a_log_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 4.0, 11.0, 11.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    with progress.progress_bar("drawing", " frames") as show:
        show(40, 121)
        show(80, 121)
    assert capsys.readouterr().err == "mien: drawing: 80 of 121\n"


def test_a_terminal_hears_that_silent_work_goes_on(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress.sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(progress, "_SILENT", (0.0,))
    said = threading.Event()
    monkeypatch.setattr(progress, "print", lambda *what, **_: (lines.append(what[0]), said.set()), raising=False)
    lines: list[str] = []
    with progress.still_working("face"):
        assert said.wait(30)
    assert lines == ["mien: face: at work (0 s)"]
