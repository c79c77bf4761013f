"""Fixtures that every test may use."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("mien", deadline=None)  # no test asserts on wall-clock time
settings.load_profile("mien")

ROOT = Path(__file__).parent.parent

# Started in the background or by nohup, programs ignore these, and so would all that the tests start and stop.
if threading.current_thread() is threading.main_thread():
    for name, usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is signal.SIG_IGN:
            signal.signal(getattr(signal, name), usual)


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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that ``make test-quick`` leaves out, and put the files that take longest first."""
    listed = Path(__file__).parent / "slow_tests.txt"
    slow = listed.read_text(encoding="utf-8").split() if listed.is_file() else []
    named = set(slow)
    place: dict[str, int] = {}
    for number, line in enumerate(slow):
        place.setdefault(line.partition("::")[0], number)
    order: dict[pytest.Item, int] = {}
    for item in items:
        file = ".".join(Path(str(item.path)).relative_to(ROOT).with_suffix("").parts)
        name = getattr(item, "originalname", None) or item.name
        if f"{file}::{name.partition('[')[0]}" in named:
            item.add_marker(pytest.mark.slow)
        order[item] = place.get(file, len(slow))
    items.sort(key=order.__getitem__)
