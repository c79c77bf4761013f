"""Work cut among threads."""

from __future__ import annotations

import pytest

from mien.face.render.cores import cores, shared


@pytest.mark.parametrize(("count", "threads"), [(0, 2), (1, 4), (7, 1), (45, 2), (45, 8)])
def test_everything_is_done_once(count, threads):
    done = []
    shared(lambda begin, end: done.extend(range(begin, end)), count, threads)
    assert sorted(done) == list(range(count))


def test_a_fault_in_a_thread_is_raised():
    def fails(begin: int, end: int) -> None:
        raise ValueError(f"{begin} to {end}")

    with pytest.raises(ValueError, match="to"):
        shared(fails, 10, 2)


def test_the_number_of_threads_can_be_given(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert cores() == 3
    monkeypatch.setenv("NUMBA_NUM_THREADS", "many")
    assert cores() >= 1
