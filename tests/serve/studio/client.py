"""A running studio for tests, and a plain client of it."""

from __future__ import annotations

import asyncio
import http.client
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mien.serve.studio.server import running_studio
from mien.serve.studio.settings import StudioSettings
from mien.serve.studio.workshop import Workshop


@dataclass
class Answer:
    status: int
    body: bytes
    headers: dict[str, str]

    @property
    def json(self) -> Any:
        return json.loads(self.body)


@dataclass
class Client:
    port: int
    workshop: Workshop
    headers: dict[str, str] = field(default_factory=dict)

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> Answer:
        given = {**self.headers, **{name.replace("_", "-"): value for name, value in headers.items()}}
        if isinstance(body, (dict, list)):
            body, given = json.dumps(body).encode(), {"Content-Type": "application/json", **given}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            connection.request(method, path, body, given)
            answer = connection.getresponse()
            return Answer(answer.status, answer.read(), {k.lower(): v for k, v in answer.getheaders()})
        finally:
            connection.close()

    def finished(self, answer: Answer) -> dict[str, Any]:
        """What became of the job that was started."""
        assert answer.status == 202, answer.body
        while True:
            told: dict[str, Any] = self.ask("GET", f"/api/jobs/{answer.json['job']}").json
            if told["state"] not in ("queued", "running"):
                return told
            time.sleep(0.01)

    def take(self, **asked: Any) -> str:
        told = self.finished(self.ask("POST", "/api/takes", asked))
        assert told["state"] == "done", told
        return str(told["take"])


@contextmanager
def studio(settings: StudioSettings | None = None, folder: Path | None = None) -> Iterator[Client]:
    """A studio on any free port, in a thread of its own; it keeps its takes in a folder, if one is given."""
    settings = settings or StudioSettings(port=0)
    workshop = Workshop(settings.limits, folder, keeps=folder is not None)
    opened: list[int] = []
    ready, loop, stop = threading.Event(), asyncio.new_event_loop(), asyncio.Event()

    async def serve() -> None:
        async with running_studio(settings, workshop) as port:
            opened.append(port)
            ready.set()
            await stop.wait()

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    try:
        assert ready.wait(20)
        yield Client(opened[0], workshop)
    finally:
        loop.call_soon_threadsafe(stop.set)
        thread.join(20)
        workshop.close()
        loop.close()


def form(fields: dict[str, str], sound: bytes | None) -> tuple[bytes, str]:
    """A multipart body and its content type."""
    mark = "a-mark-between-parts"
    parts = [f'Content-Disposition: form-data; name="{name}"\r\n\r\n{value}'.encode() for name, value in fields.items()]
    if sound is not None:
        head = b'Content-Disposition: form-data; name="sound"; filename="line.wav"\r\nContent-Type: audio/wav\r\n\r\n'
        parts.append(head + sound)
    body = b"".join(f"--{mark}\r\n".encode() + part + b"\r\n" for part in parts) + f"--{mark}--\r\n".encode()
    return body, f"multipart/form-data; boundary={mark}"
