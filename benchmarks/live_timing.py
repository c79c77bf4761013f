"""How late, how much work, how many at once? A third of docs/tables/live.md; run ``live.py``.

* Late: from the instant at which a sound is made until the frame that shows it has been received by a WebSocket client
  in another process; the source gives 10 ms of sound every 10 ms, as a sound card does. The stated look-ahead is part
  of it.
* Processor: seconds of one core for each second of a stream, everything in the process counted.
* Streams at once: processes of one stream each, started together; a stream is held if fewer than 1 % of its frames were
  skipped for lateness.
* Gaps: time between two frames at nine clients that read, while a process beside them has one that never reads,
  one that is cut off and comes again ten times a second, and one that sends garbage; beside the same nine alone.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import numpy as np
from websockets.asyncio.client import connect

from mien.core.timeline import FrameRate
from mien.motion.performers import load_performer
from mien.serve.live.animator import LiveAnimator, LiveSettings
from mien.serve.live.frames import Frame, Greeting, decode_frame
from mien.serve.live.live_performance import Performed, perform_live
from mien.serve.live.sockets import Access
from mien.serve.live.sound_stream import Inbox
from mien.serve.live.streaming import Outlets, opened_outlets
from mien.speech.streaming_features import RATE

SECONDS = 20.0
LOOK_AHEADS = (0.05, 0.1, 0.15, 0.3)
STREAMS = (1, 2, 4, 6, 8, 10, 12, 16)
HELD = 0.01
BLOCK = 0.01


def speechlike(seconds: float) -> np.ndarray:
    """Syllables of made-up vowels, four a second, a pause every three seconds."""
    times, random = np.arange(round(seconds * RATE)) / RATE, np.random.default_rng(1)
    wave = np.zeros(len(times))
    for start in np.arange(0, seconds, 0.25):
        inside = (times >= start) & (times < start + 0.25)
        pitch, centre = random.uniform(100, 140), random.uniform(400, 1800)
        for k in range(1, 40):
            wave[inside] += np.sin(2 * np.pi * pitch * k * times[inside]) / (1 + ((pitch * k - centre) / 250) ** 2)
    wave *= np.clip(2 * np.sin(2 * np.pi * 4 * times), 0, 1) * (times % 3 < 2.5)
    return (0.1 * wave + random.normal(0, 1e-3, len(wave))).astype(np.float32)


class SoundCard:
    """Gives a block of sound every 10 ms; ``began`` is the instant at which its first sample was made."""

    name, stored = "sound card", False

    def __init__(self, seconds: float) -> None:
        self.inbox, self.began = Inbox(), 0.0
        self._blocks = np.array_split(speechlike(seconds), round(seconds / BLOCK))
        self._thread = threading.Thread(target=self._give, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        pass

    def _give(self) -> None:
        self.began = time.monotonic()
        for number, block in enumerate(self._blocks):
            time.sleep(max(0.0, self.began + (number + 1) * BLOCK - time.monotonic()))
            self.inbox.put(block)
        self.inbox.end()


def client(address: str, readers: int = 1) -> subprocess.Popen[str]:
    """Another process in which clients read and note when each frame came."""
    return subprocess.Popen(
        [sys.executable, __file__, "read", address, str(readers)], stdout=subprocess.PIPE, text=True
    )


async def _read(address: str) -> list[tuple[int, float]]:
    came = []
    async with connect(address) as socket:
        await socket.recv()
        while isinstance(message := await socket.recv(), bytes):
            came.append((decode_frame(message).number, time.monotonic()))
    return came


async def _read_all(address: str, readers: int) -> list[list[tuple[int, float]]]:
    return await asyncio.gather(*(_read(address) for _ in range(readers)))


def lateness(look_ahead: float) -> tuple[np.ndarray, Performed, float]:
    """Seconds from a sound to its frame at a client, what was done, and the share of a core that it took."""
    animator = LiveAnimator(load_performer("default"), LiveSettings(look_ahead))
    source, readers, shown = SoundCard(SECONDS), [], dict[int, float]()
    spent = [0.0, 0.0]

    def opened(port: int | None) -> None:
        readers.append(client(f"ws://127.0.0.1:{port}"))
        spent[:] = [time.process_time(), time.monotonic()]

    performed = asyncio.run(
        perform_live(
            source,
            animator,
            Outlets(Access(port=0)),
            performer="default",
            wait=True,
            opened=opened,
            watch=shown.__setitem__,
        )
    )
    work = (time.process_time() - spent[0]) / SECONDS
    came = json.loads(readers[0].communicate()[0])[0]
    late = [at - (source.began + shown[n]) for n, at in came if 2 < shown.get(n, 0.0) < SECONDS - 1]
    return np.array(late), performed, work


def streams_held() -> Iterator[str]:
    """A row for each number of streams that was tried."""
    for count in STREAMS:
        command, pipe = [sys.executable, __file__, "stream"], subprocess.PIPE
        running = [subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) for _ in range(count)]
        for one in running:
            assert one.stdout is not None
            one.stdout.readline()  # it is ready
        shares = [float(answer) for answer in _begun(running)]
        held = sum(share < HELD for share in shares)
        yield f"| {count} | {held} | {np.mean(shares):.2%} |"
        if held < count / 2:
            return


def _begun(running: list[subprocess.Popen[str]]) -> list[str]:
    """Let all begin at once; what they say at their end."""
    for one in running:
        assert one.stdin is not None
        one.stdin.write("\n")
        one.stdin.flush()
    return [one.communicate()[0] for one in running]


def _stream() -> float:
    """The share of frames that one stream skips in this process; begins when it is told to."""
    animator = LiveAnimator(load_performer("default"))
    source = SoundCard(SECONDS / 2)
    print("ready", flush=True)
    sys.stdin.readline()
    performed = asyncio.run(perform_live(source, animator, Outlets(), performer="default"))
    return performed.skipped / max(performed.frames + performed.skipped, 1)


async def gaps(troubled: bool, frames: int = 450) -> np.ndarray:
    """Seconds between frames at nine clients."""
    rate = FrameRate.of(30)
    async with opened_outlets(Outlets(Access(port=0)), Greeting(("jawOpen",), 30.0)) as outlets:
        address = f"ws://127.0.0.1:{outlets.port}"
        reading = client(address, 9)
        while len(outlets.hub) < 9:
            await asyncio.sleep(0.01)
        trouble = subprocess.Popen([sys.executable, __file__, "trouble", address]) if troubled else None
        start = time.monotonic()
        for number in range(frames):
            await asyncio.sleep(max(0.0, start + rate.time_of(number) - time.monotonic()))
            outlets.send(Frame(number, rate.time_of(number), np.zeros(71)))
        if trouble is not None:
            trouble.kill()
            trouble.wait()
        outlets.hub.end()
        text = await asyncio.to_thread(reading.communicate)
    came = json.loads(text[0])
    return np.concatenate([np.diff([at for _, at in one]) for one in came])


async def _never_reads(address: str) -> None:
    async with connect(address, max_queue=1):
        await asyncio.sleep(3600)


async def _comes_and_goes(address: str) -> None:
    while True:
        socket = await connect(address)
        await asyncio.sleep(0.1)
        socket.transport.abort()


async def _shouts(address: str) -> None:
    port, random = int(address.rsplit(":", 1)[1]), np.random.default_rng(3)
    while True:
        with contextlib.suppress(OSError):
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(random.bytes(int(random.integers(1, 20_000))))
            await asyncio.sleep(0.05)
            writer.close()


async def _trouble(address: str) -> None:
    await asyncio.gather(_never_reads(address), _comes_and_goes(address), _shouts(address))


def section() -> Iterator[str]:
    """The lines of the table."""
    yield "## In real time\n"
    yield "Definitions stand at the head of `benchmarks/live_timing.py`. 30 frames a second.\n"
    yield "| look-ahead | late: median | 99 % | frames skipped | processor |"
    yield "| --- | --- | --- | --- | --- |"
    for look_ahead in LOOK_AHEADS:
        late, performed, work = lateness(look_ahead)
        p50, p99 = np.percentile(late, [50, 99]) * 1000
        skipped = performed.skipped / (performed.frames + performed.skipped)
        yield f"| {look_ahead * 1000:g} ms | {p50:.0f} ms | {p99:.0f} ms | {skipped:.1%} | {work:.0%} of a core |"
    yield f"\n| streams at once ({_cores()} cores) | held | frames skipped, mean |"
    yield "| --- | --- | --- |"
    yield from streams_held()
    yield "\n| nine clients that read | gap: median | 99 % | 99.9 % |"
    yield "| --- | --- | --- | --- |"
    for name, troubled in (("alone", False), ("beside three that misbehave", True)):
        p50, p99, p999 = np.percentile(asyncio.run(gaps(troubled)), [50, 99, 99.9]) * 1000
        yield f"| {name} | {p50:.1f} ms | {p99:.1f} ms | {p999:.1f} ms |"


def _cores() -> int:
    import os

    return len(os.sched_getaffinity(0))


if __name__ == "__main__":
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        if sys.argv[1] == "read":
            print(json.dumps(asyncio.run(_read_all(sys.argv[2], int(sys.argv[3])))))
        elif sys.argv[1] == "trouble":
            asyncio.run(_trouble(sys.argv[2]))
        else:
            print(_stream())
