"""Programs that some tests need: absent, the test is skipped with a reason, except in CI, where it fails."""

from __future__ import annotations

import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from mien.speech.voices import Voice, catalogue

__all__ = ["blender_python", "voice_or_skip"]


def voice_or_skip(name: str) -> Voice:
    """The voice of a name."""
    voice = next(voice for voice in catalogue() if voice.name == name)
    found = voice.availability()
    if not found.installed:
        reason = f"the voice {name} is not installed: {found.hint} (or make setup-festival)"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return voice


@cache
def blender_python() -> str:
    """A Python that has Blender as a module: ``MIEN_BLENDER``, or what ``make setup-blender`` made."""
    made = Path(__file__).parent.parent / ".venv-blender" / "bin" / "python"
    python = os.environ.get("MIEN_BLENDER") or str(made)
    if shutil.which(python) is None or subprocess.run([python, "-c", _FIND_BLENDER], check=False).returncode:
        reason = f"Blender as a Python module was not found at {python}: make setup-blender"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return python


_FIND_BLENDER = "import importlib.util, sys; sys.exit(importlib.util.find_spec('bpy') is None)"
