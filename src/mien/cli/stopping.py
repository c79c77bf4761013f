"""Requests to end (Ctrl-C, SIGTERM, SIGHUP) unwind as `KeyboardInterrupt`, so that half-written files are removed.

Python raises it wherever the main thread happens to be. In the middle of a queue that another thread shares, the queue
stays locked and the program hangs; so while threads work together, requests wait for a safe place (`put_off`).
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator

__all__ = ["put_off", "stop_cleanly"]


class _Requests:
    """Whether an end was asked for, and whether it has to wait."""

    def __init__(self) -> None:
        self.made, self.waiting = False, False

    def __call__(self, *_: object) -> None:
        """Handle a signal."""
        self.made = True
        if not self.waiting:
            raise KeyboardInterrupt

    def obey(self) -> None:
        """End here if it was asked for."""
        if self.made:
            raise KeyboardInterrupt


_requests = _Requests()


def stop_cleanly() -> None:
    """Take requests to end from now on, but for those that were ignored when the program began.

    ``nohup`` and shells that start jobs in the background have them ignored so that the work outlives the terminal.
    """
    _requests.made = False
    if threading.current_thread() is threading.main_thread():
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is not signal.SIG_IGN:
                signal.signal(getattr(signal, name), _requests)


@contextlib.contextmanager
def put_off() -> Iterator[Callable[[], None]]:
    """Let requests to end wait inside; gives a call that ends there and then if one came.

    Examples
    --------
    >>> with put_off() as obey:
    ...     obey()  # nothing was asked for: goes on
    """
    _requests.waiting = True
    try:
        yield _requests.obey
    finally:
        _requests.waiting = False
    _requests.obey()
