"""`IntensityCurve`: how strong an emotion is over time, from 0 (neutral) to 1 (full) (SPEC A13)."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.text.sync_points import Moment

__all__ = [
    "IntensityCurve",
    "SpanPoint",
    "checked_intensity",
    "parse_intensity",
    "parse_span_intensity",
    "read_intensity",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class IntensityCurve:
    """An intensity that changes over time.

    Attributes
    ----------
    times : tuple of float
        Seconds from the start of the sound, rising.
    values : tuple of float
        0 (neutral) to 1 (full) at those times.
    interpolation : {"smooth", "linear"}
        Between key points: a monotone cubic (never leaves the range of its neighbours), or straight lines. Before the
        first and after the last the value is held.

    Raises
    ------
    InputError
        If there is no point, times do not rise, or a value lies outside 0..1.

    Examples
    --------
    >>> curve = IntensityCurve((0.0, 1.0), (0.2, 0.8), "linear")
    >>> curve.at(np.array([-1.0, 0.5, 9.0])).round(3).tolist()
    [0.2, 0.5, 0.8]
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    interpolation: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.values):
            raise InputError(
                f"an intensity curve has a value for each of its times, not {len(self.times)} and {len(self.values)}"
            )
        if self.interpolation not in ("smooth", "linear"):
            raise InputError(f"an intensity curve is 'smooth' or 'linear', not {self.interpolation!r}")
        if not all(math.isfinite(time) for time in self.times):
            raise InputError("an intensity curve has a time that is not a finite number")
        for before, after in pairwise(self.times):
            if after <= before:
                raise InputError(f"times of an intensity curve rise: {after:g} s does not come after {before:g} s")
        for value in self.values:
            checked_intensity(value)

    def at(self, seconds: Floats) -> Floats:
        """Intensities at instants, shape (times,)."""
        inside = np.clip(np.asarray(seconds, dtype=np.float64), self.times[0], self.times[-1])
        if self.interpolation == "linear" or len(self.times) < 3:
            return np.asarray(np.interp(inside, self.times, self.values), dtype=np.float64)
        from scipy.interpolate import PchipInterpolator

        return np.asarray(np.clip(PchipInterpolator(self.times, self.values)(inside), 0.0, 1.0), dtype=np.float64)


def checked_intensity(value: float, where: str = "") -> float:
    """The same value, if it lies between 0 and 1.

    Raises
    ------
    InputError
        If not; per cent are recognised.
    """
    if not 0.0 <= value <= 1.0:
        guess = f": did you mean {value / 100:g}?" if 1 < value <= 100 else ""
        raise InputError(f"{where}an intensity runs from 0 to 1, not {value:g}{guess}")
    return float(value)


def parse_intensity(text: str) -> float | IntensityCurve:
    """Read ``0.6``, key points ``0.2@0,0.9@1.5`` (value at second), or the name of a ``.csv`` file.

    Raises
    ------
    InputError
        If it is none of these, or out of range.

    Examples
    --------
    >>> parse_intensity("0.2@0, 0.9@1.5").values
    (0.2, 0.9)
    """
    if text.strip().lower().endswith(".csv"):
        return read_intensity(text.strip())
    try:
        if "@" not in text:
            return checked_intensity(float(text))
        points = [tuple(map(float, point.split("@"))) for point in text.split(",")]
        if any(len(point) != 2 for point in points):
            raise ValueError("a point is VALUE@SECOND")
    except ValueError as problem:
        raise InputError(
            f"an intensity is a number from 0 to 1, points such as 0.2@0,0.9@1.5 (value at second), or a .csv file, "
            f"not {text!r}"
        ) from problem
    return IntensityCurve(tuple(point[1] for point in points), tuple(point[0] for point in points))


