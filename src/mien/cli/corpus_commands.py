"""``mien corpus import|upgrade|check|show`` and ``mien tracker install``."""

from __future__ import annotations

import argparse
import sys
from typing import Any

__all__ = ["add_corpus_commands"]


def add_corpus_commands(commands: Any) -> None:
    """Add the commands to the parser of ``mien``."""
    corpus = commands.add_parser("corpus", help="recordings to learn from: import, check and view them")
    parts = corpus.add_subparsers(title="commands", required=True, metavar="COMMAND", parser_class=type(corpus))
    _add_import(parts)

    check = parts.add_parser("check", help="show what a corpus contains and what is wrong with it")
    check.add_argument("corpus", metavar="CORPUS")
    check.add_argument("--quiet", action="store_true", help="no progress bar")
    check.set_defaults(run=_check)

    upgrade = parts.add_parser(
        "upgrade",
        help="update a corpus to this version",
        description="Capture every take as motion of the speaker's own face, if that was not done or is done "
        "better now. Markers, sound and phones do not change. If you stop it, the same command continues.",
    )
    upgrade.add_argument("corpus", metavar="CORPUS")
    upgrade.add_argument("--workers", type=int, metavar="N", help="number of processes (default: one per core)")
    upgrade.add_argument("--cluster", metavar="ADDRESS", help="Dask scheduler to use instead, tcp://HOST:PORT")
    upgrade.add_argument("--quiet", action="store_true", help="print nothing but errors")
    upgrade.set_defaults(run=_upgrade)

    show = parts.add_parser("show", help="draw one take: waveform, phones and some trajectories")
    show.add_argument("corpus", metavar="CORPUS")
    show.add_argument("name", metavar="NAME", help="name of the take")
    show.add_argument("-o", "--output", metavar="PICTURE.png", required=True)
    show.set_defaults(run=_show)

    tracker = commands.add_parser("tracker", help="the face tracker that turns video into landmarks")
    actions = tracker.add_subparsers(title="commands", required=True, metavar="COMMAND", parser_class=type(tracker))
    install = actions.add_parser("install", help="create its environment with pip (about 430 MB, once)")
    install.set_defaults(run=_install_tracker)


def _add_import(parts: Any) -> None:
    command = parts.add_parser(
        "import",
        help="turn recordings into takes",
        description="Turn recordings into takes: C3D, CSV or NPZ markers, Live Link Face CSV, BEAT, meshes, "
        "video, GRID. "
        "If you stop it, the same command continues.",
    )
    command.add_argument("source", metavar="SOURCE", help="a folder of recordings, or one recording")
    command.add_argument("-o", "--output", metavar="CORPUS", required=True, help="folder of the corpus")
    command.add_argument("--recipe", metavar="NAME|FILE", help="how to read them (default: recognised from SOURCE)")
    command.add_argument(
        "--table", metavar="FILE", help="CSV or TSV with the column name and any of text, emotion, sentence, speaker"
    )
    command.add_argument(
        "--name-pattern",
        metavar="REGEX",
        help="regular expression with named groups (emotion, sentence, speaker, text) for the file names",
    )
    command.add_argument("--emotion", help="for takes where nothing else says it")
    command.add_argument("--speaker", help="for takes where nothing else says it")
    command.add_argument(
        "--language",
        metavar="TAG|X.toml",
        help="what language is spoken: a tag from 'mien languages', or a table of your own (default: en)",
    )
    command.add_argument("--workers", type=int, metavar="N", help="number of processes (default: one per core)")
    command.add_argument("--cluster", metavar="ADDRESS", help="Dask scheduler to use instead, tcp://HOST:PORT")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(run=_import)


def _import(options: argparse.Namespace) -> int:
    from mien.api.corpus_calls import import_corpus

    with _Bar("takes", options.quiet) as bar:
        report = import_corpus(
            options.source,
            options.output,
            recipe=options.recipe,
            table=options.table,
            name_pattern=options.name_pattern,
            emotion=options.emotion,
            speaker=options.speaker,
            language=options.language,
            workers=options.workers,
            cluster=options.cluster,
            progress=bar,
        )
    if not options.quiet:
        for note in report.notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    for failure in report.failed:
        print(f"mien: not imported: {failure.name}: {failure.reason}", file=sys.stderr)
    if not options.quiet:
        kept = f", {len(report.kept)} were there" if report.kept else ""
        broken = f", {len(report.failed)} could not be used" if report.failed else ""
        print(f"{options.output}: {len(report.corpus)} takes ({len(report.imported)} new{kept}{broken})")
        for what in ("licence", "citation"):
            if report.corpus.about.get(what):
                print(f"{what}: {report.corpus.about[what]}")
    return 0 if len(report.corpus) else 2


def _check(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError, Note
    from mien.corpus.checking import check_corpus
    from mien.corpus.recordings import Corpus
    from mien.motion.learning_judgement import judge_corpus

    corpus = Corpus(options.corpus)
    with _Bar("takes", options.quiet) as bar:
        result = check_corpus(corpus, bar)
    print(result)
    with _Bar("takes", options.quiet) as bar:
        try:
            notes = judge_corpus(corpus, progress=bar).notes
        except InputError as problem:
            notes = (Note("warning", f"'mien learn' would refuse it: {problem}"),)
    for note in notes:
        print(f"{'doubt' if note.kind == 'warning' else 'to learn'}: {note.message}")
    return 1 if any(fault.sure for fault in result.faults) else 0


def _upgrade(options: argparse.Namespace) -> int:
    from mien.corpus.capturing import capture_corpus
    from mien.corpus.recordings import Corpus

    corpus = Corpus(options.corpus)
    with _Bar("takes", options.quiet) as bar:
        report = capture_corpus(corpus, options.workers, options.cluster, bar)
    for note in report.notes:
        print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    for name, reason in report.failed:
        print(f"mien: not captured: {name}: {reason}", file=sys.stderr)
    if not options.quiet:
        recorded = f", {len(report.recorded)} recorded as channels" if report.recorded else ""
        print(
            f"{options.corpus}: {len(corpus)} takes, {len(report.captured)} captured, {len(report.kept)} were there"
            f"{recorded}, {len(report.failed)} without channels"
        )
    return 2 if report.failed and not (report.captured or report.kept or report.recorded) else 0


def _show(options: argparse.Namespace) -> int:
    from mien.corpus.recordings import Corpus
    from mien.corpus.take_picture import draw_take

    draw_take(Corpus(options.corpus).take(options.name), options.output)
    print(options.output)
    return 0


def _install_tracker(options: argparse.Namespace) -> int:
    from mien.capture.tracker import install_tracker

    print(f"the face tracker is installed in {install_tracker()}")
    return 0


class _Bar:
    """A progress bar on a terminal; takes how many are done and how many there are."""

    def __init__(self, unit: str, quiet: bool) -> None:
        from tqdm import tqdm

        self._bar = tqdm(unit=f" {unit}", leave=False, disable=quiet or not sys.stderr.isatty())

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def __call__(self, done: int, total: int) -> None:
        self._bar.total = total
        self._bar.update(done - self._bar.n)
