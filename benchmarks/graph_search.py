"""What searching the Anime Graph costs, from a thousand nodes to a million; and what a short look-ahead costs.

    python benchmarks/graph_search.py CORPUS [--sizes 1000,10000,100000,1000000] [-o docs/tables/graph_search.md]

CORPUS is a folder made by `mien corpus import`. Graphs are made from it (`made_graphs.py` says how); takes that are
asked for are not in them. Each size runs in a process of its own. About five minutes on two quiet cores; most of it is
the plain programme.
"""

from __future__ import annotations

import argparse
import multiprocessing
import platform
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from made_graphs import (
    SIZES,
    English,
    english_graph,
    english_questions,
    grammar_graph,
    recorded_chains,
    recorded_questions,
)

from mien.corpus.recording.scripts import read_script
from mien.motion.graph.candidates import GraphIndex
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph
from mien.motion.graph.incremental import search_ahead
from mien.motion.graph.plain_search import plain_search
from mien.motion.graph.query import SpokenPhones
from mien.motion.graph.search import search
from mien.motion.performers import load_learned_performer
from mien.text.normalisation import pronounce_text

WEIGHTS = {"paper": SearchWeights(), "learned": load_learned_performer("default").model("graph").weights_}
LENGTH = 30
HELD_OUT = 60
PLAIN_UP_TO = 100_000
PLAIN_QUESTIONS = {1_000: 5, 10_000: 3, 100_000: 1}

HEADER = """# Searching the Anime Graph

Written by `python benchmarks/graph_search.py CORPUS`, on {machine}, {cores} processor(s), load {load:.1f} at the start.

Questions of {length} phones; the audio cost is in every time on both sides. *Plain* is `plain_search`, vectorised
dynamic programming over all pairs, with the same compiled audio distance; it was run for the first questions only, and
not at all beyond {plain} nodes. *paper*: jump 100, join 1, audio .01. *learned*: those that the default performer
learned from its recordings ({learned}): jumps no longer dominate, bounds leave nearly
every state, and the gain at 10,000 nodes is a small factor (column *ratio*), not that of the paper's.
*grammar*: the recorded takes drawn again and again;
*English*: sentences drawn from a language model (`benchmarks/made_graphs.py`). Both searches find the same cost; the
largest difference is in the last column, as a share of the cost.

States: nodes that could stand at the phones; left: those that the bounds leave; weighed: those whose cost is computed.
Memory: the features (a mapped file), the rest of the graph with its index, and by how much the process grew at most in
all searches.
"""

COLUMNS = (
    "graph", "nodes", "weights", "jumps", "fast, ms (median)", "slowest, ms", "plain, ms", "ratio", "states", "left",
    "weighed", "features, MB", "index, MB", "grew, MB", "cost differs",
)  # fmt: skip


@dataclass(frozen=True)
class Task:
    chains: Sequence[RecordedChain]
    markers: int
    english: English
    kind: str
    size: int
    questions: int


def prepared(task: Task, folder: str) -> tuple[AnimeGraph, list[SpokenPhones]]:
    order = np.random.default_rng(1).permutation(len(task.chains))
    asked_of = [task.chains[place] for place in order[:HELD_OUT]]
    real = build_graph([task.chains[place] for place in order[HELD_OUT:]], task.markers)
    random = np.random.default_rng(task.size)
    features = Path(folder) / "features.npy"
    if task.kind == "grammar":
        return grammar_graph(real, task.size, random, features), recorded_questions(asked_of, LENGTH, task.questions)
    graph = english_graph(real, task.english, task.size, random, features)
    return graph, english_questions(real, script_sentences(), LENGTH, task.questions, random)


def script_sentences() -> list[tuple[str, ...]]:
    return [
        ("SIL", *(phone for _, phones in pronounce_text(line.text) for phone in phones), "SIL")
        for line in read_script("en")
    ]


def milliseconds(work: Callable[[], object], repeats: int) -> float:
    """The least of several (fewer if they are long), against other work on the machine."""
    times: list[float] = []
    while len(times) < repeats and sum(times) < 0.5:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1000 * min(times)


def memory(forget: bool = False) -> float:
    """Most memory held so far, MB, as Linux counts it; ``forget`` begins to count anew."""
    if forget:
        Path("/proc/self/clear_refs").write_text("5")
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def measure(task: Task) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        graph, asked = prepared(task, folder)
        index = GraphIndex(graph)
        arrays = [values for name, values in graph.to_arrays().items() if name not in ("features", "motion")]
        arrays += [index.entries, index.exits, index.log_durations, index.exit_order, graph.phones.astype(np.int32)]
        index_size = sum(values.nbytes for values in arrays) / 1e6
        for name, weights in WEIGHTS.items():
            search(index, asked[0], weights)  # compiled, and the pages of the file are there
            before = memory(forget=True)
            ways = [search(index, question, weights) for question in asked]
            grew = memory() - before
            fast = [milliseconds(lambda q=q, w=weights: search(index, q, w), 3) for q in asked]  # type: ignore[misc]
            plain, ratio, differs = _beside_plain(index, asked, weights, fast, task.size)
            rows.append(
                (
                    task.kind, task.size, name, f"{np.mean([way.cost.jumps for way in ways]):.1f}",
                    f"{np.median(fast):.1f}", f"{max(fast):.1f}", plain, ratio,
                    *(round(float(np.mean([getattr(way.effort, what) for way in ways])))
                      for what in ("states", "left", "weighed")),
                    f"{graph.features.nbytes / 1e6:.0f}", f"{index_size:.1f}", f"{grew:.0f}", differs,
                )
            )  # fmt: skip
    return rows


