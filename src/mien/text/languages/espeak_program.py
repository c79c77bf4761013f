"""Asking eSpeak NG, which runs as a program of its own (`espeak_process`); its library is never loaded here."""

from __future__ import annotations

import ctypes.util
import json
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mien.core.errors import MissingPartError
from mien.core.external_program import run_program

__all__ = ["HINT", "ask_espeak", "espeak_library"]

_PACKAGE = "espeakng_loader"
HINT = "run: pip install espeakng-loader (GPL-3) or apt install espeak-ng"
"""How it is installed."""


def ask_espeak(request: dict[str, Any], voice: str) -> tuple[dict[str, Any], bytes]:
    """One request of `mien.text.languages.espeak_process`; its answer and the samples, 16 bit.

    Raises
    ------
    MissingPartError
        If eSpeak NG is not installed or fails; ``voice`` is named in the message.
    """
    found = espeak_library()
    if found is None:
        raise MissingPartError(f"the voice {voice!r} needs eSpeak NG, which is not installed: {HINT}")
    given = json.dumps(request | {"library": found[0], "data": found[1]}).encode("ascii") + b"\n"
    script = str(Path(__file__).with_name("espeak_process.py"))
    head, _, raw = run_program([sys.executable, "-I", script], voice, given).partition(b"\n")
    answer: dict[str, Any] = json.loads(head)
    return answer, raw


@cache
def espeak_library() -> tuple[str, str] | None:
    """The library and its data folder (``""``: the library knows), or None."""
    package = find_spec(_PACKAGE)
    if package is not None and package.submodule_search_locations:
        folder = Path(package.submodule_search_locations[0])
        names = {"win32": "espeak-ng.dll", "darwin": "libespeak-ng.dylib"}
        library = folder / names.get(sys.platform, "libespeak-ng.so")
        if library.exists():
            return str(library), str(folder / "espeak-ng-data")
    system = ctypes.util.find_library("espeak-ng")
    return (system, "") if system else None
