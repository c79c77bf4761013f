"""``.TextGrid``: words and phones in time, as Praat keeps them.

Written in Praat's long form, UTF-8. Read in its long and short form, UTF-8 or UTF-16: as Praat itself does, the
reader takes free-standing numbers, quoted texts and <flags> and passes over everything else.
Source: the Praat manual, "TextGrid file formats".
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from mien.core.border import guarded
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.plain_text import read_plain_text
from mien.core.timeline import Interval, Tier

__all__ = ["read_textgrid", "write_textgrid"]

_TOUCHING = 1e-9  # seconds; the tolerance of `Tier`
_ROUNDED = 1e-3  # seconds; intervals that overlap by less were rounded
_TOKEN = re.compile(
    r'"(?P<text>(?:[^"]|"")*)"|(?P<flag><\w+>)|(?<!\S)![^\n]*'  # the last: a remark
    r"|(?<!\S)(?P<number>[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?)(?!\S)"
)


def write_textgrid(tiers: Sequence[Tier], duration: float, path: str | Path) -> tuple[Note, ...]:
    """Write tiers of intervals as a TextGrid.

    Parameters
    ----------
    tiers : sequence of Tier
    duration : float
        Seconds of the sound. Every tier is made to cover 0 to ``duration``: a gap becomes an interval without a
        label. If an interval ends later, the grid ends with it.
    path : path-like

    Returns
    -------
    tuple of Note
        Says which intervals of no length were left out: Praat cannot hold them.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    first = min([0.0, *(i.start for tier in tiers for i in tier)])
    last = max([duration, *(i.end for tier in tiers for i in tier)])
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', ""]
    lines += [f"xmin = {_number(first)} ", f"xmax = {_number(last)} ", "tiers? <exists> "]
    lines += [f"size = {len(tiers)} ", "item []: "]
    for number, tier in enumerate(tiers, start=1):
        lines += [f"    item [{number}]:", *_tier_lines(tier, first, last)]
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    empty = [(tier.name, i) for tier in tiers for i in tier if i.duration <= _TOUCHING]
    return tuple(
        Note("note", f"{name} at {i.start:.3f} s ({i.label!r}) has no length and is not in {Path(path).name}")
        for name, i in empty
    )


def _tier_lines(tier: Tier, first: float, last: float) -> Iterator[str]:
    filled = list(_without_gaps(tier, first, last))
    yield '        class = "IntervalTier" '
    yield f"        name = {_quoted(tier.name)} "
    yield f"        xmin = {_number(first)} "
    yield f"        xmax = {_number(last)} "
    yield f"        intervals: size = {len(filled)} "
    for number, (start, end, label) in enumerate(filled, start=1):
        yield f"        intervals [{number}]:"
        yield f"            xmin = {_number(start)} "
        yield f"            xmax = {_number(end)} "
        yield f"            text = {_quoted(label)} "


def _without_gaps(tier: Tier, first: float, last: float) -> Iterator[tuple[float, float, str]]:
    """Intervals of some length that cover first..last; what lies between them has an empty label."""
    now = first
    for interval in tier:
        if interval.duration <= _TOUCHING:
            continue
        start = now if abs(interval.start - now) <= _TOUCHING else interval.start
        end = last if abs(last - interval.end) <= _TOUCHING else interval.end
        if start > now:
            yield now, start, ""
        yield start, end, interval.label
        now = end
    if last > now:
        yield now, last, ""


def _number(seconds: float) -> str:
    return np.format_float_positional(seconds, trim="-")  # the shortest that reads back exactly; Praat takes no "1e-05"


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"'


@guarded("a TextGrid")
def read_textgrid(path: str | Path) -> list[Tier]:
    """Read the tiers of a TextGrid, in the order of the file.

    Intervals without a label are gaps and are left out. The points of a point tier become intervals of no length.

    Raises
    ------
    InputError
        If the file is missing, no TextGrid, or cut short; the message names the file.
    """
    path = Path(path)
    tokens = _tokens(path)
    if list(islice(tokens, 2)) != ["ooTextFile", "TextGrid"]:
        raise InputError(f'{path} is not a TextGrid: it does not begin with "ooTextFile" and "TextGrid"')
    try:
        _, _, flag = _take(tokens, 3)
        return [_read_tier(tokens) for _ in range(_count(*_take(tokens, 1)))] if flag == "<exists>" else []
    except (ValueError, InputError) as problem:
        raise InputError(f"{path} is not a well-formed TextGrid: {problem}") from problem


def _tokens(path: Path) -> Iterator[str | float]:
    text, _ = read_plain_text(path, "a TextGrid")
    for match in _TOKEN.finditer(text):
        if match["text"] is not None:
            yield match["text"].replace('""', '"')
        elif match["number"] is not None:
            yield float(match["number"].replace(",", "."))
        elif match["flag"] is not None:
            yield match["flag"]


def _take(tokens: Iterator[str | float], number: int) -> list[str | float]:
    taken = list(islice(tokens, number))
    if len(taken) < number:
        raise ValueError("it ends too early; was it cut short?")
    return taken


def _read_tier(tokens: Iterator[str | float]) -> Tier:
    kind, name, _, _, count = _take(tokens, 5)
    if kind not in ("IntervalTier", "TextTier"):
        raise ValueError(f"expected IntervalTier or TextTier, got {kind!r}")
    intervals: list[Interval] = []
    for _ in range(_count(count)):
        *times, label = _take(tokens, 3 if kind == "IntervalTier" else 2)
        start, end = _seconds(times[0]), _seconds(times[-1])
        if not isinstance(label, str):
            raise ValueError(f"tier {name!r}: expected a label at {start:g} s, got the number {label:g}")
        if label and intervals and 0 < intervals[-1].end - start <= _ROUNDED < end - start:
            start = intervals[-1].end
        if label:
            intervals.append(Interval(start, end, label))
    return Tier(str(name), tuple(intervals))


def _seconds(token: str | float) -> float:
    if isinstance(token, str):
        raise ValueError(f"expected a time in seconds, got {token!r}")
    return token


def _count(token: str | float) -> int:
    number = _seconds(token)
    if number < 0 or number != int(number):
        raise ValueError(f"expected a number of tiers or intervals, got {number:g}")
    return int(number)
