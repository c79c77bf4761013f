"""How long each speech model takes to move the mouth, and how much memory, for utterances of 3, 62 and 600 s.

    python benchmarks/speech_models.py            writes docs/tables/speech_models.md
    python benchmarks/speech_models.py --print-only

The default performer says phones that follow one another as in its recordings (pieces of two, in random order, so that
recordings are joined all the time), with noise as sound; 30 frames a second. Read ratios, not absolutes. Each cell is a
process of its own: its memory is by how much it exceeded the most that it held in loading and warming up (0: never).
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.motion.mouth.speech_model import synthesise
from mien.motion.performer_file import SPEECH_MODELS
from mien.motion.performers import load_learned_performer

TARGET = Path(__file__).parent.parent / "docs" / "tables" / "speech_models.md"
SECONDS = (3, 62, 600)
RATE = FrameRate.of(30)


def utterance(seconds: float) -> tuple[Tier, Audio]:
    """Phones and sound."""
    recorded = load_learned_performer("default").recorded
    assert recorded is not None
    graph, random = recorded.motion.graph_, np.random.default_rng(0)
    phones: list[Interval] = []
    now = 0.0
    while now < seconds:
        first = int(random.integers(0, len(graph) - 1))
        for node in (first, first + 1):
            length = min(max(float(graph.durations[node]), 0.03), 0.4)
            phones.append(Interval(now, now + length, graph.symbols[graph.phones[node]]))
            now += length
    return Tier("phones", tuple(phones)), Audio(0.1 * random.standard_normal(round(now * 16000)), 16000)


def measured(name: str, seconds: float) -> tuple[float, float]:
    """Seconds of work and megabytes."""
    model = load_learned_performer("default").model(name)
    phones, audio = utterance(2.0)
    synthesise(model, phones, RATE.times(60), audio)  # compiled, mapped
    phones, audio = utterance(seconds)
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.perf_counter()
    synthesise(model, phones, RATE.times(RATE.frames_covering(seconds)), audio)
    spent = time.perf_counter() - start
    return spent, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024


def main() -> None:
    """Measure in processes of their own and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--print-only", action="store_true")
    parser.add_argument("--one", nargs=2, metavar=("MODEL", "SECONDS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(*measured(options.one[0], float(options.one[1])))
        return
    origin = "Written by `python benchmarks/speech_models.py`; what was measured stands there."
    lines = ["# Speech models: time and memory", "", origin, ""]
    lines += ["| model | utterance | time | real-time factor | memory |", "| --- | ---: | ---: | ---: | ---: |"]
    for name in SPEECH_MODELS:
        for seconds in SECONDS:
            command = [sys.executable, __file__, "--one", name, str(seconds)]
            said = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
            spent, held = float(said[0]), float(said[1])
            lines.append(f"| `{name}` | {seconds} s | {spent:.2f} s | {spent / seconds:.4f} | {held:.0f} MB |")
    text = "\n".join(lines) + "\n"
    print(text)
    if not options.print_only:
        TARGET.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
