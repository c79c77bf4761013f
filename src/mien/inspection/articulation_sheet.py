"""What each articulatory parameter does: the mouth with it at -2, 0 and +2 standard deviations."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.core.files import replace_when_complete
from mien.face.deformers import with_tree
from mien.face.model import Face
from mien.face.parameter_tree import ParameterTree
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.face.tree_posing import TreePoser

__all__ = ["draw_articulation"]

_CELL = (240, 200)
_VALUES = (-2.0, 0.0, 2.0)
_PREFIX = "articulation_"


def draw_articulation(tree: ParameterTree, face: Face, path: str | Path) -> None:
    """Draw a sheet: one row per parameter; each value from the front and from the side.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    from PIL import Image, ImageDraw

    names = sorted({drive for drive in tree.driven_by if drive.startswith(_PREFIX)}, key=_order(tree))
    moved = with_tree(face, tree)
    poser = TreePoser(moved, names)
    width, height = _CELL
    close = Camera.close_up(face, width / height)
    renderers = [Renderer(moved, width, height, close.turned(yaw)) for yaw in (0.0, 55.0)]
    sheet = Image.new("RGB", (2 * len(_VALUES) * width, len(names) * height))
    for row, name in enumerate(names):
        for column, value in enumerate(_VALUES):
            posed = poser.pose(np.where(np.arange(len(names)) == row, value, 0.0))
            for view, renderer in enumerate(renderers):
                picture = Image.fromarray(renderer.render(posed))
                if view == 0:
                    ImageDraw.Draw(picture).text((6, 4), f"{name[len(_PREFIX) :]} {value:+g}", fill=(245, 245, 245))
                sheet.paste(picture, ((2 * column + view) * width, row * height))
    with replace_when_complete(path) as unfinished:
        sheet.save(unfinished, format="JPEG" if str(path).endswith(".jpg") else "PNG", quality=86)


def _order(tree: ParameterTree):  # type: ignore[no-untyped-def]
    """Sorts names of drives by the place of the first parameter that they drive."""
    places: dict[str, int] = {}
    for number, parameter in enumerate(tree.parameters):
        for drive in parameter.drives:
            places.setdefault(drive, number)
    return places.__getitem__
