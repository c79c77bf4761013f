"""Running a speech engine that is a program of its own."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence

from mien.core.errors import MissingPartError

__all__ = ["run_program"]

_TIME_LIMIT = 600.0


def run_program(command: Sequence[str], voice: str, given: bytes = b"", seconds: float = _TIME_LIMIT) -> bytes:
    """Run a program without a shell; returns what it printed.

    Raises
    ------
    MissingPartError
        If it cannot be started, fails, or takes longer than ``seconds``; one line with what it said.
    """
    try:
        done = subprocess.run(command, input=given, capture_output=True, timeout=seconds, check=False)
    except OSError as problem:
        raise MissingPartError(f"the voice {voice!r} cannot start {command[0]}: {problem.strerror}") from problem
    except subprocess.TimeoutExpired as problem:
        raise MissingPartError(f"the voice {voice!r} did not answer in {seconds:g} s: try another") from problem
    if done.returncode != 0:
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["no message"]
        raise MissingPartError(
            f"the engine of the voice {voice!r} failed with code {done.returncode} ({lines[-1][:160]}): "
            "reinstall it or choose another voice"
        )
    return done.stdout
