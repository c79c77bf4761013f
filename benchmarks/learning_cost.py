"""What ``mien learn`` costs, against the size of the corpus: seconds, peak memory, size of the file.

    python benchmarks/learning_cost.py CORPUS [--takes 50,100,200,400,800] [-o docs/tables/learning_cost.md]

CORPUS is a folder made by `mien corpus import`. The command runs as a person runs it, in a process of its own: start,
reading, all models and writing are in its time. *Processor*: seconds of one core, of all its processes. *Models alone*:
wall seconds of `mien.motion.learning.learn` on takes that are read already.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mien.corpus.recordings import Corpus
from mien.motion.learning import learn
from mien.motion.performer_file import load_learned

HEADER = """# What learning costs

Written by `python benchmarks/learning_cost.py CORPUS`, on {machine}, {cores} processor(s), load {load:.1f} at first;
definitions stand at its head. Takes of {seconds:.1f} s on average; synthesis is that of one minute at 25 frames/s.

| takes | `mien learn`, s | processor, s | models alone, s | peak memory, MB | file, MB | synthesis of a minute, s |
| ---: | ---: | ---: | ---: | ---: | ---: | ---: |
"""


def measure(folder: str, count: int) -> tuple[float, ...]:
    corpus = Corpus(folder)
    names = list(corpus.names)
    with tempfile.TemporaryDirectory() as place:
        others, path = Path(place) / "others.txt", Path(place) / "learned.mien"
        others.write_text("\n".join(names[count:]), encoding="utf-8")
        command = [sys.executable, "-m", "mien", "learn", folder, "-o", str(path), "--quiet"]
        start = time.perf_counter()
        child = subprocess.Popen([*command, *(["--exclude-names", str(others)] if count < len(names) else [])])
        _, status, spent = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
        if status:
            raise SystemExit(f"mien learn failed on {count} takes of {folder}")
        size = path.stat().st_size
        motion = load_learned(path).motion
    takes = [corpus.take(name) for name in names[:count]]
    start = time.perf_counter()
    learn(takes)
    models = time.perf_counter() - start
    times = np.arange(0, takes[0].duration, 0.04)
    before = time.perf_counter()
    repeats = max(1, round(1500 / len(times)))
    for _ in range(repeats):
        motion.synthesise(takes[0].phones, times)
    minute = (time.perf_counter() - before) * 1500 / (repeats * len(times))
    return wall, spent.ru_utime + spent.ru_stime, models, spent.ru_maxrss / 1024, size / 1e6, minute


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpus")
    parser.add_argument("--takes", default="50,100,200,400,800", help="sizes, comma between them")
    parser.add_argument("-o", "--output", help="file to write the table to (default: print it)")
    options = parser.parse_args()
    corpus = Corpus(options.corpus)
    seconds = float(np.mean([corpus.take(name).duration for name in corpus.names[:20]]))
    table = HEADER.format(
        machine=platform.machine(), cores=multiprocessing.cpu_count(), seconds=seconds, load=os.getloadavg()[0]
    )
    for count in (int(text) for text in options.takes.split(",")):
        if count > len(corpus):
            parser.error(f"{options.corpus} has {len(corpus)} takes, fewer than {count}")
        with multiprocessing.get_context("spawn").Pool(1) as alone:
            row = alone.apply(measure, (options.corpus, count))
        table += (
            f"| {count} | "
            + " | ".join(f"{value:.{digits}f}" for value, digits in zip(row, (1, 1, 1, 0, 2, 2), strict=True))
            + " |\n"
        )
    if options.output:
        Path(options.output).write_text(table, encoding="utf-8")
    else:
        print(table)


if __name__ == "__main__":
    main()
