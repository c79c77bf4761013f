"""Long work tells how far it has come: a line now and then where nobody looks at a terminal."""

from __future__ import annotations

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
