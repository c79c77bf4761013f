"""What a line costs before anything of the line is worked on: where the processor's time goes, part by part.

    python benchmarks/startup.py               the parts of ``mien say``, to a .csv and to a .mp4
    python benchmarks/startup.py --count       what is imported, read and fitted, as JSON (a test holds it)
    python benchmarks/startup.py --write       writes docs/tables/startup.md

Times are processor seconds (user and system, children included), the least of ``--runs`` runs in fresh processes, so
that another program on the machine disturbs little. A yardstick of plain Python is printed beside them: on another
machine read the ratios.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
LINE = "I never said that."
PARTS: tuple[tuple[str, str, str], ...] = (
    ("options read", "mien.cli.main", "_parser"),
    ("performer read", "mien.pipeline.options", "load_performer"),
    ("text read", "mien.speech.synthesis", "spoken_words"),
    ("voice: network opened", "mien.speech.voices.kokoro", "_network"),
    ("voice: spoken", "mien.speech.voices.kokoro", "Kokoro._speak"),
    ("sound aligned", "mien.speech.synthesis", "_aligned"),
    ("pitch found", "mien.speech.pitch", "_contour"),
    ("mouth", "mien.motion.mouth.learned_mouth", "LearnedMouth.perform"),
    ("mouth, made by hand", "mien.motion.mouth.hand_made_mouth", "HandMadeMouth.perform"),
    ("expression", "mien.motion.expression.expression", "Expression.perform"),
    ("signs of life", "mien.motion.alive.idle", "HandMadeIdle.perform"),
    ("brows and nods", "mien.motion.alive.visual_prosody", "HandMadeProsody.perform"),
    ("file written", "mien.cli.line_commands", "finish"),
    ("a frame", "mien.face.render.renderer", "Renderer.render"),
)
"""Label, module and attribute: what is inside a part that has a line of its own is not counted twice."""


def spent() -> float:
    """Processor seconds of this process and of those it waited for."""
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


class Clock:
    """Exclusive processor time of wrapped functions."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.frames: list[float] = []
        self._open: list[float] = []

    def wrap(self, label: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, timed."""

        def timed(*given: Any, **named: Any) -> Any:
            if label == "a frame":  # posing, drawing and encoding go on side by side: from one frame to the next
                self.frames.append(spent())
                return function(*given, **named)
            self._open.append(0.0)
            start = spent()
            try:
                return function(*given, **named)
            finally:
                whole, inside = spent() - start, self._open.pop()
                self.seconds[label] += whole - inside
                if self._open:
                    self._open[-1] += whole

        return timed


def wrap_when_loaded(clock: Clock) -> None:
    """Wrap each part once its module has been loaded: loading one early would move its cost."""
    waiting = list(PARTS)

    class Finder:
        """Sees each import go by."""

        @staticmethod
        def find_spec(*_: Any) -> None:
            for part in list(waiting):
                label, name, attribute = part
                module = sys.modules.get(name)
                owner, _, last = attribute.rpartition(".")
                holder = getattr(module, owner, None) if owner else module
                if holder is not None and hasattr(holder, last):
                    waiting.remove(part)
                    setattr(holder, last, clock.wrap(label, getattr(holder, last)))

    sys.meta_path.insert(0, Finder)  # type: ignore[arg-type]


def child_times(arguments: list[str]) -> None:
    """Run one command in this fresh process and print its parts as JSON."""
    clock = Clock()
    started = spent()
    wrap_when_loaded(clock)
    main = importlib.import_module("mien.cli.main")
    code = main.main(arguments)
    total = spent()
    if len(clock.frames) > 2:
        each = sorted(after - before for before, after in pairwise(clock.frames))[(len(clock.frames) - 1) // 2]
        clock.seconds["frames: posed, drawn, encoded"] = each * len(clock.frames)
        clock.seconds["file written"] -= each * len(clock.frames)
    named = sum(clock.seconds.values())
    parts = {"Python started": started, **clock.seconds, "modules and all else": total - started - named}
    peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print("\n" + json.dumps({"code": code, "total": total, "parts": parts, "peak": peak / 1024}))


def child_counts(arguments: list[str]) -> None:
    """Run one command in this fresh process and print what it imported, read and fitted as JSON."""
    opened: Counter[str] = Counter()
    assets = str(ROOT / "src/mien/assets")

    def audit(event: str, given: tuple[Any, ...]) -> None:
        if event == "open" and isinstance(given[0], str) and given[0].startswith(assets) and given[1] in ("r", "rb"):
            opened[str(Path(given[0]).relative_to(assets))] += 1

    sys.addaudithook(audit)
    made: Counter[str] = Counter()
    importlib.import_module("mien.speech.onnx_runtime").forbid_telemetry()
    count_calls(made, "onnxruntime", "InferenceSession", "__init__")
    count_calls(made, "mien.motion.em_pca", "EMPCA", "fit")
    main = importlib.import_module("mien.cli.main")
    code = main.main(arguments)
    loaded = sorted(name for name in sys.modules if "." not in name or name.count(".") == 1)
    packages = Counter(name.partition(".")[0] for name in sys.modules)
    print("\n" + json.dumps({"code": code, "opened": opened, "made": made, "modules": loaded, "counts": packages}))


def count_calls(made: Counter[str], module: str, name: str, method: str) -> None:
    """Count the calls of a method from now on, whoever makes them."""
    kind = getattr(importlib.import_module(module), name)
    first = getattr(kind, method)

    def counting(self: Any, *given: Any, **named: Any) -> Any:
        made[name] += 1
        return first(self, *given, **named)

    setattr(kind, method, counting)


def run_child(kind: str, arguments: list[str]) -> dict[str, Any]:
    """The JSON that a fresh process prints last."""
    command = [sys.executable, __file__, "--child", kind, *arguments]
    kept = Path(tempfile.gettempdir()) / "mien-startup-bytecode"  # an installation has its modules compiled
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment |= {"PYTHONPYCACHEPREFIX": str(kept)}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def yardstick() -> float:
    """Processor seconds of a loop of plain Python: what everything else here is read against."""
    start, total = time.process_time(), 0
    for number in range(3_000_000):
        total += number * number % 7
    return time.process_time() - start


def measured(runs: int, folder: str, suffix: str, more: list[str]) -> dict[str, Any]:
    """The cheapest of several runs of ``mien say``."""
    arguments = ["say", LINE, "-o", f"{folder}/line{suffix}", "--quiet", *more]
    return min((run_child("times", arguments) for _ in range(runs)), key=lambda found: found["total"])


def table(found: dict[str, dict[str, Any]], yard: float) -> str:
    """The parts of each run side by side."""
    labels = list(dict.fromkeys(label for one in found.values() for label in one["parts"]))
    lines = ["| part | " + " | ".join(found) + " |", "|---|" + "---:|" * len(found)]
    for label in labels:
        cells = [f"{one['parts'][label]:.2f}" if label in one["parts"] else "" for one in found.values()]
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    lines.append("| **all, processor seconds** | " + " | ".join(f"**{o['total']:.2f}**" for o in found.values()) + " |")
    lines.append("| peak memory, MB | " + " | ".join(f"{o['peak']:.0f}" for o in found.values()) + " |")
    load = os.getloadavg()[0]
    about = f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    return "\n".join([*lines, "", f"{about}; load {load:.1f}; yardstick {yard:.2f} s."])


def main() -> None:
    """Measure and print."""
    if sys.argv[1:2] == ["--child"]:
        {"times": child_times, "counts": child_counts}[sys.argv[2]](sys.argv[3:])
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--performer", default="default")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        more = ["--performer", options.performer]
        if options.count:
            print(
                json.dumps(run_child("counts", ["say", LINE, "-o", f"{folder}/line.csv", "--quiet", *more]), indent=1)
            )
            return
        found = {f"to {suffix}": measured(options.runs, folder, suffix, more) for suffix in (".csv", ".mp4")}
    text = table(found, yardstick())
    print(text)
    if options.write:
        path = ROOT / "docs/tables/startup.md"
        path.write_text(
            f"# What a line costs\n\n`python benchmarks/startup.py --write`: `mien say {LINE!r}`, fresh processes, the "
            f"cheapest of {options.runs}.\n\n{text}\n",
            encoding="utf-8",
        )


if __name__ == "__main__":
    main()
