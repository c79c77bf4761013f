"""Long work off the event loop: a bounded queue, a few workers, jobs that can be watched and cancelled."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any

from mien.core.errors import MienError
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.settings import Limits

__all__ = ["Busy", "Cancelled", "Job", "JobPool", "Part"]

_log = logging.getLogger("mien.serve.studio")


class Busy(Exception):  # noqa: N818
    """Too many jobs wait already."""


class Cancelled(Exception):  # noqa: N818
    """The job was cancelled; raised inside it at the next safe place."""


@dataclass(eq=False)
class Job:
    """One piece of work, as seen from outside.

    Attributes
    ----------
    state : {"queued", "running", "done", "failed", "cancelled"}
    step : str
        What it is at.
    done : float
        0..1.
    error : str or None
        One line, if it failed.
    at_fault : str or None
        The field of the request that is at fault.
    result : dict
        What it made, such as ``{"take": ID}``.
    """

    state: str = "queued"
    step: str = ""
    done: float = 0.0
    error: str | None = None
    at_fault: str | None = None
    result: dict[str, Any] = field(default_factory=dict)
    _cancelled: bool = False

    def at(self, step: str, done: float | None = None) -> None:
        """Say where the work is; called from inside it.

        Raises
        ------
        Cancelled
            If nobody wants it any more.
        """
        if self._cancelled:
            raise Cancelled
        self.step = step
        if done is not None:
            self.done = min(1.0, max(self.done, done))

    def shows(self, take: str) -> None:
        """Say that a take with the beginning of the result can be looked at already."""
        self.result = {"beginning": take}

    def cancel(self) -> None:
        """Stop at the next safe place; a job that has ended stays as it is."""
        self._cancelled = True
        if self.state in ("queued", "running"):
            self.state = "cancelled"

    @property
    def over(self) -> bool:
        """Whether it will change no more."""
        return self.state in ("done", "failed", "cancelled")

    def plain(self) -> dict[str, Any]:
        """As JSON."""
        told: dict[str, Any] = {"state": self.state, "step": self.step, "done": round(self.done, 3), **self.result}
        if self.error is not None:
            told |= {"error": self.error, "field": self.at_fault}
        return told


class Part(Job):
    """Work that is part of a job: it is cancelled with it, and tells nothing.

    Parameters
    ----------
    whole : Job
    """

    def __init__(self, whole: Job) -> None:
        super().__init__()
        self._whole = whole

    def at(self, step: str, done: float | None = None) -> None:
        """Stop here if the whole is cancelled."""
        self._whole.at(self._whole.step)


Work = Callable[[Job], dict[str, Any]]
"""Some work: given its job, to tell where it is; gives what `Job.result` becomes."""


class JobPool:
    """Runs jobs in threads.

    The heavy work is in compiled code that lets other threads run, so the event loop goes on answering. The threads do
    not keep the program alive: a voice that is in the middle of a long text cannot be interrupted, only left behind.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._jobs: Kept[Job] = Kept("job", limits.jobs_kept + limits.jobs_waiting + limits.workers)
        self._queue: SimpleQueue[tuple[Job, Work] | None] = SimpleQueue()
        self._lock, self._open, self._closed = Lock(), 0, False
        self._threads = [
            Thread(target=self._work_on, name=f"studio-job-{number}", daemon=True) for number in range(limits.workers)
        ]
        for thread in self._threads:
            thread.start()

    def start(self, work: Work) -> str:
        """Queue some work; returns the job's id.

        Raises
        ------
        Busy
            If too many wait already, or the studio closes.
        """
        job = Job()
        with self._lock:
            if self._closed:
                raise Busy("the studio is closing")
            if self._open >= self._limits.workers + self._limits.jobs_waiting:
                raise Busy(f"{self._open} jobs run or wait already: wait for one to end, or cancel it")
            self._open += 1
            name = self._jobs.put(job)
            self._queue.put((job, work))
        return name

    @property
    def open(self) -> int:
        """How many run or wait."""
        return self._open

    def get(self, name: str) -> Job:
        """The job of an id; raises `mien.serve.studio.lru_store.Missing`."""
        return self._jobs.get(name)

    def close(self, patience: float = 2.0) -> bool:
        """Cancel what runs and waits; whether all of it has ended, or something is left behind after ``patience`` s."""
        with self._lock:
            self._closed = True
        for job in self._jobs:
            job.cancel()
        for _ in self._threads:
            self._queue.put(None)
        until = time.monotonic() + patience
        for thread in self._threads:
            thread.join(max(0.0, until - time.monotonic()))
        return not any(thread.is_alive() for thread in self._threads)

    def _work_on(self) -> None:
        while (asked := self._queue.get()) is not None:
            try:
                self._run(*asked)
            finally:
                with self._lock:
                    self._open -= 1

    @staticmethod
    def _run(job: Job, work: Work) -> None:
        try:
            if job.over:
                return
            job.state = "running"
            result = work(job)
            job.at(job.step, 1.0)  # cancelled at the last moment: the result is not told
            job.result, job.state = result, "done"
        except Cancelled:
            job.state = "cancelled"
        except MienError as problem:
            job.error, job.at_fault = " ".join(str(problem).split()), getattr(problem, "field", None)
            job.state = "failed"
        except Exception as problem:  # a fault of ours must not take the worker down; it is told and logged
            _log.exception("a job failed")
            job.error = f"the studio itself failed ({type(problem).__name__}); its terminal has the details"
            job.state = "failed"
