"""How far long work has come, for whoever wants to know: the work tells, a listener shows.

>>> with listening(lambda what, done, total: print(f"{what}: {done} of {total}")):
...     tell("speaking", 1, 2)
speaking: 1 of 2
>>> tell("speaking", 2, 2)  # nobody listens
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["Listener", "listening", "tell"]

Listener = Callable[[str, int, int], None]
"""Given what goes on, how much of it is done, and how much there is."""

_listener: ContextVar[Listener | None] = ContextVar("mien-progress", default=None)


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Call ``listener`` whenever work inside has come further."""
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def tell(what: str, done: int, total: int) -> None:
    """Say that work has come further."""
    listener = _listener.get()
    if listener is not None:
        listener(what, done, total)
