"""Requests to end come through at safe places, and only there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

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


def test_what_was_ignored_at_the_start_stays_ignored() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    stop_cleanly()
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    ask("SIGHUP")  # nohup: the night's work goes on
    with pytest.raises(KeyboardInterrupt):
        ask("SIGTERM")


def run_mien(*words: str, before: str = "", **how: Any) -> subprocess.CompletedProcess[str]:
    code = f"import sys; sys.argv = ['mien', *{list(words)!r}]\n{before}\nimport mien.__main__ as m; sys.exit(m.run())"
    return subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, check=False, **how)


def test_an_end_while_modules_load_is_quiet() -> None:
    before = (
        "import builtins, os, signal; load = builtins.__import__\n"
        "def stop(name, *rest, **named):\n"
        "    if name == 'argparse': os.kill(os.getpid(), signal.SIGINT)\n"
        "    return load(name, *rest, **named)\n"
        "builtins.__import__ = stop"
    )
    done = run_mien("doctor", before=before)
    assert done.returncode == 130
    assert done.stderr == "mien: stopped; nothing half-written was left\n"


@pytest.mark.parametrize("number", [0, 1, 2])
def test_closed_standard_streams(number: int) -> None:
    done = run_mien("--version", preexec_fn=lambda: os.close(number), stdout=subprocess.DEVNULL)
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


def test_a_reader_that_goes_away() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = run_mien("--help", stdout=writer)
    os.close(writer)
    assert "Traceback" not in done.stderr
