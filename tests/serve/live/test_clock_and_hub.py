"""A stream keeps time for an hour, and no listener holds up another."""

from __future__ import annotations

import asyncio

import numpy as np

from mien.core.timeline import FrameRate
from mien.serve.live.clock import SimulatedClock, frames_due
from mien.serve.live.frames import Frame
from mien.serve.live.hub import QUEUE, Hub


def frame(number: int) -> Frame:
    return Frame(number, number / 30, np.zeros(1))


def test_an_hour_on_a_busy_machine_never_drifts_and_queues_stay_short() -> None:
    rate = FrameRate.of(29.97)
    random = np.random.default_rng(1)

    async def hour() -> tuple[int, float, int]:
        clock = SimulatedClock(lambda _: float(random.exponential(0.004)) + 0.2 * (random.random() < 1e-3))
        hub = Hub()
        idle = hub.join()  # never reads
        sent, worst = 0, 0.0
        async for number in frames_due(rate, clock):
            if clock.now() > 3600:
                break
            hub.publish(frame(number))
            sent, worst = sent + 1, max(worst, clock.now() - rate.time_of(number))
            assert len(idle) <= QUEUE
        return sent, worst, idle.skipped

    sent, worst, skipped = asyncio.run(hour())
    assert worst < rate.time_of(1)  # each frame leaves before its successor is due, after an hour as at the start
    assert 0.98 * 107892 < sent < 107892  # a pause of 0.2 s costs its frames and no more
    assert skipped == sent - QUEUE


def test_on_a_punctual_clock_every_frame_is_sent_once() -> None:
    async def numbers() -> list[int]:
        found = []
        async for number in frames_due(FrameRate.of(25), SimulatedClock()):
            found.append(number)
            if number == 999:
                return found
        return found

    assert asyncio.run(numbers()) == list(range(1000))


def test_a_slow_listener_sees_the_newest_frames_and_the_others_all() -> None:
    async def listen() -> tuple[list[int], list[int]]:
        hub = Hub()
        quick, slow = hub.join(), hub.join()
        read: list[int] = []
        for number in range(100):
            hub.publish(frame(number))
            got = await quick.get()
            assert got is not None
            read.append(got.number)
        hub.end()
        late = []
        while (got := await slow.get()) is not None:
            late.append(got.number)
        assert slow.skipped == 100 - QUEUE
        return read, late

    read, late = asyncio.run(listen())
    assert read == list(range(100))
    assert late == list(range(100 - QUEUE, 100))


def test_joining_after_the_end_is_told_so() -> None:
    async def join() -> Frame | None:
        hub = Hub()
        hub.end()
        return await asyncio.wait_for(hub.join().get(), 5)

    assert asyncio.run(join()) is None
