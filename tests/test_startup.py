"""What a line costs before it is worked on, held by counting what is done, not by the clock."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import mien

BENCHMARK = Path(__file__).parent.parent / "benchmarks/startup.py"
HEAVY = {"numba", "llvmlite", "scipy", "sklearn", "matplotlib", "av", "aiohttp", "asyncio", "ezc3d"}
"""Packages that a line without a picture has no use for; each takes a good part of a second to load."""


def counted(*more: str) -> dict[str, Any]:
    command = [sys.executable, str(BENCHMARK), "--count", *more]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module", params=["default", "hand-made"])
def line(request: pytest.FixtureRequest) -> dict[str, Any]:
    return counted("--performer", request.param)


def test_a_line_loads_nothing_heavy(line: dict[str, Any]) -> None:
    assert line["code"] == 0
    assert not HEAVY & set(line["modules"])
    assert line["counts"]["mien"] < 265


def test_a_line_reads_no_file_over_and_over(line: dict[str, Any]) -> None:
    often = {name: times for name, times in line["opened"].items() if times > 2}
    assert not [name for name in often if not name.endswith(".mien")], often  # a performer's parts are read when used
    assert often.get("performers/default.mien", 0) < 20


def test_a_line_fits_nothing_and_opens_each_network_once(line: dict[str, Any]) -> None:
    assert line["made"] == {"InferenceSession": 2}, "the voice's and the pitch's; no expression space is fitted"


@pytest.mark.parametrize("arguments", [["--help"], ["say", "--help"]])
def test_help_loads_no_numpy(arguments: list[str]) -> None:
    code = (
        f"import sys; from mien.cli import main\ntry: main({arguments})\nfinally: print('\\n' + ' '.join(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    loaded = set(done.stdout.strip().splitlines()[-1].split())
    assert "mien.cli.main" in loaded
    assert not {"numpy", "asyncio", "importlib.metadata", *HEAVY} & loaded


def test_the_first_lines_are_reached_before_anything_is_imported() -> None:
    """Until then Ctrl-C ends in a traceback that nobody can catch."""
    source = Path(mien.__file__).parents[1]
    program = f"import os, sys; sys.path.insert(0, {str(source)!r}); old = set(sys.modules); import mien.__main__; " \
              "print(sorted(set(sys.modules) - old))"  # fmt: skip
    loaded = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "['__future__', 'mien', 'mien.__main__']"
