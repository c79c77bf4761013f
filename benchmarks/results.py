"""All tables of docs/results.md, one after the other.

::

    python benchmarks/results.py CORPUS [--workers N | --cluster tcp://HOST:PORT] [-o docs/results.md]

CORPUS is grid-s1, imported (its channels captured: ``mien corpus upgrade``). What is learned for the tables: every row
on the random split, on eight parts of the words and on the hardest words; and a performer as the default one is made
(`tools/learn_default.py`) of the takes of the random split, scored on every other take that it never met. Each section
is written when it is done; ``--only`` makes some of them.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mien.api.evaluation_calls import HARDEST, evaluate
from mien.corpus.recordings import Corpus
from mien.metrics.evaluation import YARDSTICKS, Evaluation
from mien.metrics.plot import MOST_MODELS, write_trajectories
from mien.metrics.results_report import markdown, put_section
from mien.metrics.splits import random_folds
from mien.motion.learning import learn_corpus
from mien.motion.mouth.rounding import rounded
from mien.motion.performer_file import save_learned
from mien.motion.performers import load_learned_performer

DOCS = Path(__file__).parent.parent / "docs"
SECTIONS = {
    "performer-held-out": "What the face shows on unseen takes",
    "random": "Unseen takes",
    "hardest-words": "Unseen words, the hardest",
    "leave-words-out": "Unseen words",
}


@dataclass(frozen=True)
class Where:
    """On what is learned."""

    workers: int | None
    cluster: str | None


def evaluated(section: str, corpus: Corpus, where: Where) -> Evaluation:
    """What a section tells."""
    with tqdm(desc=section, leave=False) as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.total = total
            bar.set_description(f"{section}, {what}")
            bar.update(done - bar.n)

        if section == "performer-held-out":
            return _of_a_performer(corpus, where)
        protocol = "random" if section == "random" else "leave-words-out"
        hardest = HARDEST if section == "hardest-words" else None
        folds = 8 if section == "leave-words-out" else None
        return evaluate(
            corpus, protocol=protocol, words=hardest, folds=folds, progress=progress,
            workers=where.workers, cluster=where.cluster,
        )  # fmt: skip


def _of_a_performer(corpus: Corpus, where: Where) -> Evaluation:
    fold = random_folds([corpus.take(name) for name in corpus.names], 1, np.random.default_rng(0))[0]
    learned = learn_corpus(corpus, exclude_names=fold.test, workers=where.workers, cluster=where.cluster)
    learned = replace(learned, motion=rounded(learned.motion, load_learned_performer("mandarin").motion))
    with tempfile.TemporaryDirectory() as folder:
        save_learned(learned, Path(folder) / "held-out.mien")
        return evaluate(Path(folder) / "held-out.mien", corpus, test_names=fold.test[::2])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--workers", type=int, help="processes (default: one per core)")
    parser.add_argument("--cluster", help="address of a Dask scheduler")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=list(SECTIONS))
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "results.md")
    options = parser.parse_args()
    corpus, where = Corpus(options.corpus), Where(options.workers, options.cluster)
    for section in options.only:
        evaluation = evaluated(section, corpus, where)
        picture = options.output.with_name(f"{options.output.stem}-{section}.png")
        rows = [row for row in evaluation.scores if row not in (*YARDSTICKS, "mean pose")]
        write_trajectories(picture, evaluation.traces, rows[-MOST_MODELS:])
        text = markdown(evaluation, f"### {SECTIONS[section]}")
        caption = f"Lip opening and its velocity in {len(evaluation.traces)} held-out takes, recorded and synthesised"
        put_section(options.output, f"evaluate {section}", f"{text}\n![{caption}]({picture.name})")
        print(f"{options.output}: {section} written", flush=True)


if __name__ == "__main__":
    main()
