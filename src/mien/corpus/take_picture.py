"""A picture of one take: waveform, words and phones, and a few distances on the face over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import OutputError
from mien.core.files import replace_when_complete
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont, ImageFont

__all__ = ["MEASURES", "draw_take"]

MEASURES: tuple[tuple[str, tuple[str, ...], tuple[str, ...], str], ...] = (
    ("lip opening", ("2.2", "8.1"), ("2.3", "8.2"), "distance"),
    ("lip width", ("8.3",), ("8.4",), "distance"),
    ("chin down", ("2.1", "2.10"), (), "down"),
    ("brow up", ("4.3",), (), "up"),
)
"""Name, first marker, second marker, how it is measured; of several names the first that is there counts."""
_LEFT, _TOP, _WAVE, _STRIP, _PLOT, _GAP = 110, 44, 110, 26, 110, 14
_PIXELS_PER_SECOND, _LEAST, _MOST = 320, 900, 6000
_INK, _FAINT, _GRID = (30, 34, 40), (120, 126, 134), (226, 229, 233)
_COLOURS = ((36, 99, 176), (196, 78, 32), (42, 132, 74), (126, 72, 160))
Colour = tuple[int, int, int]


def draw_take(take: Take, path: str | Path) -> None:
    """Draw a take as a PNG.

    Raises
    ------
    OutputError
        If the file cannot be written, or its suffix is not .png.
    """
    from PIL import Image, ImageDraw

    path = Path(path)
    if path.suffix.lower() != ".png":
        raise OutputError(f"cannot write {path}: the picture of a take is a .png")
    curves = _curves(take)
    width = _LEFT + int(np.clip(take.duration * _PIXELS_PER_SECOND, _LEAST, _MOST)) + 20
    height = _TOP + _WAVE + 2 * _STRIP + len(curves) * (_PLOT + _GAP) + 44
    image = Image.new("RGB", (width, height), "white")
    sheet = _Sheet(ImageDraw.Draw(image), width, take.duration)
    title = f"{take.name}   {take.text!r}   {take.emotion}" + (f"   {take.speaker}" if take.speaker else "")
    sheet.draw.text((_LEFT, 12), title, fill=_INK, font=sheet.font(16))
    top = sheet.waveform(take, _TOP)
    top = sheet.strip("words", take.words, top)
    top = sheet.strip("phones", take.phones, top)
    for number, (name, values) in enumerate(curves):
        top = sheet.curve(name, values, take, top + _GAP, _COLOURS[number % len(_COLOURS)])
    sheet.seconds(top)
    with replace_when_complete(path) as unfinished:
        image.save(unfinished, format="PNG")


def _curves(take: Take) -> list[tuple[str, NDArray[np.float64]]]:
    """What can be measured on the markers of this take, mm."""
    place = {name: number for number, name in enumerate(take.markers.names)}
    positions = take.markers.positions
    curves = []
    for name, first, second, how in MEASURES:
        one = next((place[m] for m in first if m in place), None)
        other = next((place[m] for m in second if m in place), None)
        if one is None or (other is None and second):
            continue
        if how == "distance" and other is not None:
            values = np.linalg.norm(positions[:, one] - positions[:, other], axis=1)
        else:
            values = positions[:, one, 1] * (1.0 if how == "up" else -1.0)
            values = values - np.nanmedian(values) if np.isfinite(values).any() else values
        curves.append((f"{name} (mm)", values))
    return curves


class _Sheet:
    """Where things go on the picture."""

    def __init__(self, draw: ImageDraw, width: int, duration: float) -> None:
        self.draw, self.width, self.duration = draw, width, max(duration, 1e-6)

    def font(self, size: int) -> FreeTypeFont | ImageFont:
        from PIL import ImageFont

        return ImageFont.load_default(size)

    def x(self, seconds: float) -> float:
        return _LEFT + (self.width - _LEFT - 20) * seconds / self.duration

    def waveform(self, take: Take, top: int) -> int:
        """Highest and lowest sample in each column of pixels."""
        columns = self.width - _LEFT - 20
        samples = take.audio.samples
        edges = np.linspace(0, len(samples), columns + 1).astype(int)
        peak = max(float(np.abs(samples).max(initial=0.0)), 1e-6)
        for column in range(columns):
            part = samples[edges[column] : max(edges[column + 1], edges[column] + 1)]
            if len(part):
                high, low = (top + _WAVE / 2 * (1 - 0.95 * float(v) / peak) for v in (part.max(), part.min()))
                self.draw.line([(_LEFT + column, high), (_LEFT + column, low + 1)], fill=_FAINT)
        self.draw.text((8, top + _WAVE / 2 - 8), "sound", fill=_INK, font=self.font(13))
        return top + _WAVE

    def strip(self, name: str, tier: Tier, top: int) -> int:
        """Intervals with their labels."""
        self.draw.text((8, top + 5), name, fill=_INK, font=self.font(13))
        for interval in tier:
            left, right = self.x(interval.start), self.x(interval.end)
            pause = interval.label == PAUSE
            self.draw.rectangle(
                [left, top, right, top + _STRIP], fill="white" if pause else (238, 243, 249), outline=_GRID
            )
            if not pause:
                self._label(interval, left, right, top)
        return top + _STRIP

    def _label(self, interval: Interval, left: float, right: float, top: int) -> None:
        for size in (13, 11, 9):
            length = self.draw.textlength(interval.label, font=self.font(size))
            if length <= right - left - 1 or size == 9:
                middle = ((left + right - length) / 2, top + (_STRIP - size) / 2 - 1)
                self.draw.text(middle, interval.label, fill=_INK, font=self.font(size))
                return

    def curve(self, name: str, values: NDArray[np.float64], take: Take, top: int, colour: Colour) -> int:
        """One trajectory with its lowest and highest value; frames without it leave a hole."""
        bottom = top + _PLOT
        self.draw.rectangle([_LEFT, top, self.width - 20, bottom], outline=_GRID)
        for interval in take.phones:
            self.draw.line([(self.x(interval.start), top), (self.x(interval.start), bottom)], fill=_GRID)
        seen = np.isfinite(values)
        label = name.partition(" (")
        self.draw.text((8, top + _PLOT / 2 - 16), label[0], fill=colour, font=self.font(13))
        if not seen.any():
            return bottom
        low, high = float(values[seen].min()), float(values[seen].max())
        span = max(high - low, 1e-6)
        times = take.markers.rate.times(len(values))
        points = [
            (self.x(time), bottom - 4 - (_PLOT - 8) * (value - low) / span)
            for time, value in zip(times, values, strict=True)
        ]
        for piece in _pieces(points, seen):
            self.draw.line(piece, fill=colour, width=2)
        for value, place in ((high, top + 2), (low, bottom - 16)):
            text = f"{value:.1f}"
            length = self.draw.textlength(text, font=self.font(11))
            self.draw.text((_LEFT - 6 - length, place), text, fill=_FAINT, font=self.font(11))
        self.draw.text((8, top + _PLOT / 2), f"({label[2]}", fill=_FAINT, font=self.font(11))
        return bottom

    def seconds(self, top: int) -> None:
        """Ticks below."""
        step = 0.1 if self.duration < 2 else 0.5 if self.duration < 10 else 2.0
        for number in range(int(self.duration / step) + 1):
            x = self.x(number * step)
            self.draw.line([(x, top), (x, top + 6)], fill=_FAINT)
            self.draw.text((x - 8, top + 8), f"{number * step:.1f}", fill=_FAINT, font=self.font(11))
        self.draw.text((8, top + 8), "seconds", fill=_FAINT, font=self.font(11))


def _pieces(points: Sequence[tuple[float, float]], seen: NDArray[np.bool_]) -> list[list[tuple[float, float]]]:
    """Runs of points that were seen, each of two points or more."""
    pieces: list[list[tuple[float, float]]] = [[]]
    for point, there in zip(points, seen, strict=True):
        if there:
            pieces[-1].append(point)
        elif pieces[-1]:
            pieces.append([])
    return [piece for piece in pieces if len(piece) > 1]
