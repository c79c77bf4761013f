"""Expansion procedures: how the time-value lists of a library command become the keys of one performance.

A procedure takes the lists (milliseconds from the command's start, values) with the parameters of the command and gives
lists in the same form. `periodic` is the paper's (Frydrych et al. 2003, section 2.3); the others are what gestures of a
head and a face need besides. Lists of one command keep their times to one another.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from mien.core.errors import InputError

__all__ = ["PROCEDURES", "Procedure", "Request"]

Key = tuple[float, float]
Lists = dict[str, list[Key]]


@dataclass(frozen=True)
class Request:
    """What a command asks of its procedure.

    Attributes
    ----------
    name : str
        Of the command, for messages.
    numbers : mapping
        Its parameters, defaults included.
    given : collection of str
        Which of them were given: they beat defaults.
    """

    name: str
    numbers: Mapping[str, float]
    given: Collection[str]

    def first_of(self, *names: str) -> str | None:
        """The first of rival parameters that counts: a given one before a default, then in the order named."""
        known = [name for name in names if name in self.numbers]
        return next((name for name in known if name in self.given), known[0] if known else None)

    def positive(self, name: str) -> float:
        """A parameter that has to be above 0."""
        number = self.numbers[name]
        if not 0 < number <= 1e9:
            raise InputError(f"{self.name}: {name} is a number above 0, not {number:g}")
        return number


@dataclass(frozen=True)
class Procedure:
    """One way to expand.

    Attributes
    ----------
    about : str
        One line.
    uses : tuple of str
        Parameters that it understands.
    needs : tuple of tuple of str
        Of each group at least one has to be among the command's parameters.
    expand : callable
    """

    about: str
    uses: tuple[str, ...]
    needs: tuple[tuple[str, ...], ...]
    expand: Callable[[Lists, Request], Lists]


def _length(lists: Lists) -> float:
    return max(keys[-1][0] for keys in lists.values())


def _period(lists: Lists, request: Request) -> float:
    """Length of one action in ms: period beats frequency (1000/period), what is given beats a default."""
    chosen = request.first_of("period", "frequency")
    if chosen is None:
        return _length(lists)
    return request.positive("period") if chosen == "period" else 1000.0 / request.positive("frequency")


def _count(period: float, request: Request) -> int:
    """Number of actions: count beats end (ms from the start: as many whole actions as fit, at least one)."""
    if request.first_of("count", "end") == "end":
        count = max(1.0, np.floor(request.positive("end") / period + 1e-9))
    else:
        count = request.numbers.get("count", 1.0)
        if count != int(count) or count < 1:
            raise InputError(f"{request.name}: count is a whole number, 1 or more, not {count:g}")
    if count > 10_000:
        raise InputError(f"{request.name}: {count:g} repetitions are too many: at most 10000")
    return int(count)


def _append(keys: list[Key], key: Key) -> None:
    """A key, unless it says what the last one says already (where one action ends and the next begins)."""
    if not keys or keys[-1] != key:
        keys.append(key)


def _repeated(lists: Lists, period: float, count: int, sizes: list[float], starts: list[float] | None = None) -> Lists:
    scale = period / _length(lists)
    starts = starts if starts is not None else [number * period for number in range(count + 1)]
    result: Lists = {}
    for name, keys in lists.items():
        result[name] = []
        for number in range(count):
            stretch = (starts[number + 1] - starts[number]) / period
            for time, value in keys:
                at = round(starts[number] + time * scale * stretch, 6)
                _append(result[name], (at, round(value * sizes[number], 9)))
    return result


def _periodic(lists: Lists, request: Request) -> Lists:
    period = _period(lists, request)
    count = _count(period, request)
    return _repeated(lists, period, count, [1.0] * count)


def _decaying(lists: Lists, request: Request) -> Lists:
    period = _period(lists, request)
    count = _count(period, request)
    keep = request.positive("decay") / 100
    return _repeated(lists, period, count, [keep**number for number in range(count)])


def _alternating(lists: Lists, request: Request) -> Lists:
    period = _period(lists, request)
    count = _count(period, request)
    return _repeated(lists, period, count, [(-1.0) ** number for number in range(count)])


def _irregular(lists: Lists, request: Request) -> Lists:
    period = _period(lists, request)
    count = _count(period, request)
    spread, seed = request.numbers["spread"] / 100, request.numbers.get("seed", 0.0)
    if not 0 <= spread < 1:
        raise InputError(f"{request.name}: spread is in per cent, 0 to below 100, not {spread * 100:g}")
    if seed != int(seed) or seed < 0:
        raise InputError(f"{request.name}: seed is a whole number, 0 or more, not {seed:g}")
    random = np.random.default_rng(int(seed))
    lengths = period * (1 + spread * random.uniform(-1, 1, count))
    sizes = 1 + spread * random.uniform(-1, 1, count)
    starts = [0.0, *(round(float(start), 3) for start in np.cumsum(lengths))]
    return _repeated(lists, period, count, [float(size) for size in sizes], starts)


def _once(lists: Lists, request: Request) -> Lists:
    return _repeated(lists, request.positive("duration") if "duration" in request.numbers else _length(lists), 1, [1.0])


def _held(lists: Lists, request: Request) -> Lists:
    """What stands at time `peak` lasts until all takes `end` ms; where that is too short, all is hurried."""
    length, end, peak = _length(lists), request.positive("end"), request.numbers["peak"]
    if not 0 <= peak <= length:
        raise InputError(f"{request.name}: peak lies in the lists, 0 to {length:g} ms, not {peak:g}")
    wait, hurry = max(0.0, end - length), min(1.0, end / length)
    result: Lists = {}
    for name, keys in lists.items():
        times, values = [time for time, _ in keys], [value for _, value in keys]
        middle = float(np.interp(peak, times, values))
        before = [key for key in keys if key[0] < peak]
        after = [(time + wait, value) for time, value in keys if time > peak]
        result[name] = []
        for time, value in (*before, (peak, middle), (peak + wait, middle), *after):
            _append(result[name], (round(time * hurry, 6), value))
    return result


_REPEATS = ("period", "frequency", "count", "end")

PROCEDURES: dict[str, Procedure] = {
    "periodic": Procedure(
        "the action again and again", _REPEATS, (("period", "frequency"), ("count", "end")), _periodic
    ),
    "once": Procedure("the action once, in `duration` ms", ("duration",), (), _once),
    "held": Procedure(
        "the action up to `peak` ms, held until all lasts `end` ms", ("peak", "end"), (("peak",), ("end",)), _held
    ),
    "decaying": Procedure(
        "again and again, each time only `decay` per cent as large",
        (*_REPEATS, "decay"),
        (("period", "frequency"), ("count", "end"), ("decay",)),
        _decaying,
    ),
    "alternating": Procedure(
        "again and again, every second time mirrored",
        _REPEATS,
        (("period", "frequency"), ("count", "end")),
        _alternating,
    ),
    "irregular": Procedure(
        "again and again, each time up to `spread` per cent longer or shorter, larger or smaller, by `seed`",
        (*_REPEATS, "spread", "seed"),
        (("period", "frequency"), ("count", "end"), ("spread",)),
        _irregular,
    ),
}
"""All procedures, by the name that ``$proc`` gives."""
