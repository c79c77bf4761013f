"""How far something long has come: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from mien.core.progress import listening

__all__ = ["progress_bar", "still_working", "telling"]

_SECONDS_BETWEEN_LINES = 10.0
_SILENT = (2.0, 10.0, 30.0, 60.0)
"""Seconds without a bar after which a terminal is told that work goes on; then once a minute."""
_bars = 0


@contextmanager
def progress_bar(what: str, unit: str, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A bar that hears how much is done of how much; a line now and then in a log; nothing if quiet.

    Parameters
    ----------
    what : str
        What goes on, such as ``"drawing"``.
    unit : str
        What is counted, with a blank before it.
    quiet : bool
    """
    global _bars
    if quiet:
        yield lambda done, total: None
        return
    if not sys.stderr.isatty():
        log = _log()
        yield lambda done, total: log(what, done, total)
        return
    from tqdm import tqdm

    _bars += 1
    with tqdm(unit=unit, desc=what, leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        try:
            yield show
        finally:
            _bars -= 1


def _log() -> Callable[[str, int, int], None]:
    last = time.monotonic()

    def log(what: str, done: int, total: int) -> None:
        nonlocal last
        if time.monotonic() - last >= _SECONDS_BETWEEN_LINES:
            print(f"mien: {what}: {done} of {total}", file=sys.stderr, flush=True)
            last = time.monotonic()

    return log


@contextmanager
def still_working(what: str) -> Iterator[None]:
    """On a terminal, a line after two seconds without a bar, and now and then while it stays so."""
    if not sys.stderr.isatty():
        yield
        return
    ended = threading.Event()

    def watch() -> None:
        begun, said = time.monotonic(), 0
        while not ended.wait(0.2):
            past = time.monotonic() - begun
            due = _SILENT[said] if said < len(_SILENT) else 60.0 * (said - len(_SILENT) + 2)
            if past >= due and _bars == 0:
                print(f"mien: {what}: at work ({past:.0f} s)", file=sys.stderr, flush=True)
            said += past >= due

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


@contextmanager
def telling(quiet: bool = False) -> Iterator[None]:
    """Show how far what `mien.core.progress` tells has come: a bar on a terminal, else a line now and then."""
    if quiet:
        yield
        return
    if sys.stderr.isatty():
        with _Bars() as bars, listening(bars.show):
            yield
        return
    with listening(_log()):
        yield


class _Bars:
    """One bar at a time, made when something tells that takes more than one step."""

    def __init__(self) -> None:
        self._what, self._stack = "", ExitStack()

    def __enter__(self) -> _Bars:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def show(self, what: str, done: int, total: int) -> None:
        """Move the bar, or begin another."""
        if total < 2:
            return
        if what != self._what:
            self._stack.close()
            self._what, self._bar = what, self._stack.enter_context(progress_bar(what, " parts"))
        self._bar(done, total)
