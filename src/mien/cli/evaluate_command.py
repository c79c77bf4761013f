"""``mien evaluate``: scores models on held-out takes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.metrics.evaluation import Evaluation

__all__ = ["add_command"]

_PROTOCOLS = ("random", "leave-words-out")


def add_command(commands: Any) -> None:
    """Add ``mien evaluate`` to the commands."""
    parser = commands.add_parser(
        "evaluate",
        help="score models or a performer against recorded motion",
        description="CORPUS: train every model anew for each fold and score it on the held-out takes. PERFORMER "
        "HELDOUT: score a finished performer (default, X.mien) on takes it was not trained on. The mouth as "
        "shown by the default face is scored. See docs/metrics.md.",
    )
    parser.add_argument("subject", metavar="CORPUS|PERFORMER", help="folder of a corpus, or a finished performer")
    parser.add_argument("heldout", metavar="HELDOUT", nargs="?", help="corpus to score the performer on")
    parser.add_argument("--protocol", choices=_PROTOCOLS, help="what is held out: takes, or words")
    parser.add_argument(
        "--words",
        metavar="FILE|hardest",
        help="words to leave out and to score (leave-words-out); hardest: those that are least like the others",
    )
    parser.add_argument(
        "--test-names", metavar="FILE", help="takes to score: held out from CORPUS (random), or taken from HELDOUT"
    )
    parser.add_argument("--folds", type=int, help="how many of the 8 parts to test in turn (default 1)")
    parser.add_argument("--models", metavar="A,B", help="only these rows (default: all)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the split and the bootstrap (default 0)")
    parser.add_argument("--workers", type=int, default=0, help="number of processes (default 0: only this one)")
    parser.add_argument("--cluster", metavar="tcp://HOST:PORT", help="learn on a Dask cluster; the result is the same")
    parser.add_argument("--report", metavar="FILE.md", help="also write it into a section of this file, with a picture")
    parser.add_argument("--quiet", action="store_true", help="print only warnings and errors")
    parser.set_defaults(run=_evaluate)


def _evaluate(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    from mien.api.evaluation_calls import evaluate
    from mien.metrics.results_report import check_report

    if options.report:
        check_report(options.report)
    with tqdm(leave=False, disable=options.quiet or not sys.stderr.isatty()) as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.total = total
            bar.set_description(what)
            bar.update(done - bar.n)

        evaluation = evaluate(
            options.subject,
            options.heldout,
            protocol=options.protocol,
            words=options.words,
            test_names=options.test_names,
            folds=options.folds,
            models=options.models.split(",") if options.models else None,
            seed=options.seed,
            progress=progress,
            workers=options.workers,
            cluster=options.cluster,
        )
    _tell(evaluation, *_titled(options), options)
    return 0


def _titled(options: argparse.Namespace) -> tuple[str, str]:
    """Name of the section of a report, and its heading."""
    from mien.api.evaluation_calls import HARDEST, is_performer

    if is_performer(options.subject):
        name = Path(options.subject).stem
        return f"performer-{name}", f"Performer {name} on held-out takes"
    if options.words == HARDEST:
        return "hardest-words", "Unseen words, the hardest"
    return options.protocol, "Unseen words" if options.protocol == "leave-words-out" else "Unseen takes"


def _tell(evaluation: Evaluation, name: str, title: str, options: argparse.Namespace) -> None:
    """Print the tables; with --report write them, and the picture beside them."""
    from mien.metrics.evaluation import YARDSTICKS
    from mien.metrics.results_report import markdown, put_section

    text = markdown(evaluation, f"### {title}")
    print(text, end="")
    if not options.report:
        return
    from mien.metrics.plot import MOST_MODELS, write_trajectories

    report = Path(options.report)
    picture = report.with_name(f"{report.stem}-{name}.png")
    rows = evaluation.scores or evaluation.marker_scores
    shown = [model for model in rows if model not in (*YARDSTICKS, "mean pose")]
    write_trajectories(picture, evaluation.traces, shown[-MOST_MODELS:])
    caption = f"Lip opening and its velocity in {len(evaluation.traces)} held-out takes, recorded and synthesised"
    put_section(report, f"evaluate {name}", f"{text}\n![{caption}]({picture.name})")
    if not options.quiet:
        print(f"{report}, {picture}: written", file=sys.stderr)
