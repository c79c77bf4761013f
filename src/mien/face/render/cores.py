"""Work shared among the processor's cores, by threads: kernels let go of Python's lock while they run."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

__all__ = ["cores", "shared"]

_PIECES = 3  # for each core: one that another program holds up has fewer of them


def cores() -> int:
    """How many cores this process may use (`NUMBA_NUM_THREADS` if it is set)."""
    given = os.environ.get("NUMBA_NUM_THREADS", "")
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return int(given) if given.isdecimal() and int(given) else allowed


def shared(work: Callable[[int, int], object], count: int, threads: int) -> None:
    """Do ``work(begin, end)`` for stretches that make up 0 to ``count``, in so many threads; in one, all at once.

    The work must not depend on how it is cut.

    Examples
    --------
    >>> done = []
    >>> shared(lambda begin, end: done.extend(range(begin, end)), 10, threads=2)
    >>> sorted(done) == list(range(10))
    True
    """
    pieces = min(count, _PIECES * threads)
    if threads < 2 or pieces < 2:
        work(0, count)
        return
    ends = [count * number // pieces for number in range(pieces + 1)]
    for _ in _pool(os.getpid(), threads).map(work, ends, ends[1:]):
        pass


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Threads do not outlive a fork: every process has its own."""
    return ThreadPoolExecutor(threads, thread_name_prefix=f"mien-core-{process}")
