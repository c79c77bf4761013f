"""Plots without a plotting library: panels with axes, curves, legends and cells, as PNG.

Places are pixels of the finished picture, x to the right and y down; it is drawn twice as large and then reduced, so
that lines are smooth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mien.core.files import replace_when_complete

__all__ = ["COLOURS", "GRID", "INK", "PAPER", "Colour", "Figure", "Panel", "tick_step", "write_png"]

Colour = tuple[int, int, int]
Box = tuple[float, float, float, float]
Place = tuple[float, float]
Floats = NDArray[np.float64]

PAPER: Colour = (255, 255, 255)
INK: Colour = (30, 30, 34)
GRID: Colour = (222, 222, 226)
# Okabe and Ito's colours: told apart by colour-blind readers too.
COLOURS: tuple[Colour, ...] = (
    (213, 94, 0),
    (0, 114, 178),
    (0, 158, 115),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
)
_SCALE = 2


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size * _SCALE)


class Figure:
    """A sheet of paper to draw on.

    Parameters
    ----------
    width, height : int
        Pixels.

    Examples
    --------
    >>> figure = Figure(200, 100)
    >>> figure.text((10, 10), "a title")
    >>> figure.finished().size
    (200, 100)
    """

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        self._image = Image.new("RGB", (width * _SCALE, height * _SCALE), PAPER)
        self._draw = ImageDraw.Draw(self._image)

    def text(self, place: Place, text: str, size: int = 10, colour: Colour = INK, anchor: str = "la") -> None:
        """Write a line; ``anchor`` as in Pillow: l m r across, a m b down."""
        self._draw.text((place[0] * _SCALE, place[1] * _SCALE), text, fill=colour, font=_font(size), anchor=anchor)

    def length_of(self, text: str, size: int = 10) -> float:
        """Pixels that a line takes across."""
        return self._draw.textlength(text, font=_font(size)) / _SCALE

    def line(self, points: Sequence[Place], colour: Colour, width: int = 1) -> None:
        """A line through points."""
        enlarged = [(x * _SCALE, y * _SCALE) for x, y in points]
        self._draw.line(enlarged, fill=colour, width=width * _SCALE, joint="curve")

    def rectangle(self, box: Box, fill: Colour | None = None, outline: Colour | None = None) -> None:
        """A rectangle from (left, top) to (right, bottom)."""
        left, top, right, bottom = (side * _SCALE for side in box)
        self._draw.rectangle((left, top, right, bottom), fill=fill, outline=outline, width=_SCALE)

    def legend(self, place: Place, colours: Mapping[str, Colour], size: int = 13, gap: float = 22) -> None:
        """Names beside short lines in their colours, in a row; ``place`` is the left end, half-way up."""
        x, y = place
        for name, colour in colours.items():
            self.line([(x, y), (x + 24, y)], colour, width=3)
            self.text((x + 30, y), name, size, anchor="lm")
            x += 30 + self.length_of(name, size) + gap

    def finished(self) -> Image.Image:
        """The picture in its own size."""
        return self._image.resize((self.width, self.height), Image.Resampling.LANCZOS)


@dataclass(frozen=True)
class Panel:
    """A rectangle of a figure in which curves are drawn.

    Attributes
    ----------
    figure : Figure
    box : tuple of float
        Left, top, right, bottom.
    across, up : tuple of float
        Ranges of the two axes; what lies above or below is drawn on the edge.
    """

    figure: Figure
    box: Box
    across: tuple[float, float]
    up: tuple[float, float]

    def points(self, x: Floats, y: Floats) -> list[Place]:
        """Where points of the plot are on the figure.

        Examples
        --------
        >>> Panel(Figure(20, 20), (0, 0, 10, 10), (0, 1), (0, 5)).points(np.array([0.5]), np.array([5.0]))
        [(5.0, 0.0)]
        """
        left, top, right, bottom = self.box
        places = left + (x - self.across[0]) / (self.across[1] - self.across[0]) * (right - left)
        share = (np.clip(y, *self.up) - self.up[0]) / (self.up[1] - self.up[0])
        return list(zip(places.tolist(), (bottom - share * (bottom - top)).tolist(), strict=True))

    def frame(self, title: str = "") -> None:
        """The edge, and a title inside it, top right."""
        _, top, right, _ = self.box
        self.figure.rectangle(self.box, outline=GRID)
        self.figure.text((right - 6, top + 4), title, 11, anchor="ra")

    def ticks_up(self, values: Sequence[float], labels: Sequence[str] | None = None) -> None:
        """Lines across at values, with labels to the left."""
        for number, value in enumerate(values):
            y = self.points(np.array([self.across[0]]), np.array([float(value)]))[0][1]
            self.figure.line([(self.box[0], y), (self.box[2], y)], GRID)
            label = labels[number] if labels is not None else f"{value:g}"
            self.figure.text((self.box[0] - 6, y), label, anchor="rm")

    def ticks_across(self, values: Sequence[float], labels: Sequence[str] | None = None) -> None:
        """Labels below, at values."""
        for number, value in enumerate(values):
            x = self.points(np.array([float(value)]), np.array([self.up[0]]))[0][0]
            self.figure.line([(x, self.box[3]), (x, self.box[3] + 4)], GRID)
            label = labels[number] if labels is not None else f"{value:g}"
            self.figure.text((x, self.box[3] + 6), label, anchor="ma")

    def curve(self, x: Floats, y: Floats, colour: Colour, width: int = 2) -> None:
        """One curve."""
        self.figure.line(self.points(x, y), colour, width)


def tick_step(span: float, most: int = 6) -> float:
    """A round step of which at most ``most`` fit into a span.

    Examples
    --------
    >>> tick_step(1.0), tick_step(23.0)
    (0.2, 5.0)
    """
    rough = span / most
    size = float(10 ** np.floor(np.log10(rough)))
    return next((size * step for step in (1.0, 2.0, 5.0) if size * step >= rough), size * 10)


def write_png(image: Image.Image, path: str | Path) -> None:
    """Write a picture as PNG; an older file of that name stays until it is complete.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    with replace_when_complete(path) as unfinished:
        image.save(unfinished, format="PNG")
