"""The stream over real sockets: ten clients, one that never reads, one that leaves, and those that may not come."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import socket
import time
import wave
from collections.abc import AsyncIterator
from dataclasses import replace
from urllib.request import urlopen

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from mien.animation.animation import Animation
from mien.core import channels
from mien.core.errors import InputError, OutputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.serve.live.clock import SimulatedClock
from mien.serve.live.datagrams import datagrams, livelink_encoder, vmc_encoder
from mien.serve.live.frames import END, Frame, Greeting, decode_frame
from mien.serve.live.hub import Hub
from mien.serve.live.livelink_packets import decode_livelink
from mien.serve.live.osc import decode_packet
from mien.serve.live.sockets import Access, websocket_stream
from mien.serve.live.streaming import Outlets, stream
from tests.faces import tiny_animation

GREETING = Greeting(("jawOpen",), 30.0)


def short_animation(frames: int = 20, fps: int = 100) -> Animation:
    values = np.random.default_rng(3).random((frames, len(channels.ALL)))
    return replace(tiny_animation(), channels=ChannelTrack(channels.ALL, values, FrameRate.of(fps)))


@contextlib.asynccontextmanager
async def open_stream(hub: Hub, access: Access | None = None) -> AsyncIterator[str]:
    async with websocket_stream(hub, GREETING, access or Access(port=0)) as port:
        yield f"ws://127.0.0.1:{port}"


async def read_all(client: ClientConnection) -> tuple[Greeting, list[Frame], str]:
    greeting, frames = Greeting.decode(str(await client.recv())), []
    while (message := await client.recv()) != END:
        if isinstance(message, bytes):
            frames.append(decode_frame(message))
    return greeting, frames, message


def test_a_client_gets_the_whole_animation_bit_for_bit() -> None:
    animation = short_animation()

    async def watch() -> tuple[Greeting, list[Frame], str]:
        opened: asyncio.Future[int | None] = asyncio.get_running_loop().create_future()
        playing = asyncio.create_task(
            stream(animation, Outlets(Access(port=0)), wait=True, opened=opened.set_result, clock=SimulatedClock())
        )
        async with connect(f"ws://127.0.0.1:{await opened}") as client:
            read = await read_all(client)
        played = await playing
        assert played.frames + played.skipped == len(animation.channels)
        return read

    greeting, frames, last = asyncio.run(watch())
    assert greeting.channels == animation.channels.names
    assert greeting.facts["text"] == animation.utterance.text
    assert last == END
    for frame in frames:
        np.testing.assert_array_equal(frame.values, animation.channels.values[frame.number].astype(np.float32))


def test_nine_readers_do_not_notice_one_that_never_reads_nor_one_that_leaves() -> None:
    async def crowd() -> list[list[int]]:
        hub = Hub()
        wide = np.zeros(2000)  # large frames fill the buffers of the one that does not read
        async with open_stream(hub) as address:
            idle = await connect(address, max_queue=1)
            async with contextlib.AsyncExitStack() as readers:
                clients = [await readers.enter_async_context(connect(address)) for _ in range(9)]
                gone = await connect(address)
                while len(hub) < 11:
                    await asyncio.sleep(0.01)
                reading = [asyncio.create_task(read_all(client)) for client in clients]
                for number in range(300):
                    hub.publish(Frame(number, number / 30, wide))
                    await asyncio.sleep(0.001)
                    if number == 20:
                        gone.transport.abort()
                hub.end()
                read = [[frame.number for frame in (await task)[1]] for task in reading]
            idle.transport.abort()
            return read

    for numbers in asyncio.run(crowd()):
        assert len(numbers) > 270  # one machine for all of them: a hiccup may cost a few
        assert numbers == sorted(numbers)
        assert numbers[-1] == 299


def test_who_may_not_listen_is_turned_away() -> None:
    async def status(address: str, **options: object) -> int:
        try:
            async with connect(address, **options) as client:  # type: ignore[arg-type]
                await client.recv()
                return 101
        except InvalidStatus as refused:
            return refused.response.status_code

    async def knock() -> list[int]:
        found = []
        async with open_stream(Hub()) as address:
            found.append(await status(address, origin="http://localhost:5173"))
            found.append(await status(address, origin="https://example.org"))
        async with open_stream(Hub(), Access(port=0, origins=("https://example.org",))) as address:
            found.append(await status(address, origin="https://example.org"))
        async with open_stream(Hub(), Access(port=0, token="very secret")) as address:
            found.append(await status(address))
            found.append(await status(address + "/?token=wrong"))
            found.append(await status(address + "/?token=very%20secret"))
        return found

    assert asyncio.run(knock()) == [101, 403, 101, 401, 401, 101]


def test_garbage_and_shouting_do_not_take_the_stream_down() -> None:
    async def shout() -> str:
        hub, random = Hub(), np.random.default_rng(5)
        async with open_stream(hub) as address:
            port = int(address.rsplit(":", 1)[1])
            for size in (0, 1, 10, 1000, 100_000):
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                with contextlib.suppress(ConnectionError):
                    writer.write(random.bytes(size))
                    await writer.drain()
                    writer.close()
                    await writer.wait_closed()
            loud = await connect(address)
            await loud.send("x" * 5000)  # larger than a client may say
            async with connect(address) as client:
                await client.recv()
                hub.publish(Frame(0, 0.0, np.zeros(1)))
                message = await client.recv()
                assert isinstance(message, bytes)
                await loud.wait_closed()
                hub.end()
                return str(await client.recv())

    assert asyncio.run(shout()) == END


def test_others_need_a_token_and_a_taken_port_is_told() -> None:
    with pytest.raises(InputError, match=r"0\.0\.0\.0 can be reached by other machines: give --token"):
        Access("0.0.0.0")
    with pytest.raises(InputError, match="at least 8"):
        Access(token="short")

    async def twice() -> None:
        async with open_stream(Hub()) as address:
            port = int(address.rsplit(":", 1)[1])
            async with open_stream(Hub(), Access(port=port)):
                pass

    with pytest.raises(OutputError, match="cannot listen on 127"):
        asyncio.run(twice())


def test_engines_get_packets() -> None:
    animation = short_animation(5)

    async def receive() -> tuple[list[bytes], list[bytes]]:
        inboxes = []
        for _ in range(2):
            inbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            inbox.bind(("127.0.0.1", 0))
            inbox.settimeout(5)
            inboxes.append(inbox)
        names, rate = animation.channels.names, animation.rate
        encoders = (vmc_encoder(names, "arkit"), livelink_encoder(names, rate, "mien"))
        packets = tuple((inbox.getsockname(), encode) for inbox, encode in zip(inboxes, encoders, strict=True))
        played = await stream(animation, Outlets(None, packets), clock=SimulatedClock())
        found = [[inbox.recv(65536) for _ in range(played.frames)] for inbox in inboxes]
        for inbox in inboxes:
            inbox.close()
        return found[0], found[1]

    vmc, livelink = asyncio.run(receive())
    sent = dict(a for address, a in decode_packet(vmc[0]) if address == "/VMC/Ext/Blend/Val")
    assert sent["JawOpen"] == pytest.approx(animation.channels.channel("jawOpen")[0], abs=1e-6)
    packet = decode_livelink(livelink[0])
    assert (packet.subject, packet.rate) == ("mien", (100, 1))
    assert packet.numbers[17] == pytest.approx(animation.channels.channel("jawOpen")[0], abs=1e-6)


def test_the_sound_and_the_moment_of_frame_0_are_told() -> None:
    animation = short_animation(5)

    async def watch() -> tuple[Greeting, str, bytes, float]:
        opened: asyncio.Future[int | None] = asyncio.get_running_loop().create_future()
        playing = asyncio.create_task(stream(animation, Outlets(Access(port=0)), wait=True, opened=opened.set_result))
        port = await opened
        sound = await asyncio.to_thread(lambda: urlopen(f"http://127.0.0.1:{port}/sound.wav").read())
        async with connect(f"ws://127.0.0.1:{port}") as client:
            greeting = Greeting.decode(str(await client.recv()))
            event = str(await client.recv())
            await client.recv()
            first = time.time()
            await playing
        return greeting, event, sound, first

    greeting, event, sound, first = asyncio.run(watch())
    assert (greeting.facts["sound"], greeting.facts["began"]) == ("/sound.wav", None)
    began = json.loads(event)
    assert began["event"] == "began"
    assert abs(first - began["at"]) < 2.0
    with wave.open(io.BytesIO(sound)) as read:
        assert read.getnframes() == len(animation.utterance.audio)


def test_waiting_for_an_engine_loses_no_frame() -> None:
    animation = short_animation(5)

    async def receive() -> list[bytes]:
        inbox = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        inbox.bind(("127.0.0.1", 0))
        address = inbox.getsockname()
        inbox.close()
        packets = ((address, livelink_encoder(animation.channels.names, animation.rate, "mien")),)
        playing = asyncio.create_task(stream(animation, Outlets(None, packets), wait=True, clock=SimulatedClock()))
        await asyncio.sleep(0.4)
        assert not playing.done(), "it began though nobody listened"
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inbox:
            inbox.bind(address)
            inbox.settimeout(5)
            played = await playing
            return [inbox.recv(65536) for _ in range(played.frames)]

    numbers = [decode_livelink(packet).frame for packet in asyncio.run(receive())]
    assert len(numbers) >= 5


def test_an_engine_that_is_not_there_yet_is_no_fault() -> None:
    async def send() -> None:
        closed = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        closed.bind(("127.0.0.1", 0))
        address = closed.getsockname()
        closed.close()
        async with datagrams(address) as put:
            for _ in range(5):
                put.send(b"x")
                await asyncio.sleep(0.01)

    asyncio.run(send())


def test_a_loop_goes_on_in_number_and_time() -> None:
    animation = short_animation(3)

    async def watch() -> list[Frame]:
        opened: asyncio.Future[int | None] = asyncio.get_running_loop().create_future()
        playing = asyncio.create_task(
            stream(animation, Outlets(Access(port=0)), wait=True, loop=True, opened=opened.set_result)
        )
        async with connect(f"ws://127.0.0.1:{await opened}") as client:
            assert json.loads(await client.recv())["facts"]["round"] == pytest.approx(0.03)
            await client.recv()  # when frame 0 stands
            frames = [decode_frame(bytes(await client.recv(decode=False))) for _ in range(8)]
        playing.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await playing
        return frames

    for frame in asyncio.run(watch()):
        assert frame.time == pytest.approx(frame.number / 100)
        np.testing.assert_array_equal(frame.values, animation.channels.values[frame.number % 3].astype(np.float32))


def test_the_greeting_is_plain_json() -> None:
    assert json.loads(GREETING.encode())["version"] == 1
