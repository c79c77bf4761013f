"""How long a person waits in the studio: from a typed line to a face, from a drag to a changed face.

    python benchmarks/studio.py                 writes docs/tables/studio.md
    python benchmarks/studio.py --print-only

Starts ``mien studio`` as a program and asks it over HTTP, as the page does. Medians of several asks, all in one run
on one machine; the page's own time for drawing is measured by ``benchmarks/live_page.py``.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

ROOT = Path(__file__).parent.parent
SHORT = "I never said that."
LONG = (
    "The rainbow is a division of white light into many beautiful colours. These take the shape of a long round arch, "
    "with its path high above, and its two ends apparently beyond the horizon."
)
TIMES = 7


class Studio:
    """A running studio, asked over HTTP."""

    def __init__(self, address: str) -> None:
        place = urlsplit(address)
        self.host, self.port = place.hostname or "127.0.0.1", place.port

    def ask(self, method: str, path: str, body: Any = None, kind: str = "application/json") -> bytes:
        content = json.dumps(body).encode() if isinstance(body, dict) else body
        connection = http.client.HTTPConnection(self.host, self.port, timeout=600)
        connection.request(method, path, content, {"Content-Type": kind} if content is not None else {})
        answer = connection.getresponse()
        held = answer.read()
        connection.close()
        if answer.status >= 400:
            raise SystemExit(f"{method} {path}: {answer.status} {held[:200]!r}")
        return held

    def done(self, answer: bytes) -> dict[str, Any]:
        """What a job made, asked for as often as the page asks."""
        while True:
            told: dict[str, Any] = json.loads(self.ask("GET", f"/api/jobs/{json.loads(answer)['job']}"))
            if told["state"] not in ("queued", "running"):
                return told
            time.sleep(0.02)

    def take(self, **asked: Any) -> str:
        return str(self.done(self.ask("POST", "/api/takes", asked))["take"])


def median(ask: Callable[[int], object], times: int = TIMES) -> float:
    """Seconds, median over asks that each differ."""
    spent = []
    for number in range(times):
        clock = time.perf_counter()
        ask(number)
        spent.append(time.perf_counter() - clock)
    return float(np.median(spent))


def layer(*edits: dict[str, Any]) -> dict[str, Any]:
    return {"format": "mien-edits", "version": 1, "edits": list(edits)}


def channel(word: str, value: float) -> dict[str, Any]:
    keys = [{"anchor": {"word": word, "phone": 0, "share": 0.5}, "value": value}]
    return {"kind": "channel", "channel": "jawOpen", "mode": "add", "keys": keys}


def border(word: str, shift: float) -> dict[str, Any]:
    return {"kind": "border", "phone": {"word": word, "phone": 0}, "edge": "end", "shift": shift}


def intensity(word: str, value: float) -> dict[str, Any]:
    points = [{"anchor": {"word": word, "phone": 0, "share": 0.5}, "value": value}]
    return {"kind": "intensity", "emotion": "happy", "points": points}


def measured(studio: Studio, line: str) -> dict[str, float]:
    """Seconds for one line."""
    spent = {"typed to frames (voice and motion)": median(
        lambda n: studio.ask("GET", f"/api/takes/{studio.take(text=line, emotion='happy', seed=n + 1)}/frames"), 5
    )}  # fmt: skip
    take = studio.take(text=line, emotion="happy")
    told = json.loads(studio.ask("GET", f"/api/takes/{take}"))
    word = told["words"][2][2]
    emotions = ("sad", "angry", "afraid", "surprised", "disgusted", "contempt", "frustrated")

    def redo(number: int) -> None:
        asked = {"emotion": emotions[number % len(emotions)]}
        made = studio.done(studio.ask("POST", f"/api/takes/{take}/redo", asked))
        studio.ask("GET", f"/api/takes/{made['take']}/frames")

    spent["another emotion to frames"] = median(redo)
    edits: dict[str, Callable[[int], dict[str, Any]]] = {
        "a channel's key dropped to frames": lambda n: channel(word, 0.1 + 0.05 * n),
        "an intensity's point dropped to frames": lambda n: intensity(word, 0.2 + 0.1 * n),
        "a border dropped to frames": lambda n: border(word, 0.002 * (n + 1)),
    }
    for name, edit in edits.items():

        def drop(number: int, edit: Callable[[int], dict[str, Any]] = edit) -> None:
            studio.ask("PUT", f"/api/takes/{take}/edits", layer(edit(number)))
            studio.ask("GET", f"/api/takes/{take}/frames")

        spent[name] = median(drop)
    return {"seconds of sound": told["seconds"], **spent}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--print-only", action="store_true")
    options = parser.parse_args()
    clock = time.perf_counter()
    command = [sys.executable, "-m", "mien", "studio", "--no-browser", "--port", "0", "--folder", tempfile.mkdtemp()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        found = re.search(r"http://\S+", program.stdout.readline())
        assert found is not None
        opened = time.perf_counter() - clock
        studio = Studio(found.group())
        first = studio.take(text=SHORT, emotion="happy")
        studio.ask("GET", f"/api/takes/{first}/frames")
        first_line = time.perf_counter() - clock
        columns = [measured(studio, line) for line in (SHORT, LONG)]
        face = median(lambda _: studio.ask("GET", "/api/faces/default.glb"))
        program.terminate()
    table = "\n".join(
        [
            "# How long one waits in the studio",
            "",
            "Written by `python benchmarks/studio.py`: seconds over HTTP on loopback, medians in one run, 60 frames/s, "
            f"{os.cpu_count()} shared cores, {platform.machine()}.",
            "",
            "| | " + " | ".join(f"{column['seconds of sound']:.1f} s of sound" for column in columns) + " |",
            "| --- |" + " --- |" * len(columns),
            *(
                f"| {name} | " + " | ".join(f"{column[name]:.3f}" for column in columns) + " |"
                for name in columns[0]
                if name != "seconds of sound"
            ),
            "",
            f"From the command to the open page: {opened:.1f} s; to the first line's frames, everything loaded on the "
            f"way: {first_line:.1f} s. The default face (12 MB) once it is made: {face:.3f} s.",
            "",
        ]
    )
    print(table)
    if not options.print_only:
        (ROOT / "docs" / "tables" / "studio.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
