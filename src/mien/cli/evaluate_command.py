"""``mien evaluate``: scores models on held-out takes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.corpus.take import Take
    from mien.metrics.evaluation import Evaluation
    from mien.metrics.splits import Fold
    from mien.motion.mouth.speech_model import SpeechModel
    from mien.motion.performer import MouthModel

__all__ = ["add_command"]

_PROTOCOLS = ("random", "leave-words-out")


def add_command(commands: Any) -> None:
    """Add ``mien evaluate`` to the commands."""
    parser = commands.add_parser(
        "evaluate",
        help="score models against recorded motion",
        description="CORPUS: every model is learned afresh for each fold and scored on what was held out. "
        "PERFORMER HELDOUT: a finished performer (default, X.mien) is scored on takes that it was not learned from. "
        "What is scored is the mouth that the default face shows. See docs/metrics.md.",
    )
    parser.add_argument("subject", metavar="CORPUS|PERFORMER", help="folder of a corpus, or a finished performer")
    parser.add_argument("heldout", metavar="HELDOUT", nargs="?", help="corpus to score the performer on")
    parser.add_argument("--protocol", choices=_PROTOCOLS, help="what is held out: takes, or words")
    parser.add_argument(
        "--words",
        metavar="FILE|hardest",
        help="words to leave out and to score (leave-words-out); hardest: those that the other words say least about",
    )
    parser.add_argument("--test-names", metavar="FILE", help="takes to hold out and to score (random)")
    parser.add_argument("--folds", type=int, help="how many of the 8 parts are tested in turn (default 1)")
    parser.add_argument("--models", metavar="A,B", help="only these rows (default: all)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the split and the bootstrap (default 0)")
    parser.add_argument("--report", metavar="FILE.md", help="also write it into a section of this file, with a picture")
    parser.add_argument("--quiet", action="store_true", help="no progress; warnings and errors only")
    parser.set_defaults(run=_evaluate)


def _evaluate(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.metrics.results_report import check_report

    if options.seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {options.seed}")
    if options.report:
        check_report(options.report)
    of_performer = _is_performer(options.subject)
    name, title, evaluation = _of_performer(options) if of_performer else _of_corpus(options)
    _tell(evaluation, name, title, options)
    return 0


def _is_performer(subject: str) -> bool:
    """A ``.mien`` file, or a name of a performer that comes with mien and of no folder here."""
    from mien.motion.performers import known_performers

    return subject.lower().endswith(".mien") or (subject in known_performers() and not Path(subject).is_dir())


def _of_corpus(options: argparse.Namespace) -> tuple[str, str, Evaluation]:
    from tqdm import tqdm

    from mien.corpus.recordings import Corpus
    from mien.metrics.compared_models import contenders
    from mien.metrics.protocols import evaluate_folds, recordings

    _check_protocol(options)
    words = options.protocol == "leave-words-out"
    makers = contenders(options.models.split(",") if options.models else None, unseen_words=words)
    ready, notes = recordings(Corpus(options.subject))
    folds = _folds(options, [recording.take for recording in ready.values()])
    with tqdm(unit=" models", leave=False, disable=options.quiet or not sys.stderr.isatty()) as bar:

        def progress(done: int, total: int, model: str) -> None:
            bar.total = total
            bar.set_description(f"learning {model}")
            bar.update(done - bar.n)

        evaluation = evaluate_folds(ready, folds, makers, seed=options.seed, notes=notes, progress=progress)
    if options.words == "hardest":
        return "hardest-words", "Unseen words, the hardest", evaluation
    return options.protocol, "Unseen words" if words else "Unseen takes", evaluation


def _of_performer(options: argparse.Namespace) -> tuple[str, str, Evaluation]:
    from tqdm import tqdm

    from mien.core.errors import InputError
    from mien.corpus.recordings import Corpus
    from mien.metrics.protocols import evaluate_performer
    from mien.motion.mouth.learned_mouth import LearnedMouth
    from mien.motion.performers import AUTHORED, load_learned_performer, load_performer

    if options.heldout is None:
        raise InputError(f"name the corpus of held-out takes too: mien evaluate {options.subject} HELDOUT")
    learning = ("protocol", "words", "test_names", "folds", "models")
    given = [f"--{name.replace('_', '-')}" for name in learning if getattr(options, name) is not None]
    if given:
        raise InputError(f"{given[0]} is for learning afresh from a corpus; {options.subject} is learned already")
    mouths: dict[str, MouthModel] = {}
    models: dict[str, SpeechModel] = {}
    known: Collection[str] = ()
    if options.subject == AUTHORED:
        name, mouths = options.subject, {"hand-made": load_performer(AUTHORED).mouth}
    else:
        learned = load_learned_performer(options.subject)
        name, known = learned.name, learned.trained_on
        mouths = {f"performs: {kind}": LearnedMouth(learned, speech_model=kind) for kind in learned.speech_models}
        models = {"speech motion": learned.motion, "paper's curves": learned.coarticulation}
    with tqdm(unit=" takes", leave=False, disable=options.quiet or not sys.stderr.isatty()) as bar:

        def progress(done: int, total: int, take: str) -> None:
            bar.total = total
            bar.update(done - bar.n)

        evaluation = evaluate_performer(
            options.subject, mouths, models, known, Corpus(options.heldout), seed=options.seed, progress=progress
        )
    return f"performer-{name}", f"Performer {name} on held-out takes", evaluation


def _check_protocol(options: argparse.Namespace) -> None:
    """Options that do not go together are refused, none is passed over."""
    from mien.core.errors import InputError

    if options.heldout is not None:
        raise InputError(f"{options.heldout}: a second corpus is for a performer, 'mien evaluate PERFORMER HELDOUT'")
    if options.protocol is None:
        raise InputError(f"learning afresh needs --protocol {' or --protocol '.join(_PROTOCOLS)}")
    if options.words and options.protocol == "random":
        raise InputError("--words is for --protocol leave-words-out; name the takes of a random split by --test-names")
    if options.test_names and options.protocol == "leave-words-out":
        raise InputError("--test-names is for --protocol random; name the words that are left out by --words")
    if options.folds is not None and (options.words or options.test_names):
        raise InputError("--folds deals the test at random; with --words or --test-names there is one fold, the named")


def _folds(options: argparse.Namespace, takes: Sequence[Take]) -> list[Fold]:
    import numpy as np

    from mien.metrics import splits

    random, number = np.random.default_rng(options.seed), options.folds if options.folds is not None else 1
    if options.words == "hardest":
        return [splits.words_fold(takes, splits.hardest_words(takes))]
    if options.words:
        return [splits.words_fold(takes, splits.read_list(options.words, "words"))]
    if options.test_names:
        return [splits.named_fold(takes, splits.read_list(options.test_names, "takes"))]
    deal = splits.words_folds if options.protocol == "leave-words-out" else splits.random_folds
    return deal(takes, number, random)


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
    shown = [model for model in evaluation.scores if model not in (*YARDSTICKS, "mean pose")]
    write_trajectories(picture, evaluation.traces, shown[-MOST_MODELS:])
    caption = f"Lip opening and its velocity in {len(evaluation.traces)} held-out takes, recorded and synthesised"
    put_section(report, f"evaluate {name}", f"{text}\n![{caption}]({picture.name})")
    if not options.quiet:
        print(f"{report}, {picture}: written", file=sys.stderr)
