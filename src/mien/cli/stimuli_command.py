"""``mien stimuli`` and ``mien batch``: many videos from one table, with a log of every frame."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from mien.cli.progress_bar import progress_bar
from mien.cli.view_options import add_view_options, given_view_options, view_of

__all__ = ["add_commands"]

_SHOWN = 10  # warnings about single lines


def add_commands(commands: Any) -> None:
    """Add the two commands."""
    stimuli = commands.add_parser("stimuli", help="make stimuli for experiments from a table (docs/stimuli.md)")
    stimuli.add_argument("design", metavar="TABLE.csv", help="one row per stimulus; levels written a|b are crossed")
    stimuli.add_argument("--lists", type=int, default=0, help="also write this many counterbalanced lists")
    add_view_options(stimuli)
    _add_work(stimuli)
    stimuli.add_argument(
        "--also",
        metavar="SUFFIX",
        action="append",
        default=[],
        help="also write this format, such as .glb (repeatable)",
    )
    stimuli.set_defaults(run=_stimuli)
    batch = commands.add_parser("batch", help="say every line of a text file")
    batch.add_argument(
        "lines", metavar="LINES.txt", help="one text per line, with tags as in docs/script.md; # starts a remark"
    )
    for name in ("voice", "emotion", "effort", "fps", "performer", "face"):
        batch.add_argument(f"--{name}", default="", help=f"{name} of all lines, as for mien say")
    batch.add_argument("--seed", type=int, default=0, help="seed of all lines (default 0)")
    batch.add_argument(
        "--format",
        metavar="SUFFIX",
        dest="formats",
        action="append",
        default=[],
        help="format to write for each line, such as .glb or .csv (repeatable; default .mp4)",
    )
    add_view_options(batch)
    _add_work(batch)
    batch.set_defaults(run=_batch)


def _add_work(parser: Any) -> None:
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="output folder; a stopped run continues")
    parser.add_argument("--workers", type=int, help="number of processes (default: one per core; 0: only this one)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="a Dask scheduler whose workers share the folder")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def _stimuli(options: argparse.Namespace) -> int:
    from mien.api.stimuli import read_design

    design = read_design(options.design, _view_columns(options))
    return _make(design, options, options.lists, _suffixes(options.also), True)


def _view_columns(options: argparse.Namespace) -> dict[str, str]:
    """The options of pictures, as the columns of a design have them."""
    from mien.face.render.view import parse_size

    given = given_view_options(options)
    view_of(options)  # said before any line of the table is
    width, height = parse_size(given.pop("size", "640x480"))
    return given | ({"width": str(width), "height": str(height)} if options.size is not None else {})


def _suffixes(given: list[str]) -> list[str]:
    return [suffix if suffix.startswith(".") else f".{suffix}" for suffix in dict.fromkeys(given)]


def _batch(options: argparse.Namespace) -> int:
    from pathlib import Path

    from mien.api.calls import read_text
    from mien.api.stimuli import Stimulus
    from mien.core.errors import InputError
    from mien.text.effort_spans import parse_effort
    from mien.text.score import EmotionSpan

    if Path(options.lines).suffix.lower() in (".csv", ".tsv", ".xlsx"):
        raise InputError(f"{options.lines}: mien batch says the lines of a text; a table is for 'mien stimuli'")
    rows = read_text(Path(options.lines)).splitlines()
    remarks = [row.lstrip().startswith("#") for row in rows]
    lines = [
        "" if remark else _said(row, number, options.lines)
        for number, (row, remark) in enumerate(zip(rows, remarks, strict=True), start=1)
    ]
    if any(remarks) and not options.quiet:
        print(
            f"mien: note: {options.lines}: lines passed over because they start with #: {sum(remarks)}", file=sys.stderr
        )
    names = ("voice", "effort", "fps", "performer", "face")
    chosen = {name: getattr(options, name) for name in names if getattr(options, name)}
    if options.effort not in ("", "off"):
        parse_effort(options.effort)
    if options.emotion:
        span = EmotionSpan.parse(options.emotion)
        if not isinstance(span.intensity, float) or span.start is not None or span.end is not None:
            raise InputError("mien batch takes an emotion NAME or NAME:0..1; put others into the lines as tags")
        chosen |= {"emotion": span.name, "intensity": span.intensity}
    chosen |= {
        name: int(text) if name in ("width", "height") else text for name, text in _view_columns(options).items()
    }
    stimuli = [
        Stimulus(
            f"line{number:05d}", line.strip(), seed=options.seed, where=f"{options.lines}, line {number}", **chosen
        )
        for number, line in enumerate(lines, start=1)
        if line.strip()
    ]
    if not stimuli:
        raise InputError(f"{options.lines}: no line in it")
    formats = _suffixes(options.formats) or [".mp4"]
    others = [suffix for suffix in formats if suffix.lower() != ".mp4"]
    return _make(stimuli, options, 0, others, len(others) < len(formats))


def _said(line: str, number: int, source: str) -> str:
    """What a line says, or the file that it names, by the rule of all commands."""
    from mien.api.calls import read_text
    from mien.core.errors import InputError

    try:
        return read_text(line.strip())
    except InputError as problem:
        raise InputError(f"{source}, line {number}: {problem}") from problem


def _warn(warned: Sequence[tuple[str, str]]) -> None:
    for name, told in warned[:_SHOWN]:
        print(f"mien: warning: {name}: {told}", file=sys.stderr)
    if len(warned) > _SHOWN:
        print(f"mien: warning: {len(warned) - _SHOWN} more warnings are in NAME.json", file=sys.stderr)


def _make(stimuli: Any, options: argparse.Namespace, lists: int, formats: list[str], picture: bool) -> int:
    from mien.api.stimuli import make_stimuli

    logged, done = not options.quiet and not sys.stderr.isatty(), 0

    def finished(name: str, reason: str) -> None:
        nonlocal done
        done += 1
        if logged and not reason:  # what failed is told below
            print(f"mien: {name}: made ({done} of {len(stimuli)})", file=sys.stderr, flush=True)

    with progress_bar("making", " stimuli", options.quiet) as progress:
        report = make_stimuli(
            stimuli,
            options.output,
            lists=lists,
            formats=formats,
            picture=picture,
            workers=options.workers,
            cluster=options.cluster,
            progress=progress,
            finished=finished,
        )
    for name, reason in report.failed:
        print(f"mien: error: {name}: {reason}", file=sys.stderr)
    if not options.quiet:
        _warn(report.warned)
        print(f"{options.output}: made {len(report.made)}, kept {len(report.kept)}, failed {len(report.failed)}")
    return 2 if report.failed else 0
