"""``mien recolor``: an animation in another emotion."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

from mien.cli.foreign_face import add_face_option

__all__ = ["add_command"]

CheckFace = Callable[[argparse.Namespace, Sequence[str | None]], Any]
Finish = Callable[[Any, Any, argparse.Namespace], int]


def add_command(commands: Any, checked_face: CheckFace, finish: Finish) -> None:
    """Add ``mien recolor`` to the commands; ``checked_face`` checks the outputs first, ``finish`` writes them."""
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
    add_face_option(recolor)
    recolor.add_argument("--quiet", action="store_true", help="say nothing but errors")
    recolor.set_defaults(run=lambda options: _recolor(options, checked_face, finish), deformer="blendshapes")


def _recolor(options: argparse.Namespace, checked_face: CheckFace, finish: Finish) -> int:
    from mien.output.native import read_native
    from mien.recolor import recolor

    face = checked_face(options, [options.animation])
    return finish(recolor(read_native(options.animation), options.to, options.performer), face, options)
