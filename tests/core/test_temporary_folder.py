"""Temporary folders: gone at the end, swept after a kill, kept while somebody works in them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from mien.core.errors import OutputError
from mien.core.temporary_folder import temporary_folder

HOLD = """
from mien.core.temporary_folder import temporary_folder
with temporary_folder() as folder:
    (folder / "a").write_text("x")
    print(folder, flush=True)
    input()
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_what_a_killed_program_left_is_swept_and_what_is_held_is_not(place: Path) -> None:
    environment = {**os.environ, "TMPDIR": str(place)}
    command = [sys.executable, "-c", HOLD]
    with subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        other = Path(process.stdout.readline().strip())
        with temporary_folder() as mine:
            assert (other / "a").exists()
            assert mine.parent == other.parent
        assert not mine.exists()
        process.send_signal(signal.SIGKILL)
    assert other.exists()
    with temporary_folder():
        assert not other.exists()


def test_a_folder_of_somebody_else_is_not_used(place: Path) -> None:
    trap = place / "elsewhere"
    trap.mkdir()
    (place / f"mien-{os.getuid()}").symlink_to(trap)
    with temporary_folder() as folder:
        assert folder.parent == place
    assert not list(trap.iterdir())


def test_nowhere_to_write_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> str:
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("tempfile.gettempdir", none)
    with (
        pytest.raises(OutputError, match="no folder for temporary files can be written; set TMPDIR"),
        temporary_folder(),
    ):
        pass
