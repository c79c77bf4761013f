"""`IntensityCurve`: how strong an emotion is over time, from 0 (neutral) to 1 (full) (Deng et al. 2006)."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from mien.core.border import reading
from mien.core.errors import InputError
from mien.core.table_rows import read_rows
from mien.text.sync_points import Moment

__all__ = [
    "Curve",
    "IntensityCurve",
    "SpanPoint",
    "checked",
    "checked_intensity",
    "parse_intensity",
    "parse_span_intensity",
    "parse_span_values",
    "parse_values",
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
    highest: ClassVar[float] = 1.0
    what: ClassVar[str] = "intensity"

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.values):
            raise InputError(
                f"an {self.what} curve has a value for each of its times, not {len(self.times)} and {len(self.values)}"
            )
        if self.interpolation not in ("smooth", "linear"):
            raise InputError(f"an {self.what} curve is 'smooth' or 'linear', not {self.interpolation!r}")
        if not all(math.isfinite(time) for time in self.times):
            raise InputError(f"an {self.what} curve has a time that is not a finite number")
        for before, after in pairwise(self.times):
            if after <= before:
                raise InputError(f"times of an {self.what} curve rise: {after:g} s does not come after {before:g} s")
        for value in self.values:
            checked(value, type(self))

    def at(self, seconds: Floats) -> Floats:
        """Values at instants, shape (times,)."""
        inside = np.clip(np.asarray(seconds, dtype=np.float64), self.times[0], self.times[-1])
        if self.interpolation == "linear" or len(self.times) < 3:
            return np.asarray(np.interp(inside, self.times, self.values), dtype=np.float64)
        from scipy.interpolate import PchipInterpolator

        found = PchipInterpolator(self.times, self.values)(inside)
        return np.asarray(np.clip(found, 0.0, self.highest), dtype=np.float64)


Curve = TypeVar("Curve", bound=IntensityCurve)


def checked_intensity(value: float, where: str = "") -> float:
    """The same value, if it lies between 0 and 1.

    Raises
    ------
    InputError
        If not; per cent are recognised.
    """
    return checked(value, IntensityCurve, where)


def checked(value: float, kind: type[IntensityCurve], where: str = "") -> float:
    """The same value, if a kind of curve may have it.

    Raises
    ------
    InputError
        If not; per cent are recognised.
    """
    if not 0.0 <= value <= kind.highest:
        meant = value / (10 if value < 10 else 100)  # 7 of 10, or per cent
        guess = f": did you mean {meant:g}?" if 5 * kind.highest < value <= 100 * kind.highest else ""
        raise InputError(f"{where}an {kind.what} runs from 0 to {kind.highest:g}, not {value:g}{guess}")
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
    return parse_values(text, IntensityCurve)


def parse_values(text: str, kind: type[Curve]) -> float | Curve:
    """Read a number, key points (value at second) or a ``.csv`` file as values of a kind of curve.

    Raises
    ------
    InputError
        If it is none of these, or out of range.
    """
    if text.strip().lower().endswith(".csv"):
        return _read_values(text.strip(), kind)
    try:
        if "@" not in text:
            return checked(float(text), kind)
        points = [tuple(map(float, point.split("@"))) for point in text.split(",")]
        if any(len(point) != 2 for point in points):
            raise ValueError("a point is VALUE@SECOND")
    except ValueError as problem:
        raise InputError(
            f"an {kind.what} is a number from 0 to {kind.highest:g}, points such as 0.2@0,0.9@1.5 (value at second), "
            f"or a .csv file, not {text!r}"
        ) from problem
    return kind(tuple(point[1] for point in points), tuple(point[0] for point in points))


@dataclass(frozen=True)
class SpanPoint:
    """A point of an intensity curve inside a tag.

    Attributes
    ----------
    value : float
        0 to 1; of an effort to 2.
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
    return parse_span_values(text, IntensityCurve)


def parse_span_values(text: str, kind: type[IntensityCurve]) -> float | tuple[SpanPoint, ...]:
    """As `parse_span_intensity`, for the values of a kind of curve.

    Raises
    ------
    InputError
        If it is neither, out of range, or the points do not rise.
    """
    if "@" not in text:
        try:
            return checked(float(text), kind)
        except ValueError as problem:
            raise InputError(
                f"{kind.what} is a number from 0 to {kind.highest:g}, or points such as 0.2@0,0.9@1.5 (value at second "
                f"of the tag) or 0.2@0%,0.9@100%, not {text!r}"
            ) from problem
    points: list[SpanPoint] = []
    for part in text.split(","):
        found = _POINT.fullmatch(part)
        if found is None or not _is_number(found["value"]):
            raise InputError(
                f"a point of an {kind.what} is VALUE@SECOND or VALUE@PERCENT% of the tag, such as 0.9@1.5 or 0.9@50%, "
                f"not {part.strip()!r}"
            )
        share = found["unit"] == "%"
        place = float(found["place"]) / (100 if share else 1)
        if share and place > 1:
            raise InputError(f"a point of an {kind.what} lies between 0% and 100% of its tag, not at {100 * place:g}%")
        points.append(SpanPoint(checked(float(found["value"]), kind), place, share))
        if len(points) > 1 and points[-2].is_share == share and place <= points[-2].place:
            raise InputError(f"points of an {kind.what} rise: {part.strip()!r} does not come after the one before it")
    return tuple(points)


def read_intensity(path: str | Path) -> IntensityCurve:
    """Read a curve from a CSV file: two columns, seconds and intensity, with or without a line of headings.

    A curve of more than a few points is taken as drawn: straight lines between them.

    Raises
    ------
    InputError
        If the file is missing or a line is not two numbers; the message names the line.
    """
    return _read_values(path, IntensityCurve)


def _read_values(path: str | Path, kind: type[Curve]) -> Curve:
    path = Path(path)
    what = f"a CSV of two columns, seconds and {kind.what}"
    with reading(path, what):
        table = read_rows(path, what, "keys")
    times: list[float] = []
    values: list[float] = []
    for number, line in table.rows:
        cells = [table.spelt(cell) for cell in line if cell]
        if cells[0].startswith("#") or (not times and not _is_number(cells[0])):
            continue
        if len(cells) != 2 or not all(map(_is_number, cells)):
            raise InputError(f"{path}, line {number}: expected seconds and an {kind.what}, got {','.join(line)[:60]!r}")
        if times and float(cells[0]) <= times[-1]:
            raise InputError(f"{path}, line {number}: {cells[0]} s does not come after {times[-1]:g} s")
        times.append(float(cells[0]))
        values.append(checked(float(cells[1]), kind, f"{path}, line {number}: "))
    if not times:
        raise InputError(f"{path}: expected lines of seconds and an {kind.what}, found none")
    return kind(tuple(times), tuple(values), "linear")


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False
