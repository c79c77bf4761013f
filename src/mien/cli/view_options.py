"""``--size --camera --crop --background --light --quality --painter``: pictures of the face, for every command."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.face.render.view import View

__all__ = ["VIEW_OPTIONS", "add_view_options", "given_view_options", "view_of"]

VIEW_OPTIONS = ("size", "camera", "crop", "background", "light", "quality", "painter")


def add_view_options(parser: Any) -> None:
    """Add them to a command that can write pictures."""
    group = parser.add_argument_group("pictures", "for .mp4 .webm .mov .gif .png and NAME%05d.png (docs/pictures.md)")
    group.add_argument("--size", metavar="WxH", help="pixels, such as 1080x1920 (default 1280x720)")
    group.add_argument(
        "--camera",
        metavar="NAME|X.toml",
        help="portrait, head, mouth, eyes, three-quarter, side, below, or a file (default portrait)",
    )
    group.add_argument("--crop", metavar="oval|X,Y,WxH", help="the face in an oval, or these pixels of the picture")
    group.add_argument("--background", metavar="COLOUR|FILE|transparent", help="#808080, black, a picture, transparent")
    group.add_argument(
        "--light", metavar="NAME|X.toml", help="portrait, soft, even, dramatic, or a file (default portrait)"
    )
    group.add_argument("--quality", metavar="draft|full|best", help="trade speed for quality and size (default full)")
    group.add_argument(
        "--painter",
        metavar="processor|gpu",
        help="what draws; gpu: a graphics card, pip install 'mien[gpu]' (default processor)",
    )


def given_view_options(options: argparse.Namespace) -> dict[str, str]:
    """Those that were given."""
    return {name: value for name in VIEW_OPTIONS if (value := getattr(options, name, None)) is not None}


def view_of(options: argparse.Namespace) -> View | None:
    """The view that was asked for, checked; None where nothing was."""
    given = given_view_options(options)
    if not given:
        return None
    from mien.face.render.view import View, with_options

    return with_options(View(), given)
