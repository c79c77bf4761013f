"""Requests to end come through at safe places, and only there."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from mien.cli.stopping import put_off, stop_cleanly

NAMES = [name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    before = {name: signal.getsignal(getattr(signal, name)) for name in NAMES}
    stop_cleanly()
    yield
    for name, handler in before.items():
        signal.signal(getattr(signal, name), handler)


def ask(name: str = "SIGTERM") -> None:
    os.kill(os.getpid(), getattr(signal, name))


@pytest.mark.parametrize("name", NAMES)
def test_a_request_unwinds(name: str) -> None:
    with pytest.raises(KeyboardInterrupt):
        ask(name)


def test_a_request_that_is_put_off_waits_for_a_safe_place() -> None:
    reached = []

    def work() -> None:
        with put_off() as obey:
            ask()
            reached.append("after the request")
            obey()
            reached.append("after the safe place")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == ["after the request"]


def test_a_request_without_a_safe_place_comes_through_at_the_end() -> None:
    with pytest.raises(KeyboardInterrupt), put_off():
        ask()
