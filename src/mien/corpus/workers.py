"""Many independent jobs on all cores of this machine, or on a Dask cluster: the same call, the same results."""

from __future__ import annotations

import asyncio
import multiprocessing
import multiprocessing.connection
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from mien.core.errors import InputError, MienError, MissingPartError

__all__ = ["default_workers", "each"]

Job = TypeVar("Job")
Result = TypeVar("Result")
_AHEAD = 4  # jobs handed out per worker: enough to keep it busy


def default_workers() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def each(
    function: Callable[[Job], Result], jobs: Sequence[Job], workers: int | None = None, cluster: str | None = None
) -> Iterator[tuple[Job, Result | BaseException]]:
    """Do every job; yields each with its result or the error that it ended in, in the order in which they finish.

    Parameters
    ----------
    function : callable
        Of a module, so that other processes find it.
    jobs : sequence
    workers : int, optional
        Processes; the default is one per core. 0: in this process, one after another.
    cluster : str, optional
        Address of a Dask scheduler; its workers need mien and the same files under the same paths.

    Raises
    ------
    InputError
        If the number of workers is below 0, or no cluster answers at the address.
    MissingPartError
        If a cluster is asked for and Dask is not installed.

    Examples
    --------
    >>> sorted(result for _, result in each(abs, [-3, 2], workers=0))
    [2, 3]
    """
    if workers is not None and workers < 0:
        raise InputError(f"the number of workers is 0 (in this process) or more, not {workers}")
    if cluster is not None:
        return _on_cluster(function, jobs, cluster)
    if workers == 0:
        return _here(function, jobs)
    return _on_cores(function, jobs, min(workers or default_workers(), max(1, len(jobs))))


def _here(function: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[tuple[Job, Result | BaseException]]:
    for job in jobs:
        try:
            result: Result | BaseException = function(job)
        except (MienError, OSError, ValueError, ArithmeticError, LookupError, RuntimeError, TypeError) as problem:
            result = problem
        yield job, result


def _on_cores(
    function: Callable[[Job], Result], jobs: Sequence[Job], workers: int
) -> Iterator[tuple[Job, Result | BaseException]]:
    """A pool; what was under way when a process died is done again, each job in a process of its own."""
    waiting = list(reversed(jobs))
    while waiting:
        suspects: list[Job] = []
        running: dict[Future[Result], Job] = {}
        pool = _pool(workers)
        try:
            while (waiting or running) and not suspects:
                while waiting and len(running) < _AHEAD * workers:
                    running[pool.submit(function, waiting[-1])] = waiting[-1]
                    waiting.pop()
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    problem = future.exception()
                    if isinstance(problem, BrokenProcessPool):
                        suspects.append(running.pop(future))
                    else:
                        yield running.pop(future), problem if problem is not None else future.result()
        except BrokenProcessPool:
            pass  # it broke while a job was being handed out; that job is still waiting
        finally:
            pool.shutdown(cancel_futures=True)
        suspects += running.values()
        for job in suspects:
            yield job, _alone(function, job)


def _alone(function: Callable[[Job], Result], job: Job) -> Result | BaseException:
    with _pool(1) as pool:
        future = pool.submit(function, job)
        problem = future.exception()
    if isinstance(problem, BrokenProcessPool):
        return RuntimeError("its process ended without a word (a crash in a decoder, or out of memory)")
    return problem if problem is not None else future.result()


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_prepare_worker)


def _prepare_worker() -> None:
    """One thread each, since workers share the cores; and no worker outlives a parent that was killed."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)


def _on_cluster(
    function: Callable[[Job], Result], jobs: Sequence[Job], address: str
) -> Iterator[tuple[Job, Result | BaseException]]:
    try:
        import distributed
    except ImportError as problem:
        raise MissingPartError("a cluster needs Dask: install mien[dask]") from problem
    try:
        client: Any = distributed.Client(address, timeout="15s")  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as problem:
        raise InputError(
            f"no Dask scheduler answers at {address!r} ({problem}); give it as tcp://HOST:PORT"
        ) from problem
    return _collected(distributed, client, function, jobs, address)


def _collected(
    distributed: Any, client: Any, function: Callable[[Job], Result], jobs: Sequence[Job], address: str
) -> Iterator[tuple[Job, Result | BaseException]]:
    done = 0
    try:
        with client:
            futures = client.map(function, list(jobs), pure=False, retries=0)
            job_of = {future.key: job for future, job in zip(futures, jobs, strict=True)}
            for future in distributed.as_completed(futures):
                problem = future.exception()
                result = problem if problem is not None else future.result()
                yield job_of[future.key], result
                done += 1
                future.release()
    except (OSError, TimeoutError, asyncio.CancelledError, CancelledError, RuntimeError) as problem:
        raise InputError(
            f"the Dask scheduler at {address} was lost after {done} of {len(jobs)} jobs "
            f"({type(problem).__name__}): start it and run the same command again, it goes on where it stopped"
        ) from problem
