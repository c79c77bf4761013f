"""``mien recolor``: an animation in another emotion."""

from __future__ import annotations

import argparse
import sys
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien recolor`` to the commands."""
    recolor = commands.add_parser("recolor", help="an animation as it would be in another emotion")
    recolor.add_argument("animation", metavar="LINE.json", help="a native animation: mien animate ... -o LINE.json")
    recolor.add_argument("--to", required=True, metavar="NAME[:0..1]", help="the emotion, as for --emotion of mien say")
    recolor.add_argument(
        "-o", "--output", metavar="OUT", required=True, help="file to write; its suffix picks the format"
    )
    recolor.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more output (repeatable)")
    recolor.add_argument(
        "--performer", metavar="NAME|X.mien", help="whose expressions (default: who made the animation)"
    )
    recolor.add_argument("--face", default="default", help="the face to show (default: default)")
    recolor.add_argument("--quiet", action="store_true", help="say nothing but errors")
    recolor.set_defaults(run=_recolor)


def _recolor(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    from mien import api
    from mien.face.library import load_face
    from mien.output.native import read_native
    from mien.output.registry import check_output
    from mien.recolor import recolor

    outputs = [check_output(path) for path in (options.output, *options.also)]
    face = load_face(options.face)
    made = recolor(read_native(options.animation), options.to, options.performer)
    hidden = options.quiet or not sys.stderr.isatty()
    with tqdm(unit=" frames", desc="drawing", leave=False, disable=hidden) as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        notes = api.save(made, *outputs, face=face, progress=progress)
    if not options.quiet:
        for note in (*made.notes, *notes):
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
        print(f"{', '.join(str(path) for path in outputs)}: now {options.to}")
    return 0
