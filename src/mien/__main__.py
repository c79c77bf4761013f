"""``mien`` and ``python -m mien``: the first lines that run, before anything that takes time is loaded."""

from __future__ import annotations

import os
import sys

__all__ = ["run"]


def run() -> int:
    """Run one command; returns its exit code.

    Loading takes a tenth of a second and longer: a request to end that comes meanwhile ends quietly too.
    """
    try:
        _open_standard_streams()
        from mien.cli import main

        return main()
    except KeyboardInterrupt:
        print("mien: stopped; nothing half-written was left", file=sys.stderr)
        return 130


def _open_standard_streams() -> None:
    """Have something behind standard input, output and error.

    Where a caller closed one (``mien ... >&-``), the next file that is opened would take its place and be printed into.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
    sys.stdin = sys.stdin or open(0)  # noqa: SIM115 - for the whole run
    sys.stdout = sys.stdout or open(1, "w")  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w")  # noqa: SIM115


if __name__ == "__main__":
    sys.exit(run())
