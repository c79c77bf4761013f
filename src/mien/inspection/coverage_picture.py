"""A picture of what was heard in learning: a matrix of diphones, phones that look alike side by side."""

from __future__ import annotations

import numpy as np
from PIL import Image

from mien.core.plotting import GRID, INK, PAPER, Colour, Figure
from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.coverage import Coverage

__all__ = ["draw_coverage"]

_CELL, _LEFT, _TOP, _RIGHT, _BOTTOM = 22, 150, 132, 20, 70
_FAINT: Colour = (235, 235, 238)
_RARE: Colour = (246, 214, 186)
_PALE, _DEEP = np.array([205, 224, 240]), np.array([8, 48, 107])
_BORDER: Colour = (140, 140, 146)


def draw_coverage(coverage: Coverage) -> Image.Image:
    """Draw how often each pair of phones was heard: the first one in rows, the second in columns.

    Blue: at least ``coverage.least`` times, darker for more; orange: fewer times; grey: never, but pairs that look
    alike often enough; white: nothing like it.
    """
    table = articulation_table()
    groups = {**table.visemes, "pause": (PAUSE,)}
    phones = [phone for members in groups.values() for phone in members]
    side = _CELL * len(phones)
    figure = Figure(_LEFT + side + _RIGHT, _TOP + side + _BOTTOM)
    most = max([*coverage.diphones_.values(), coverage.least + 1])
    for row, first in enumerate(phones):
        for column, second in enumerate(phones):
            x, y = _LEFT + column * _CELL, _TOP + row * _CELL
            count = coverage.diphones_.get((first, second), 0)
            figure.rectangle((x, y, x + _CELL, y + _CELL), _fill(coverage, first, second, most), GRID)
            if count:
                dark = count >= coverage.least and np.log(count) > 0.5 * np.log(most)
                figure.text((x + _CELL / 2, y + _CELL / 2), _short(count), 8, PAPER if dark else INK, "mm")
    _draw_names(figure, groups, side)
    _draw_key(figure, coverage, side)
    return figure.finished()


def _short(count: int) -> str:
    return str(count) if count < 1000 else f"{count / 1000:.0f}k" if count >= 9950 else f"{count / 1000:.1f}k"


def _fill(coverage: Coverage, first: str, second: str, most: int) -> Colour:
    count = coverage.diphones_.get((first, second), 0)
    if count >= coverage.least:
        return _blue(np.log(count / coverage.least) / np.log(most / coverage.least))
    if count:
        return _RARE
    viseme = articulation_table().viseme_of
    alike = coverage.classes_.get((viseme(first), viseme(second)), 0)
    return _FAINT if alike >= coverage.least else PAPER


def _blue(share: float) -> Colour:
    red, green, blue = (_PALE + (_DEEP - _PALE) * share).round().astype(int).tolist()
    return red, green, blue


def _draw_names(figure: Figure, groups: dict[str, tuple[str, ...]], side: int) -> None:
    """Phones and classes along both edges, lines between the classes."""
    place = 0
    for number, (name, members) in enumerate(groups.items()):
        middle = (place + len(members) / 2) * _CELL
        title = name.replace("_", " ")
        figure.text((_LEFT - 32, _TOP + middle), title, 10, anchor="rm")
        figure.text((_LEFT + middle, _TOP - 32 - (number % 3) * 18), title, 10, anchor="ms")
        figure.line([(_LEFT + middle, _TOP - 30 - (number % 3) * 18), (_LEFT + middle, _TOP - 24)], _BORDER)
        for phone in members:
            centre = (place + 0.5) * _CELL
            figure.text((_LEFT - 4, _TOP + centre), phone, 10, anchor="rm")
            figure.text((_LEFT + centre, _TOP - 5), phone, 10, anchor="ms")
            place += 1
        edge = place * _CELL
        figure.line([(_LEFT - 28, _TOP + edge), (_LEFT + side, _TOP + edge)], _BORDER)
        figure.line([(_LEFT + edge, _TOP - 20), (_LEFT + edge, _TOP + side)], _BORDER)
    figure.text((_LEFT, 22), "Diphones heard in learning: first phone in rows, second in columns", 14, anchor="lm")


def _draw_key(figure: Figure, coverage: Coverage, side: int) -> None:
    y, x = _TOP + side + 24, float(_LEFT)
    entries = (
        (_blue(0.6), f"{coverage.least} times or more"),
        (_RARE, "fewer times"),
        (_FAINT, "never, but pairs of the same classes"),
        (PAPER, "nothing like it"),
    )
    for colour, text in entries:
        figure.rectangle((x, y, x + 18, y + 18), colour, _BORDER)
        figure.text((x + 24, y + 9), text, 12, anchor="lm")
        x += 24 + figure.length_of(text, 12) + 28
