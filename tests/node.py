"""Node, npm and Chromium for the tests that need them; where they are missing such tests are skipped, except in CI."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
MINUTES = 60


def need(*programs: str) -> None:
    """Skip (fail in CI) if one of the programs is not there."""
    absent = [name for name in programs if shutil.which(name) is None]
    if absent:
        _without(f"{', '.join(absent)} not installed")


def chromium() -> str:
    """Path of a Chromium, or skip (fail in CI)."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        _without("chromium not installed")
    return str(found)


def _without(reason: str) -> None:
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


def run(*command: str, folder: Path, minutes: float = 10) -> str:
    """Run a program in a folder; gives what it printed. Fails the test with its complaint if it fails."""
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=minutes * MINUTES)
    assert ran.returncode == 0, f"{' '.join(command)}\n{ran.stdout[-4000:]}\n{ran.stderr[-4000:]}"
    return ran.stdout


def installed(package: str) -> Path:
    """The folder of one of our npm packages with its dependencies as pinned."""
    need("node", "npm")
    folder = ROOT / package
    lock, mark = folder / "package-lock.json", folder / "node_modules" / ".mien-lock"
    if not mark.is_file() or mark.read_bytes() != lock.read_bytes():
        run("npm", "ci", folder=folder)
        mark.write_bytes(lock.read_bytes())
    return folder
