"""Ordinary and hostile clients at the studio and at ``mien live`` for a while: ``python -m tools.soak --minutes 20``.

Prints the memory of both every minute. Ordinary clients make takes, read and export them, and listen to the stream;
hostile ones send half a request, garbage, floods, texts that make careless readers take days, stop reading, or break
off. Exit code 1 if a server ended or printed a traceback, an ordinary client was not served, a stalled listener was not
cut off, or memory rose by more than half in the second half of the time.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import random
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import IO

import aiohttp
import numpy as np

MIEN = (sys.executable, "-m", "mien")
_LINES = ("Hello there.", "I never said that!", "<angry>No.</angry> Well.", "Three of 24/7.", "Oh.", "Was it you?")
_BOMBS = (
    "<!-- a --" * 20_000,
    "<b>" * 5_000,
    "&a;" * 10_000,
    " " * 100_000 + "x",
    "9" * 6_000,
    '<a b="' * 9_000,
    "\ud800",
    "",
)
_told: list[IO[bytes]] = []  # what the servers said on standard error
_HELLO = (
    b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
_CUT_OFF_WITHIN = 15.0  # seconds; the servers' patience is 5, on a machine that is not overrun


def memory(pid: int) -> float:
    """Megabytes of a process and its children."""
    pages = 0.0
    with contextlib.suppress(OSError):
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        pages = int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024  # type: ignore[index]
        for task in Path(f"/proc/{pid}/task").iterdir():
            pages += sum(memory(int(child)) for child in (task / "children").read_text(encoding="utf-8").split())
    return pages


class Soak:
    """Clients of both servers, and what became of them."""

    def __init__(self, studio: int, live: int, seed: int) -> None:
        self.studio, self.live, self.dice = studio, live, random.Random(seed)
        self.seen: Counter[str] = Counter()
        self.faults: list[str] = []

    async def ordinary(self, web: aiohttp.ClientSession) -> None:
        """A take, its frames, its sound, an edit that is refused or not, an export."""
        base = f"http://127.0.0.1:{self.studio}"
        asked = {"text": self.dice.choice(_LINES), "emotion": self.dice.choice(["", "happy:0.5", "sad"])}
        async with web.post(f"{base}/api/takes", json={k: v for k, v in asked.items() if v}) as answer:
            if answer.status in (429, 503):
                self.seen["studio busy"] += 1
                return
            job = (await answer.json())["job"]
        take = (await self._finished(web, base, job))["take"]
        async with web.get(f"{base}/api/takes/{take}/frames") as answer:
            assert len(await answer.read()) > 1000
        async with web.get(f"{base}/api/takes/{take}/sound.wav") as answer:
            assert (await answer.read())[:4] == b"RIFF"
        export = {"formats": [self.dice.choice([".csv", ".TextGrid", ".json"])]}
        async with web.post(f"{base}/api/takes/{take}/export", json=export) as answer:
            told = await self._finished(web, base, (await answer.json())["job"])
        async with web.get(base + told["file"]) as answer:
            assert len(await answer.read()) > 100
        self.seen["takes"] += 1

    async def _finished(self, web: aiohttp.ClientSession, base: str, job: str) -> dict[str, str]:
        while True:
            async with web.get(f"{base}/api/jobs/{job}") as answer:
                told: dict[str, str] = await answer.json()
            if told["state"] not in ("queued", "running"):
                assert told["state"] == "done", told
                return told
            await asyncio.sleep(0.2)

    async def bomb(self, web: aiohttp.ClientSession) -> None:
        """A text that is hard to read: refused, or made, but the studio stays."""
        body = json.dumps({"text": self.dice.choice(_BOMBS)}).encode()
        head = {"Content-Type": "application/json"}
        async with web.post(f"http://127.0.0.1:{self.studio}/api/takes", data=body, headers=head) as answer:
            self.seen[f"bomb {answer.status}"] += 1

    async def garbage(self, web: aiohttp.ClientSession) -> None:
        """Half requests, noise, floods and sudden ends at either port."""
        port = self.dice.choice([self.studio, self.live])
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        kind = self.dice.randrange(5)
        begin = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        piece = (
            begin,
            self.dice.randbytes(5000),
            begin + b"X: " + b"a" * 300_000,
            b"\r\n" * 50_000,
            b"POST /api/takes ",
        )
        with contextlib.suppress(OSError):
            writer.write(piece[kind])
            await asyncio.wait_for(writer.drain(), 5)
            if self.dice.random() < 0.5:
                await asyncio.wait_for(reader.read(1000), 20)
        writer.close()
        self.seen["garbage"] += 1

    async def flood(self, web: aiohttp.ClientSession) -> None:
        """A face that is none, of many megabytes."""
        base = f"http://127.0.0.1:{self.studio}"
        async with web.post(f"{base}/api/faces", data=self.dice.randbytes(20_000_000)) as answer:
            self.seen[f"flood {answer.status}"] += 1

    async def listener(self, web: aiohttp.ClientSession) -> None:
        """Listen to the stream for a while: frames come in order."""
        async with web.ws_connect(f"http://127.0.0.1:{self.live}") as stream:
            frames = 0
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self.dice.uniform(3, 15)):
                    async for _ in stream:
                        frames += 1
        if not frames:
            self.faults.append("a listener got no frame")
        self.seen["listeners"] += 1

    async def stalled(self, web: aiohttp.ClientSession) -> None:
        """Say hello and never read: to be cut off."""
        seconds = await asyncio.to_thread(_cut_off_after, self.live)
        self.seen["stalled, cut off" if seconds is not None else "stalled, never cut off"] += 1
        self.seen["longest stall (s)"] = max(self.seen["longest stall (s)"], round(seconds or 0))

    async def forever(self, kind: Callable[[aiohttp.ClientSession], Awaitable[None]], until: float) -> None:
        """One client of a kind after another."""
        timeout = aiohttp.ClientTimeout(total=240)
        async with aiohttp.ClientSession(timeout=timeout) as web:
            while time.monotonic() < until:
                try:
                    await kind(web)
                except (aiohttp.ClientError, OSError, TimeoutError) as problem:
                    self.seen[f"{kind.__name__}: {type(problem).__name__}"] += 1
                except AssertionError as problem:
                    self.faults.append(f"{kind.__name__}: {problem}")
                await asyncio.sleep(self.dice.uniform(0.1, 1.0))


def _cut_off_after(port: int) -> float | None:
    """Seconds after which the stream cuts off who does not read; None: it did not within half a minute."""
    began = time.monotonic()
    with socket.create_connection(("127.0.0.1", port)) as held:
        held.sendall(_HELLO)
        while time.monotonic() - began < 30:
            time.sleep(0.5)
            try:
                held.sendall(b"\x8a\x80abcd")  # a pong nobody asked for; it fails once we were cut off
            except OSError:
                return time.monotonic() - began
    return None


async def sounded(live: subprocess.Popen[bytes], until: float) -> None:
    """Half a second of something like speech every half second."""
    assert live.stdin is not None
    random_, began, sent = np.random.default_rng(1), time.monotonic(), 0.0
    while time.monotonic() < until and live.poll() is None:
        phase = np.arange(8000) / 16000
        sound = np.sin(2 * np.pi * 150 * phase) * (np.sin(2 * np.pi * 3 * phase) > 0) + 0.1 * random_.normal(size=8000)
        await asyncio.to_thread(live.stdin.write, (8000 * sound).astype("<i2").tobytes())
        sent += 0.5
        await asyncio.sleep(max(0.0, began + sent - time.monotonic()))


def started(*arguments: str) -> tuple[subprocess.Popen[bytes], int]:
    """A server, and the port that it tells."""
    told = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process
    process = subprocess.Popen([*MIEN, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=told)
    _told.append(told)
    assert process.stdout is not None
    while line := process.stdout.readline().decode():
        if found := re.search(r":(\d+)", line):
            return process, int(found[1])
    raise SystemExit(f"mien {' '.join(arguments)} did not start")


async def soak(minutes: float, seed: int) -> int:
    """Run; returns the exit code."""
    (studio, studio_port), (live, live_port) = (
        started("studio", "--port", "0", "--no-browser", "--folder", tempfile.mkdtemp()),
        started("live", "-", "--port", "0"),
    )
    clients, until = Soak(studio_port, live_port, seed), time.monotonic() + minutes * 60
    kinds = [clients.ordinary, clients.bomb, clients.garbage, clients.flood, clients.listener, clients.stalled]
    tasks = [asyncio.create_task(clients.forever(kind, until)) for kind in (*kinds, *kinds[-3:], clients.garbage)]
    tasks.append(asyncio.create_task(sounded(live, until)))
    taken: list[tuple[float, float]] = []
    try:
        while time.monotonic() < until:
            await asyncio.sleep(min(60.0, max(0.1, until - time.monotonic())))
            taken.append((memory(studio.pid), memory(live.pid)))
            told = "  ".join(f"{name} {size:.0f} MB" for name, size in zip(("studio", "live"), taken[-1], strict=True))
            print(f"{len(taken):3d} min  {told}  {dict(clients.seen)}", flush=True)
            for name, process in (("studio", studio), ("live", live)):
                if process.poll() is not None:
                    clients.faults.append(f"{name} ended with {process.returncode}")
                    until = 0.0
        await asyncio.wait(tasks, timeout=60)
    finally:
        for process in (studio, live):
            process.terminate()
            process.wait(30)
    for told in _told:
        told.seek(0)
        words = told.read().decode(errors="replace")
        if "Traceback" in words:
            clients.faults.append(f"a traceback: {words[-500:]}")
    half = len(taken) // 2
    for place, name in enumerate(("studio", "live")):
        before, after = (max((row[place] for row in part), default=0.0) for part in (taken[:half], taken[half:]))
        if half > 2 and after > 1.5 * before:
            clients.faults.append(f"{name}: {before:.0f} MB became {after:.0f}")
    if not clients.seen["takes"] or not clients.seen["listeners"]:
        clients.faults.append("ordinary clients were not served")
    if not clients.seen["stalled, cut off"] or clients.seen["longest stall (s)"] > _CUT_OFF_WITHIN:
        clients.faults.append("a stalled listener was not cut off")
    print(f"seen: {dict(clients.seen)}\nfaults: {clients.faults or 'none'}")
    return 1 if clients.faults else 0


def main() -> int:
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    return asyncio.run(soak(options.minutes, options.seed))


if __name__ == "__main__":
    sys.exit(main())
