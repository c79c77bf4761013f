"""A bar on the terminal while something long goes on."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from mien.core.progress import listening

__all__ = ["progress_bar", "telling"]

_SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def progress_bar(what: str, unit: str, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A bar that is told how much is done of how much; no bar if quiet, or where nobody looks at a terminal.

    Parameters
    ----------
    what : str
        What goes on, such as ``"drawing"``.
    unit : str
        What is counted, with a blank before it.
    quiet : bool
    """
    if quiet or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from tqdm import tqdm

    with tqdm(unit=unit, desc=what, leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show


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
    last = time.monotonic()

    def log(what: str, done: int, total: int) -> None:
        nonlocal last
        if time.monotonic() - last >= _SECONDS_BETWEEN_LINES:
            print(f"mien: {what}: {done} of {total}", file=sys.stderr, flush=True)
            last = time.monotonic()

    with listening(log):
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
