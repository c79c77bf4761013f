"""How long a person waits in the studio: from a typed line to a face, from a drag to a changed face.

    python benchmarks/studio.py                 writes docs/tables/studio.md
    python benchmarks/studio.py --print-only

Starts ``mien studio`` as a program and asks it over HTTP, as the page does. Medians of several asks, all in one run
on one machine, each of a line that was never said before. In brackets seconds of the studio's processor time: where a
machine has other work to do, they say more than the clock. The page's own time for drawing is measured by
``benchmarks/live_page.py``.
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
TIMES = 5
THINGS = (
    "river",
    "stone",
    "window",
    "garden",
    "letter",
    "morning",
    "silver",
    "forest",
    "button",
    "candle",
    "market",
    "winter",
    "summer",
    "basket",
    "finger",
)
PAUSE = 2.0
"""Seconds between the last letter that is typed and the press of the key."""
LONG_TEXT = (
    "When the sunlight strikes raindrops in the air, they act as a prism and form a rainbow. The rainbow is a "
    "division of white light into many beautiful colours. <happy>These take the shape of a long round arch, with "
    "its path high above, and its two ends apparently beyond the horizon.</happy> There is, according to legend, "
    "a boiling pot of gold at one end. People look, but no one ever finds it. When a man looks for something "
    "beyond his reach, his friends say he is looking for the pot of gold at the end of the rainbow. Throughout "
    "the centuries people have explained the rainbow in various ways. Some have accepted it as a miracle without "
    "physical explanation. To the Hebrews it was a token that there would be no more universal floods. The Greeks"
    " used to imagine that it was a sign from the gods to foretell war or heavy rain. The Norsemen considered the"
    " rainbow as a bridge over which the gods passed from earth to their home in the sky. Others have tried to "
    "explain the phenomenon physically. Aristotle thought that the rainbow was caused by reflection of the rays "
    "of the sun by the rain. Since then physicists have found that it is not reflection, but refraction by the "
    "raindrops which causes the rainbows. Many complicated ideas about the rainbow have been formed. The "
    "difference in the rainbow depends considerably upon the size of the drops, and the width of the coloured "
    "band increases as the size of the drops increases. <surprised> The actual primary rainbow observed is said "
    "to be the effect of superimposition of a number of bows. If the red of the second bow falls upon the green "
    "of the first, the result is to give a bow with an abnormally wide yellow band, since red and green light "
    "mixed together form yellow."
)


class Studio:
    """A running studio, asked over HTTP."""

    def __init__(self, address: str, program: int) -> None:
        place, self.program = urlsplit(address), program
        self.host, self.port = place.hostname or "127.0.0.1", place.port

    def processor(self) -> float:
        """Seconds of processor time that it has taken."""
        times = Path(f"/proc/{self.program}/stat").read_text().rpartition(")")[2].split()
        return (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")

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
        """What a job made, asked for as the page asks."""
        while True:
            told: dict[str, Any] = json.loads(self.ask("GET", f"/api/jobs/{json.loads(answer)['job']}?wait=4"))
            if told["state"] not in ("queued", "running"):
                return told

    def take(self, **asked: Any) -> str:
        return str(self.done(self.ask("POST", "/api/takes", asked))["take"])


Spent = tuple[float, float]  # seconds, seconds of processor time


def median(studio: Studio, ask: Callable[[int], object], times: int = TIMES) -> Spent:
    """Median over asks that each differ."""
    spent = []
    for number in range(times):
        clock, processor = time.perf_counter(), studio.processor()
        ask(number)
        spent.append((time.perf_counter() - clock, studio.processor() - processor))
    return float(np.median([wall for wall, _ in spent])), float(np.median([own for _, own in spent]))


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


def never_said(line: str, number: int) -> str:
    """A line that no memory knows: one more word at its end, another each time."""
    return f"{line[:-1]} {THINGS[number % len(THINGS)]}."


def measured(studio: Studio, line: str) -> dict[str, Any]:
    """Seconds for one line."""

    def typed(number: int) -> None:
        studio.ask("GET", f"/api/takes/{studio.take(text=never_said(line, number), emotion='happy')}/frames")

    def prepared(number: int) -> Spent:
        studio.ask("POST", "/api/ahead", {"text": never_said(line, number), "emotion": "happy"})
        time.sleep(PAUSE)
        return median(studio, lambda _: typed(number), 1)

    spent: dict[str, Any] = {
        "typed to frames (voice and motion)": median(studio, typed, 3),
        f"the same, {PAUSE:g} s after the last letter": tuple(np.median([prepared(3 + n) for n in range(3)], axis=0)),
    }
    take = studio.take(text=line, emotion="happy")
    told = json.loads(studio.ask("GET", f"/api/takes/{take}"))
    word = told["words"][2][2]
    emotions = ("sad", "angry", "afraid", "surprised", "disgusted", "contempt", "frustrated")

    def redo(number: int) -> None:
        asked = {"emotion": emotions[number % len(emotions)]}
        made = studio.done(studio.ask("POST", f"/api/takes/{take}/redo", asked))
        studio.ask("GET", f"/api/takes/{made['take']}/frames")

    spent["another emotion to frames"] = median(studio, redo)
    edits: dict[str, Callable[[int], dict[str, Any]]] = {
        "a channel's key dropped to frames": lambda n: channel(word, 0.1 + 0.05 * n),
        "an intensity's point dropped to frames": lambda n: intensity(word, 0.2 + 0.1 * n),
        "a border dropped to frames": lambda n: border(word, 0.002 * (n + 1)),
    }
    for name, edit in edits.items():

        def drop(number: int, edit: Callable[[int], dict[str, Any]] = edit) -> None:
            studio.ask("PUT", f"/api/takes/{take}/edits", layer(edit(number)))
            studio.ask("GET", f"/api/takes/{take}/frames")

        spent[name] = median(studio, drop)
    return {"seconds of sound": told["seconds"], **spent}


def long_text(studio: Studio) -> str:
    """When what of a long text can be heard and seen."""
    clock, job, known, told = (
        time.perf_counter(),
        json.loads(studio.ask("POST", "/api/takes", {"text": LONG_TEXT})),
        "",
        [],
    )
    while True:
        now = json.loads(studio.ask("GET", f"/api/jobs/{job['job']}?wait=5"))
        shown = now.get("take") or now.get("beginning") or ""
        if shown not in ("", known):
            known = shown
            about = json.loads(studio.ask("GET", f"/api/takes/{shown}"))
            for what in ("frames", "sound.wav"):
                studio.ask("GET", f"/api/takes/{shown}/{what}")
            told.append(f"{about['seconds']:.0f} s of it after {time.perf_counter() - clock:.1f} s")
        if now["state"] not in ("queued", "running"):
            return f"A text of {len(LONG_TEXT.split())} words with tags can be heard and seen: {', '.join(told)}."


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
        studio = Studio(found.group(), program.pid)
        first = studio.take(text=SHORT, emotion="happy")
        studio.ask("GET", f"/api/takes/{first}/frames")
        first_line = time.perf_counter() - clock
        columns = [measured(studio, line) for line in (SHORT, LONG)]
        face, _ = median(studio, lambda _: studio.ask("GET", "/api/faces/default.glb"))
        beginnings = long_text(studio)
        load = os.getloadavg()[1]
        program.terminate()
    table = "\n".join(
        [
            "# How long one waits in the studio",
            "",
            "Written by `python benchmarks/studio.py`: seconds over HTTP on loopback, medians in one run, 60 frames/s, "
            f"{os.cpu_count()} shared cores, {platform.machine()}, "
            f"on which {load:.0f} programs wanted to run on average; in brackets the studio's processor time.",
            "",
            "| | " + " | ".join(f"{column['seconds of sound']:.1f} s of sound" for column in columns) + " |",
            "| --- |" + " --- |" * len(columns),
            *(
                f"| {name} | " + " | ".join("{:.3f} ({:.3f})".format(*column[name]) for column in columns) + " |"
                for name in columns[0]
                if name != "seconds of sound"
            ),
            "",
            f"From the command to the open page: {opened:.1f} s; to the first line's frames, everything loaded on the "
            f"way: {first_line:.1f} s. The default face once it is made: {face:.3f} s.",
            "",
            beginnings,
            "",
        ]
    )
    print(table)
    if not options.print_only:
        (ROOT / "docs" / "tables" / "studio.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
