"""Programs that some tests need: absent, the test is skipped with a reason, except in CI, where it fails."""

from __future__ import annotations

import os

import pytest

from mien.speech.voices import Voice, catalogue

__all__ = ["voice_or_skip"]


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
