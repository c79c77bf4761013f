"""``mien express``: an expression laid over motion that exists already."""

from __future__ import annotations

import argparse
from typing import Any

from mien.cli.foreign_face import add_face_option, add_glb_options
from mien.cli.outputs import checked_face, finish
from mien.cli.view_options import add_view_options

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien express`` to the commands."""
    express = commands.add_parser(
        "express", help="add an expression to an animation or a Live Link recording, or convert it to another format"
    )
    express.add_argument("motion", metavar="MOTION", help="a native animation (.json) or a Live Link Face .csv")
    express.add_argument(
        "--emotion",
        metavar="NAME[:0..1]",
        action="append",
        default=[],
        help="as for 'mien say' (repeatable), or a .csv of MPEG-4 expression parameters; without it, the motion "
        "is only converted to another format or face",
    )
    express.add_argument("-o", "--output", metavar="OUT", required=True, help="file to write; its suffix says what")
    express.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more output (repeatable)")
    express.add_argument("--fps", help="frames per second (default: unchanged; for a .csv, read from its timecode)")
    express.add_argument("--seed", type=int, default=0, help="seed of the expression (default 0)")
    add_face_option(express)
    add_glb_options(express)
    add_view_options(express)
    express.add_argument("--performer", default="default", metavar="NAME|X.mien", help="whose expressions")
    express.add_argument("--quiet", action="store_true", help="print nothing but errors")
    express.set_defaults(run=_express, deformer="blendshapes")


def _express(options: argparse.Namespace) -> int:
    from mien.api import calls as api

    face = checked_face(options, [options.motion])
    given = {name: getattr(options, name) for name in ("emotion", "fps", "seed", "performer")}
    return finish(api.express(options.motion, **given), face, options)
