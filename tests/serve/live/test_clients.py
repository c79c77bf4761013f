"""Listeners of every kind, and none that another one notices; sockets that misbehave, and a server that goes on."""

from __future__ import annotations

import asyncio
import base64
import contextlib
from collections.abc import AsyncIterator

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.asyncio.client import connect

from mien.core.timeline import FrameRate
from mien.serve.live.clock import SimulatedClock, frames_due
from mien.serve.live.frames import Frame, Greeting, decode_frame
from mien.serve.live.hub import QUEUE, Hub
from mien.serve.live.sockets import Access, websocket_stream

GREETING = Greeting(("jawOpen",), 30.0)
RATE = FrameRate.of(30)


def frame(number: int) -> Frame:
    return Frame(number, RATE.time_of(number), np.zeros(1))


def test_gaps_at_ten_listeners_are_those_of_the_clock_whoever_else_is_there() -> None:
    async def minutes() -> tuple[list[list[float]], list[int], int]:
        clock, hub = SimulatedClock(), Hub()
        seen: list[list[float]] = [[] for _ in range(10)]
        late: list[int] = []

        async def read(times: list[float]) -> None:
            listener = hub.join()
            while await listener.get() is not None:
                times.append(clock.now())

        async def come_late() -> None:
            listener = hub.join()
            while (got := await listener.get()) is not None:
                assert isinstance(got, Frame)
                late.append(got.number)

        never = hub.join()
        tasks = [asyncio.create_task(read(times)) for times in seen]
        await asyncio.sleep(0)
        async for number in frames_due(RATE, clock):
            if number == 5400:
                break
            if number == 3000:
                tasks.append(asyncio.create_task(come_late()))
                await asyncio.sleep(0)
            if number % 7 == 0:
                hub.leave(hub.join())  # somebody looks in and is gone
            hub.publish(frame(number))
            await asyncio.sleep(0)
            assert len(never) <= QUEUE
        hub.end()
        await asyncio.gather(*tasks)
        return seen, late, never.skipped

    seen, late, skipped = asyncio.run(minutes())
    for times in seen:
        assert len(times) == 5400
        gaps = np.diff(times)
        assert np.percentile(gaps, 99) < 1.01 / 30
        assert gaps.max() < 1.01 / 30
    assert late == list(range(3000, 5400))  # from now on, nothing of what was
    assert skipped == 5400 - QUEUE


@contextlib.asynccontextmanager
async def open_stream(hub: Hub) -> AsyncIterator[int]:
    async with websocket_stream(hub, GREETING, Access(port=0)) as port:
        yield port


HANDSHAKE = (
    b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    b"Sec-WebSocket-Key: " + base64.b64encode(bytes(16)) + b"\r\n\r\n"
)


@given(
    st.lists(
        st.one_of(
            st.binary(max_size=300),
            st.binary(max_size=300).map(lambda junk: HANDSHAKE + junk),
            st.sampled_from([
                b"GET / HTTP/1.1\r\n",  # and never a word more
                HANDSHAKE[:-2],
                HANDSHAKE + b"\x81\xff" + b"\xff" * 12,  # a message of 2**63 bytes and more
                HANDSHAKE + b"\x88\x82\x00\x00\x00\x00\x00\x00",  # a goodbye with no such code
                HANDSHAKE + b"\x8f\x80\x00\x00\x00\x00",  # an opcode that does not exist
                b"POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n",
                b"GET /" + b"x" * 20_000 + b" HTTP/1.1\r\n\r\n",
                b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",  # TLS
            ]),
        ),
        min_size=1,
        max_size=6,
    )
)  # fmt: skip
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_whatever_comes_over_a_socket_the_stream_goes_on(knocks: list[bytes]) -> None:
    async def knocking() -> list[int]:
        hub = Hub()
        async with open_stream(hub) as port, connect(f"ws://127.0.0.1:{port}") as client:
            await client.recv()
            writers = []
            for number, knock in enumerate(knocks):
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                writers.append(writer)
                with contextlib.suppress(ConnectionError):
                    writer.write(knock)
                    await writer.drain()
                hub.publish(frame(number))
            found = [decode_frame(bytes(await client.recv())).number for _ in knocks]  # type: ignore[arg-type]
            for writer in writers:
                writer.transport.abort()
            hub.end()
            return found

    assert asyncio.run(knocking()) == list(range(len(knocks)))


def test_a_client_that_is_cut_off_in_the_middle_is_forgotten() -> None:
    async def cut() -> int:
        hub = Hub()
        async with open_stream(hub) as port:
            for _ in range(5):
                client = await connect(f"ws://127.0.0.1:{port}")
                await client.recv()
                client.transport.abort()
            for number in range(200):
                hub.publish(frame(number))
                await asyncio.sleep(0.005)
                if not len(hub):
                    break
            left = len(hub)
            hub.end()
            return left

    assert asyncio.run(cut()) == 0