def _beside_plain(
    index: GraphIndex, asked: Sequence[SpokenPhones], weights: SearchWeights, fast: Sequence[float], size: int
) -> tuple[str, str, str]:
    if size > PLAIN_UP_TO:
        return "", "", ""
    count = PLAIN_QUESTIONS.get(size, 1)
    times, apart = [], []
    for question in asked[:count]:
        start = time.perf_counter()
        cost = plain_search(index, question, weights)[1]
        times.append(1000 * (time.perf_counter() - start))
        apart.append(abs(search(index, question, weights).cost.total - cost) / max(cost, 1e-9))
    ratio = float(np.median(np.array(times) / np.array(fast[:count])))
    return f"{np.median(times):.0f}", f"{ratio:.0f}", f"{max(apart):.0e}"


def look_ahead_rows(task: Task) -> list[tuple[object, ...]]:
    """How much more the way settled after each look-ahead costs than the cheapest, in per cent, and ms per phone."""
    rows: list[tuple[object, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        graph, asked = prepared(task, folder)
        index = GraphIndex(graph)
        for name, weights in WEIGHTS.items():
            best = np.array([search(index, question, weights).cost.total for question in asked])
            for look_ahead in range(11):
                start = time.perf_counter()
                ways = [search_ahead(index, question, weights, look_ahead) for question in asked]
                spent = 1000 * (time.perf_counter() - start) / (len(asked) * LENGTH)
                costs = np.array([way.cost.total for way in ways])
                jumps = np.mean([way.cost.jumps for way in ways])
                gap = 100 * (costs / best - 1)
                rows.append((task.kind, name, look_ahead, f"{gap.mean():.1f}", f"{gap.max():.1f}", f"{jumps:.1f}",
                             f"{(gap < 0.01).mean():.2f}", f"{spent:.1f}"))  # fmt: skip
    return rows


def growth_rows(task: Task) -> list[tuple[object, ...]]:
    """Time and memory against the length of the utterance."""
    rows: list[tuple[object, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        graph, asked = prepared(task, folder)
        index = GraphIndex(graph)
        whole = _many(asked)
        for name, weights in WEIGHTS.items():
            for length in (30, 120, 480, 1920, 7500):
                question = whole.part(0, length)
                search(index, question.part(0, 10), weights)
                before = memory(forget=True)
                spent = milliseconds(lambda q=question, w=weights: search(index, q, w), 1)  # type: ignore[misc]
                grew = memory() - before
                rows.append((task.kind, task.size, name, length, f"{sum(question.durations):.0f}", f"{spent:.0f}",
                             f"{spent / length:.2f}", f"{grew:.0f}"))  # fmt: skip
    return rows


def _many(asked: Sequence[SpokenPhones]) -> SpokenPhones:
    parts = [asked[k % len(asked)] for k in range(7500 // LENGTH)]
    return SpokenPhones(
        tuple(phone for part in parts for phone in part.phones),
        tuple(rows for part in parts for rows in part.features),
        tuple(seconds for part in parts for seconds in part.durations),
    )


def told(weights: SearchWeights) -> str:
    return ", ".join(
        f"{name} {getattr(weights, name):g}" for name in ("jump", "join", "audio", "duration", "pause_audio")
    )


def table(columns: Sequence[str], rows: Sequence[tuple[object, ...]]) -> str:
    lines = ["| " + " | ".join(columns) + " |", "| " + " | ".join(["---", *["---:"] * (len(columns) - 1)]) + " |"]
    return "\n".join([*lines, *("| " + " | ".join(str(value) for value in row) + " |" for row in rows)]) + "\n"


def alone(work: Callable[[Task], list[tuple[object, ...]]], task: Task) -> list[tuple[object, ...]]:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(work, (task,))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpus")
    parser.add_argument("--sizes", default=",".join(map(str, SIZES)), help="numbers of nodes, comma between them")
    parser.add_argument("--questions", type=int, default=6)
    parser.add_argument("-o", "--output", help="file to write the tables to (default: print them)")
    options = parser.parse_args()
    load = Path("/proc/loadavg").read_text().split()[0] if Path("/proc/loadavg").exists() else "nan"
    chains, markers = recorded_chains(options.corpus)
    english = English.load()

    def task(kind: str, size: int) -> Task:
        return Task(chains, markers, english, kind, size, options.questions)

    rows = [
        row for size in map(int, options.sizes.split(",")) for kind in ("grammar", "English")
        for row in alone(measure, task(kind, size))
    ]  # fmt: skip
    text = HEADER.format(
        machine=platform.machine(), cores=multiprocessing.cpu_count(), load=float(load), length=LENGTH,
        plain=PLAIN_UP_TO, learned=told(WEIGHTS["learned"]),
    ) + "\n" + table(COLUMNS, rows)  # fmt: skip
    text += "\n## Phones that arrive one by one\n\n"
    text += "A node is settled when so many phones after it are known. 10,000 nodes.\n\n"
    text += table(
        ("graph", "weights", "look-ahead, phones", "dearer than the cheapest, % (mean)", "most", "jumps",
         "share of cheapest ways", "ms a phone"),
        [row for kind in ("grammar", "English") for row in alone(look_ahead_rows, task(kind, 10_000))],
    )  # fmt: skip
    text += (
        "\n## Long utterances\n\nThe questions one after the other, again and again; 7,500 phones are ten minutes.\n\n"
    )
    text += table(
        ("graph", "nodes", "weights", "phones", "seconds of speech", "ms", "ms a phone", "grew, MB"),
        alone(growth_rows, task("English", 10_000)),
    )
    if options.output:
        Path(options.output).write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
