"""mien as a program of its own: where it is, how it is installed, how it runs beside Blender."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy

_HERE = Path(__file__).parent
_names: dict[str, list[str]] = {}
NAME = "mien.exe" if os.name == "nt" else "mien"


def folder() -> Path:
    """Where the extension keeps mien's own environment."""
    try:
        kept = bpy.utils.extension_path_user(__package__, path="environment", create=True)
    except ValueError:  # not installed as an extension
        kept = Path(bpy.utils.user_resource("SCRIPTS", create=True)) / "mien-environment"
    return Path(kept)


def python_in(environment: Path) -> Path:
    """The interpreter of an environment."""
    return environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def program() -> str | None:
    """The mien program: as set, as installed by the button, or as the computer has it."""
    addon = bpy.context.preferences.addons.get(__package__)
    given = addon.preferences.program if addon and addon.preferences else ""
    home = Path.home() / ".local" / "bin" / NAME
    for candidate in (given, os.environ.get("MIEN", ""), python_in(folder()).with_name(NAME), home):
        if candidate and Path(candidate).is_file():
            return str(candidate)
    return shutil.which("mien")


def package() -> str:
    """What the button installs: the wheel that came with the extension, else mien from PyPI."""
    return str(next(iter(sorted(_HERE.glob("*.whl"))), "mien"))


def install_commands() -> list[list[str]]:
    """The two commands of the button."""
    environment = folder()
    pins = _HERE / "constraints.txt"
    pip = [str(python_in(environment)), "-m", "pip", "--disable-pip-version-check", "install"]
    return [
        [sys.executable, "-m", "venv", str(environment)],
        [*pip, *(["--constraint", str(pins)] if pins.is_file() else []), package()],
    ]


def names_of(kind: str) -> list[str]:
    """Names of voices, emotions or languages, as mien lists them; asked once."""
    mien = program()
    if kind not in _names and mien:
        asked = subprocess.run([mien, kind], capture_output=True, text=True, timeout=30, env=clean(), check=False)
        _names[kind] = list(dict.fromkeys(line.split()[0] for line in asked.stdout.splitlines() if line.split()))
    return _names.get(kind, [])


def clean() -> dict[str, str]:
    """The environment variables without those that would lead another Python astray."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


class Job:
    """Commands one after another, beside Blender; what they say goes into a file."""

    def __init__(self, commands: Sequence[Sequence[str]]) -> None:
        self._waiting = [list(command) for command in commands]
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")
        self._process: subprocess.Popen | None = None
        self._next()

    def _next(self) -> None:
        apart = (
            {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP} if os.name == "nt" else {"start_new_session": True}
        )
        self._process = subprocess.Popen(
            self._waiting.pop(0), stdin=subprocess.DEVNULL, stdout=self._log, stderr=self._log, env=clean(), **apart
        )

    def poll(self) -> int | None:
        """The exit code of the last command, or None while there is work."""
        code = self._process.poll()
        if code == 0 and self._waiting:
            self._next()
            return None
        return code

    def wait(self) -> int:
        """Wait for the end; gives the exit code."""
        while self.poll() is None:
            self._process.wait()
        return self._process.returncode

    def stop(self) -> None:
        """End what runs, with everything it started."""
        self._waiting.clear()
        if self._process.poll() is None:
            if os.name == "nt":
                self._process.terminate()
            else:
                os.killpg(self._process.pid, signal.SIGTERM)
            self._process.wait()

    def said(self) -> list[str]:
        """The lines so far, without progress bars' earlier states."""
        self._log.flush()
        self._log.seek(0)
        lines = [line.rsplit("\r", 1)[-1].strip() for line in self._log.read().splitlines()]
        self._log.seek(0, os.SEEK_END)
        return [line for line in lines if line]


def register() -> None:
    _names.clear()


def unregister() -> None:
    _names.clear()
