"""``mien warm-up``: compile once, after an installation, what the first picture would wait for."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien warm-up`` to the commands."""
    warm = commands.add_parser("warm-up", help="compile the renderer once, so that the first picture is quick")
    warm.add_argument("--quiet", action="store_true", help="print nothing but errors")
    warm.set_defaults(run=_warm_up)


def _warm_up(options: argparse.Namespace) -> int:
    from mien.api.warming import warm_up
    from mien.core.compiled import when_compiling

    when_compiling(None)
    if not options.quiet:
        print("compiling what draws and poses: about half a minute, once", flush=True)
    where = warm_up()
    if not options.quiet:
        print(where)
    return 0
