"""How fast does the studio's page draw? A third of docs/tables/live.md; run ``live.py``.

* A line is performed in ``mien studio``, opened in Chromium without a window and without a graphics card (software
  drawing, 1280 x 720), and played in a loop for `SECONDS`. The page counts itself (`window.mienStats`): milliseconds
  from picture to picture, and of work for each on the page's own thread. Beside it stands the processor time of that
  thread for each picture (Chromium's trace of `FireAnimationFrame`): what the page itself takes, on any machine that
  draws, whatever else this one has to do.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

SECONDS = 15.0
PATIENCE = 180.0
LINE = "I never said that. Maybe five people heard my voice!"
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--autoplay-policy=no-user-gesture-required",
    "--window-size=1280,720",
)


class Page:
    """A page of Chromium, told what to do over its debugging socket."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._numbers = socket, itertools.count(1)
        self._traced: list[dict[str, Any]] = []

    async def run(self, script: str) -> Any:
        """The value of a JavaScript expression."""
        answer = await self._asked(
            "Runtime.evaluate", {"expression": script, "awaitPromise": True, "returnByValue": True}
        )
        if "error" in answer:  # the page was being replaced while it was asked
            return None
        if "exceptionDetails" in answer["result"]:
            raise RuntimeError(f"the page said {answer['result']['exceptionDetails']}")
        return answer["result"]["result"].get("value")

    async def _asked(self, method: str, given: dict[str, Any]) -> dict[str, Any]:
        number = next(self._numbers)
        await self._socket.send(json.dumps({"id": number, "method": method, "params": given}))
        while (answer := await self._told()).get("id") != number:
            pass
        return answer

    async def _told(self) -> dict[str, Any]:
        told: dict[str, Any] = json.loads(await self._socket.recv())
        if told.get("method") == "Tracing.dataCollected":
            self._traced += told["params"]["value"]
        return told

    async def processor_times(self, seconds: float) -> list[float]:
        """Milliseconds of processor time that the page's thread takes for each picture."""
        await self._asked("Tracing.start", {"traceConfig": {"includedCategories": ["devtools.timeline"]}})
        await asyncio.sleep(seconds)
        await self._asked("Tracing.end", {})
        while (await self._told()).get("method") != "Tracing.tracingComplete":
            pass
        return [one["tdur"] / 1000 for one in self._traced if one["name"] == "FireAnimationFrame" and "tdur" in one]

    async def until(self, script: str) -> None:
        """Wait for an expression to be true."""
        end = time.monotonic() + PATIENCE
        while not await self.run(script):
            if time.monotonic() > end:
                raise RuntimeError(f"the page never came to {script}")
            await asyncio.sleep(0.2)


async def measured(address: str, port: int) -> dict[str, Any]:
    """What the page counted while it played."""
    pages = await asyncio.to_thread(_pages, port)
    socket = next(page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page")
    async with connect(socket, max_size=None) as open_socket:
        page = Page(open_socket)
        await page.until(f"location.href.startsWith({json.dumps(address.split('?')[0])}) && !!document.body")
        await page.until("document.body.dataset.ready === 'true'")
        await page.run(
            f"(() => {{ const field = document.querySelector('#field-text'); field.value = {json.dumps(LINE)};"
            "field.dispatchEvent(new Event('input', {bubbles: true}));"
            "field.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter', bubbles: true, cancelable: true})); })()"
        )
        await page.until("document.querySelector('.told').childElementCount > 0")
        await page.until("document.querySelector('.told').childElementCount === 0")
        await page.run("document.querySelector('[data-do=loop]').click()")
        await page.run("document.querySelector('[data-do=play]').click()")
        await asyncio.sleep(3.0)  # it chooses how fine its pictures are
        await page.run("window.mienStats.reset()")
        times = await page.processor_times(SECONDS)
        return dict(await page.run("window.mienStats.summary()")) | {"processor": times}


def _pages(port: int) -> list[dict[str, Any]]:
    end = time.monotonic() + PATIENCE
    while True:
        with contextlib.suppress(OSError), urllib.request.urlopen(f"http://127.0.0.1:{port}/json", timeout=5) as answer:
            found: list[dict[str, Any]] = json.loads(answer.read())
            if any(page["type"] == "page" for page in found):
                return found
        if time.monotonic() > end:
            raise RuntimeError("Chromium did not start")
        time.sleep(0.2)


@contextlib.contextmanager
def studio() -> Iterator[str]:
    """The address of a studio that runs while the context lasts."""
    command = [sys.executable, "-m", "mien", "studio", "--no-browser", "--port", "0", "--folder", tempfile.mkdtemp()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        try:
            assert running.stdout is not None
            yield next(found[0] for line in running.stdout if (found := re.search(r"http://\S+", line)))
        finally:
            running.terminate()


@contextlib.contextmanager
def chromium(address: str) -> Iterator[int]:
    """The debugging port of a browser that shows an address."""
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        raise SystemExit("the page is measured in Chromium: apt install chromium")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        command = [program, *_FLAGS, "--remote-debugging-port=0", f"--user-data-dir={folder}", address]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
            try:
                assert running.stderr is not None
                listening = (re.search(r"ws://127\.0\.0\.1:(\d+)/", line) for line in running.stderr)
                yield next(int(found[1]) for found in listening if found)
            finally:
                running.terminate()


def section() -> Iterator[str]:
    """The lines of the table."""
    with studio() as address, chromium(address) as port:
        found = asyncio.run(measured(address, port))
    yield "## The studio's page\n"
    yield "Definitions stand at the head of `benchmarks/live_page.py`.\n"
    heads = (
        "from picture to picture: median",
        "99 %",
        "work for each: median",
        "99 %",
        "its processor time: median",
        "99 %",
    )
    yield f"| pictures | {' | '.join(heads)} |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    pace, work, own = found["intervals"], found["work"], found["processor"]
    if pace["p50"] is None:
        raise SystemExit("the page drew too few pictures to say how long they take: is this machine busy?")
    yield (
        f"| {found['pictures']} | {pace['p50']:.0f} ms | {pace['p99']:.0f} ms | {work['p50']:.0f} ms | "
        f"{work['p99']:.0f} ms | {np.median(own):.1f} ms | {np.percentile(own, 99):.1f} ms |"
    )
