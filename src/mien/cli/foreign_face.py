"""``--face MY.glb``: a face in somebody else's file, checked before the work is done."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from mien.core.errors import InputError

if TYPE_CHECKING:
    from mien.face.foreign.recognition import ForeignFace
    from mien.face.model import Face
    from mien.formats.registry import GlbStyle

__all__ = ["ShownFace", "add_face_option", "add_glb_options", "checked_foreign_face", "glb_style"]

ShownFace: TypeAlias = "str | Face | ForeignFace"
"""A face to show; by its name where it comes with mien and nothing has to be known of it yet."""


def add_face_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--face`` and ``--names``."""
    parser.add_argument(
        "--face",
        default="default",
        metavar="NAME|FILE",
        help="the face to show: a name from 'mien faces', a blend (amara+mei:0.3), an .npz or .obj, or your own "
        ".glb, .vrm or .gltf",
    )
    parser.add_argument(
        "--arms", choices=("lower", "keep"), default="lower", help="for an avatar in T-pose (default: lower)"
    )
    parser.add_argument("--names", metavar="X.toml", help="what the targets of your own face do, if mien does not know")


def add_glb_options(parser: argparse.ArgumentParser) -> None:
    """Add how a ``.glb`` is written."""
    style = parser.add_argument_group("of a .glb")
    style.add_argument(
        "--compact", action="store_true", help="only ARKit's 52 targets, integers, fewer triangles: a fifth of the size"
    )
    style.add_argument(
        "--meshopt", action="store_true", help="compact and compressed (EXT_meshopt_compression; not for Blender)"
    )
    style.add_argument("--clip", metavar="NAME", default="", help="name of the animation")


def glb_style(options: argparse.Namespace) -> GlbStyle | None:
    """What `add_glb_options` was given; None if nothing."""
    from mien.formats.registry import GlbStyle

    given = vars(options)
    style = GlbStyle(given.get("compact", False), given.get("meshopt", False), given.get("clip", ""))
    if style == GlbStyle():
        return None
    if not any(path.lower().endswith(".glb") for path in (options.output, *options.also)):
        raise InputError("--compact, --meshopt and --clip are for a .glb, and none is written")
    if style.meshopt:
        from mien.formats.compact_glb import check_meshopt

        check_meshopt()
    return style


def checked_foreign_face(
    face: str, outputs: Sequence[Path], deformer: str, names: str | None, arms: str = "lower"
) -> ForeignFace | Face:
    """A foreign face to show; what cannot be done with it is refused before any work is done.

    With a deformer it becomes a face of mien's own, which that moves; a ``.glb`` then holds this one, not its file.
    """
    from mien.face.foreign.drawn import not_drawn
    from mien.face.foreign.known_face import known_face
    from mien.formats.registry import draws_pictures

    if deformer != "blendshapes":
        from mien.face.deformers import deformed_by
        from mien.face.foreign.known_face import face_by_channels

        if any(path.suffix.lower() in (".glb", ".gltf", ".vrm") for path in outputs):
            print(f"mien: note: with --deformer the .glb holds the head of {face}, not its whole file", file=sys.stderr)
        return deformed_by(face_by_channels(face, names), deformer)
    recognised = replace(known_face(face, names), arms=arms == "lower")
    recognised.require_motion()
    for path in outputs:
        reason = not_drawn(recognised) if draws_pictures(path) else ""
        if reason and all(draws_pictures(other) for other in outputs):
            raise InputError(f"{face} cannot be drawn to {path}: {reason}")
        if reason:
            print(f"mien: warning: {path} is not written, {face} cannot be drawn: {reason}", file=sys.stderr)
    return recognised
