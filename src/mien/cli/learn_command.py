"""``mien learn``: a performer from a corpus."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien learn`` to the commands."""
    learn = commands.add_parser("learn", help="learn a performer from a corpus")
    learn.add_argument("corpus", metavar="CORPUS", help="a folder made by 'mien corpus import'")
    learn.add_argument("-o", "--output", metavar="X.mien", required=True, help="the performer to write")
    learn.add_argument("--name", help="its name (default: that of the file)")
    learn.add_argument(
        "--speech-model",
        choices=("coarticulation", "graph", "both"),
        default="both",
        help="learned curves, recorded motion, or both: curves corrected by recorded motion (default both)",
    )
    learn.add_argument(
        "--learn-in",
        choices=("channels", "markers"),
        help="learn the mouth in captured channels, or in markers as in the papers (default: channels if there "
        "are any)",
    )
    learn.add_argument(
        "--from",
        dest="start",
        metavar="PERFORMER|nothing",
        default="default",
        help="the performer to start from, so that a few takes are enough (default: default)",
    )
    learn.add_argument("--exclude-words", metavar="FILE", help="leave out takes that contain one of these words")
    learn.add_argument("--exclude-names", metavar="FILE", help="leave out takes with these names")
    learn.add_argument(
        "--speakers",
        metavar="mixed|NAME",
        default="one",
        help="learn one mouth from several people (mixed), or from the speaker with this name (default: there "
        "has to be only one)",
    )
    learn.add_argument("--workers", type=int, default=0, help="number of processes (default 0: only this one)")
    learn.add_argument("--cluster", metavar="tcp://HOST:PORT", help="learn on a Dask cluster; the result is the same")
    learn.add_argument("--quiet", action="store_true", help="print nothing but errors")
    learn.set_defaults(run=_learn)


def _learn(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    from mien.core.errors import InputError
    from mien.core.files import check_writable
    from mien.corpus.recordings import Corpus
    from mien.motion.learning import LearningSettings, learn_corpus
    from mien.motion.performer_file import save_learned
    from mien.motion.performers import start_named

    path = check_writable(options.output)
    if path.suffix.lower() != ".mien":
        raise InputError(f"mien learn writes a .mien file, not {options.output!r}; give -o NAME.mien")
    corpus, start = Corpus(options.corpus), start_named(options.start)
    hidden = options.quiet or not sys.stderr.isatty()
    with tqdm(desc="learning", leave=False, disable=hidden) as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.total = total
            bar.set_postfix_str(what)
            bar.update(done - bar.n)

        learned = learn_corpus(
            corpus,
            LearningSettings(speech_model=options.speech_model, learn_in=options.learn_in),
            progress=progress,
            name=options.name or path.stem,
            exclude_words=_listed(options.exclude_words),
            exclude_names=_listed(options.exclude_names),
            speakers=options.speakers,
            workers=options.workers,
            cluster=options.cluster,
            prior=start,
            tell=lambda note: None if options.quiet else print(f"mien: {note.kind}: {note.message}", file=sys.stderr),
        )
    save_learned(learned, path)
    if not options.quiet:
        begun = start is not None and "started from" in learned.about
        known = set(start.trained_on) if start is not None and begun else set()
        takes, size = len(set(learned.trained_on) - known), path.stat().st_size / 1e6
        mouth = learned.motion.mouth_
        what = f"{len(mouth.names)} {mouth.kind} of the mouth"
        print(f"{options.output}: learned from {takes} of {len(corpus)} takes, {what}, {size:.1f} MB")
        if begun:
            print(f"started from {learned.about['started from']}")
        if learned.expressions is not None:
            told = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in learned.expressions.seconds.items())
            print(f"expressions: {told}")
            for note in learned.expressions.notes:
                print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    return 0


def _listed(path: str | None) -> tuple[str, ...]:
    """Words or names of a text file, separated by white space."""
    if path is None:
        return ()
    from mien.api.calls import read_text

    return tuple(read_text(Path(path)).split())
