"""Fixtures that every test may use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("mien", deadline=None)  # no test asserts on wall-clock time
settings.load_profile("mien")

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of shared recordings: ``MIEN_DATA``, or ``../shared/data`` beside the clone.

    Absent: the test is skipped, except in CI, where it fails.
    """
    folder = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / "README.md").is_file():
        reason = f"the shared recordings are not at {folder} (set MIEN_DATA)"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return folder
