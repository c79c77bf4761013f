"""``mien recolor``: motion in another emotion."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mien.cli.foreign_face import add_face_option
from mien.cli.outputs import checked_face, finish, tell
from mien.cli.view_options import add_view_options

if TYPE_CHECKING:
    from mien.animation.animation import Animation

__all__ = ["add_command"]

MARKERS = (".npz", ".c3d", ".csv")


def add_command(commands: Any) -> None:
    """Add ``mien recolor`` to the commands."""
    recolor = commands.add_parser("recolor", help="show a motion in another emotion")
    recolor.add_argument(
        "motion",
        metavar="MOTION",
        help="a native animation (.json), a Live Link recording (.csv), a take of a corpus (CORPUS --take NAME), or "
        "markers (.csv, .npz, .c3d)",
    )
    recolor.add_argument("--to", required=True, metavar="NAME[:0..1]", help="the emotion, as for --emotion of mien say")
    recolor.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        required=True,
        help="file to write; its suffix picks the format (.npz, or .markers.csv: the markers)",
    )
    recolor.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more output (repeatable)")
    recolor.add_argument("--take", metavar="NAME", help="which take of the corpus")
    recolor.add_argument("--from", dest="source", metavar="EMOTION", help="emotion of a marker file (default: neutral)")
    recolor.add_argument(
        "--way",
        choices=("auto", "learned", "hand-made"),
        type=lambda way: "hand-made" if way == "authored" else way,  # as version 0.1 called it
        default="auto",
        help="use the performer's learned map, or hand-made expressions (default: learned if there is a map)",
    )
    recolor.add_argument(
        "--performer",
        metavar="NAME|X.mien",
        help="whose map or expressions to use (default: the performer of the animation)",
    )
    recolor.add_argument("--seed", type=int, default=0, help="for takes and markers (default 0)")
    add_face_option(recolor)
    add_view_options(recolor)
    recolor.add_argument("--quiet", action="store_true", help="print nothing but errors")
    recolor.set_defaults(run=_recolor, deformer="blendshapes")


def _recolor(options: argparse.Namespace) -> int:
    from mien.cli.recolored_markers import is_marker_output, write_markers
    from mien.core.errors import InputError

    outputs = [options.output, *options.also]
    tracks = [path for path in outputs if is_marker_output(path)]
    shown = [path for path in outputs if not is_marker_output(path)]
    for path in tracks:
        if Path(path).resolve() == Path(options.motion).resolve():
            raise InputError(f"{path} is both read and written: give the output another name")
    options.output, options.also = (shown[0], shown[1:]) if shown else (None, [])
    face = checked_face(options, [options.motion]) if shown else None
    made = _made(options)
    for path in tracks:
        if made.markers is None or Path(options.motion).suffix.lower() == ".json":
            raise InputError(f"{path}: markers come out of takes and marker files alone; give another format")
        write_markers(made.markers, path)
        if not options.quiet:
            print(f"{path}: {len(made.markers)} frames of {len(made.markers.names)} markers at {made.markers.rate}/s")
    if face is not None:
        return finish(made, face, options)
    tell(made.notes, options.quiet)
    return 0


def _made(options: argparse.Namespace) -> Animation:
    from mien.api.recoloring import recolor, recolor_take
    from mien.core.errors import InputError
    from mien.formats.native import read_native

    motion = Path(options.motion)
    if motion.is_dir() or options.take is not None:
        from mien.corpus.recordings import Corpus

        corpus = Corpus(motion)
        if options.take is None:
            raise InputError(
                f"{motion}: which take? Give --take NAME, such as --take {next(iter(corpus.names), 'NAME')}"
            )
        _refuse(options, "source", "--from is for marker files: a take knows its emotion")
        take = corpus.take(options.take)
        return recolor_take(take, options.to, options.performer or "default", options.way, options.seed)
    if motion.suffix.lower() in MARKERS:
        from mien.cli.recolored_markers import recolored_file

        return recolored_file(motion, options)
    _refuse(options, "source", "--from is for marker files: an animation knows its emotions")
    return recolor(read_native(motion), options.to, options.performer, options.way)


def _refuse(options: argparse.Namespace, name: str, message: str) -> None:
    from mien.core.errors import InputError

    if getattr(options, name) is not None:
        raise InputError(message)
