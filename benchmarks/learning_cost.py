"""What learning costs, against the size of the corpus: seconds, peak memory, size of the file.

    python benchmarks/learning_cost.py CORPUS [--takes 50,100,200,400,800] [-o docs/tables/learning_cost.md]

CORPUS is a folder made by `mien corpus import`. Each size is learned in a process of its own, so that its peak memory
is its own.
"""

from __future__ import annotations

import argparse
import multiprocessing
import platform
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from mien.corpus.recordings import Corpus
from mien.motion.learning import learn
from mien.motion.mouth.coarticulation import Coarticulation
from mien.motion.performer_file import load_learned, save_learned

HEADER = """# What learning costs

Written by `python benchmarks/learning_cost.py CORPUS`, on {machine}, {cores} processor(s).
Takes of {seconds:.1f} s on average. "The paper's curves" are part of learning; synthesis is that of one minute at
25 frames per second.

| takes | read, s | learn, s | of it the paper's curves, s | peak memory, MB | file, MB | synthesis of a minute, s |
| ---: | ---: | ---: | ---: | ---: | ---: | ---: |
"""


def measure(folder: str, count: int) -> tuple[float, ...]:
    corpus = Corpus(folder)
    start = time.perf_counter()
    takes = [corpus.take(name) for name in corpus.names[:count]]
    read = time.perf_counter()
    learned = learn(takes)
    done = time.perf_counter()
    Coarticulation(learned.coarticulation.settings).fit(takes)
    paper = time.perf_counter() - done
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "learned.mien"
        save_learned(learned, path)
        size = path.stat().st_size
        motion = load_learned(path).motion
    times = np.arange(0, takes[0].duration, 0.04)
    before = time.perf_counter()
    repeats = max(1, round(1500 / len(times)))
    for _ in range(repeats):
        motion.synthesise(takes[0].phones, times)
    minute = (time.perf_counter() - before) * 1500 / (repeats * len(times))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return read - start, done - read, paper, peak, size / 1e6, minute


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpus")
    parser.add_argument("--takes", default="50,100,200,400,800", help="sizes, comma between them")
    parser.add_argument("-o", "--output", help="file to write the table to (default: print it)")
    options = parser.parse_args()
    corpus = Corpus(options.corpus)
    seconds = float(np.mean([corpus.take(name).duration for name in corpus.names[:20]]))
    table = HEADER.format(machine=platform.machine(), cores=multiprocessing.cpu_count(), seconds=seconds)
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
