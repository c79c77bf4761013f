import threading
import time

import pytest

from mien.core.errors import InputError
from mien.serve.studio.jobs import Busy, JobPool
from mien.serve.studio.settings import Limits


@pytest.fixture
def pool():
    made = JobPool(Limits(workers=1, jobs_waiting=1))
    yield made
    made.close()


def over(pool, name):
    while not pool.get(name).over:
        time.sleep(0.005)
    return pool.get(name)


def test_a_job_tells_where_it_is_and_what_it_made(pool):
    seen, go = threading.Event(), threading.Event()

    def work(job):
        job.at("voice", 0.5)
        seen.set()
        go.wait(10)
        return {"take": "x"}

    name = pool.start(work)
    assert seen.wait(10)
    assert pool.get(name).plain() == {"state": "running", "step": "voice", "done": 0.5}
    go.set()
    assert over(pool, name).plain() == {"state": "done", "step": "voice", "done": 1.0, "take": "x"}


def test_an_error_is_told_and_a_fault_of_ours_does_not_end_the_worker(pool, caplog):
    def wrong(job):
        raise InputError("expected\na text")

    def broken(job):
        raise ZeroDivisionError("secret")

    failed = over(pool, pool.start(wrong))
    assert (failed.state, failed.error) == ("failed", "expected a text")
    failed = over(pool, pool.start(broken))
    assert failed.state == "failed"
    assert "secret" not in failed.error
    assert over(pool, pool.start(lambda job: {})).state == "done"


def test_cancelled_before_and_while_it_runs(pool):
    started, go = threading.Event(), threading.Event()
    reached = []

    def work(job):
        started.set()
        go.wait(10)
        job.at("next")
        reached.append(True)
        return {}

    running = pool.start(work)
    assert started.wait(10)
    waiting = pool.start(work)
    with pytest.raises(Busy):
        pool.start(work)
    pool.get(waiting).cancel()
    pool.get(running).cancel()
    assert pool.get(running).state == "cancelled"
    go.set()
    while True:  # the worker has to come round first
        try:
            name = pool.start(lambda job: {})
            break
        except Busy:
            time.sleep(0.005)
    assert over(pool, name).state == "done"
    assert not reached


def test_closing_does_not_wait_for_what_cannot_be_interrupted():
    pool, go, started = JobPool(Limits(workers=1)), threading.Event(), threading.Event()

    def deaf(job):
        started.set()
        go.wait(60)
        return {}

    name = pool.start(deaf)
    assert started.wait(10)
    assert not pool.close(patience=0.05)
    assert pool.get(name).state == "cancelled"
    with pytest.raises(Busy):
        pool.start(lambda job: {})
    go.set()
    assert pool.close(10)