@dataclass(frozen=True)
class SpanPoint:
    """A point of an intensity curve inside a tag.

    Attributes
    ----------
    value : float
        0 to 1.
    place : float
        Seconds after the start of the span, or its share of the span.
    is_share : bool
    """

    value: float
    place: float
    is_share: bool = False

    def moment(self, start: Moment, end: Moment) -> Moment:
        """When that is, between the moments at which the span starts and ends."""
        return start.towards(end, self.place) if self.is_share else start + 1000 * self.place


_POINT = re.compile(r"\s*(?P<value>[^@\s]+)\s*@\s*(?P<place>\d+(?:\.\d*)?|\.\d+)\s*(?P<unit>s|%)?\s*")


def parse_span_intensity(text: str) -> float | tuple[SpanPoint, ...]:
    """Read the intensity of a tag: ``0.6``, or points in seconds from its start or in per cent of its length.

    Raises
    ------
    InputError
        If it is neither, out of range, or the points do not rise.

    Examples
    --------
    >>> parse_span_intensity("0.2@0, 0.9@1.5")
    (SpanPoint(value=0.2, place=0.0, is_share=False), SpanPoint(value=0.9, place=1.5, is_share=False))
    >>> parse_span_intensity("0.2@0%,0.9@100%")[1]
    SpanPoint(value=0.9, place=1.0, is_share=True)
    """
    if "@" not in text:
        try:
            return checked_intensity(float(text))
        except ValueError as problem:
            raise InputError(
                f"intensity is a number from 0 to 1, or points such as 0.2@0,0.9@1.5 (value at second of the tag) or "
                f"0.2@0%,0.9@100%, not {text!r}"
            ) from problem
    points: list[SpanPoint] = []
    for part in text.split(","):
        found = _POINT.fullmatch(part)
        if found is None or not _is_number(found["value"]):
            raise InputError(
                f"a point of an intensity is VALUE@SECOND or VALUE@PERCENT% of the tag, such as 0.9@1.5 or 0.9@50%, "
                f"not {part.strip()!r}"
            )
        share = found["unit"] == "%"
        place = float(found["place"]) / (100 if share else 1)
        if share and place > 1:
            raise InputError(f"a point of an intensity lies between 0% and 100% of its tag, not at {100 * place:g}%")
        points.append(SpanPoint(checked_intensity(float(found["value"])), place, share))
        if len(points) > 1 and points[-2].is_share == share and place <= points[-2].place:
            raise InputError(f"points of an intensity rise: {part.strip()!r} does not come after the one before it")
    return tuple(points)


def read_intensity(path: str | Path) -> IntensityCurve:
    """Read a curve from a CSV file: two columns, seconds and intensity, with or without a line of headings.

    A curve of more than a few points is taken as drawn: straight lines between them.

    Raises
    ------
    InputError
        If the file is missing or a line is not two numbers; the message names the line.
    """
    path = Path(path)
    try:
        lines = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines()))
    except OSError as problem:
        raise InputError(f"cannot read {path}: {problem.strerror}") from problem
    except (UnicodeDecodeError, csv.Error) as problem:
        raise InputError(f"{path} is not a CSV of seconds and intensities: {problem}") from problem
    times: list[float] = []
    values: list[float] = []
    for number, line in enumerate(lines, start=1):
        cells = [cell.strip() for cell in line if cell.strip()]
        if not cells or cells[0].startswith("#") or (not times and not _is_number(cells[0])):
            continue
        if len(cells) != 2 or not all(map(_is_number, cells)):
            raise InputError(f"{path}, line {number}: expected seconds and an intensity, got {','.join(line)[:60]!r}")
        if times and float(cells[0]) <= times[-1]:
            raise InputError(f"{path}, line {number}: {cells[0]} s does not come after {times[-1]:g} s")
        times.append(float(cells[0]))
        values.append(checked_intensity(float(cells[1]), f"{path}, line {number}: "))
    if not times:
        raise InputError(f"{path}: expected lines of seconds and an intensity, found none")
    return IntensityCurve(tuple(times), tuple(values), "linear")


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False
