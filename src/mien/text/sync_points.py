"""`Moment`: an instant that is known only once the words have been spoken.

Points are names: ``start`` and ``end`` of the sound, marks, and places in the text. A point may be followed by what to
look for from there on: ``m.word.2`` (start of the second word), ``m.word.2.end``, ``m.phone.3`` (third phone),
``m.phone.UW.end``. A moment is a point with milliseconds to add (``m1+200``), or, for what lies between two points, a
weighted sum of points (``0.5*m1+0.5*m2``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from mien.core.errors import InputError

__all__ = ["Moment", "clock", "plain"]

_TERM = re.compile(
    r"\s*(?P<sign>[+-]?)\s*(?:(?P<weight>\d+(?:\.\d+)?)\s*\*\s*(?P<weighed>[A-Za-z_][\w.:#-]*?)"
    r"|(?P<number>\d+(?:\.\d*)?|\.\d+)\s*(?P<unit>ms|s)?(?![\w*])"
    r"|(?P<point>[A-Za-z_][\w.:#]*(?:-[A-Za-z_][\w.:#]*)*))\s*(?=[+-]|$)"
)


@dataclass(frozen=True)
class Moment:
    """Weighted points and milliseconds.

    Examples
    --------
    >>> Moment.parse("m1 + 0.5s")
    Moment(terms=(('m1', 1.0),), offset=500.0)
    >>> str(Moment.parse("0.25*a+0.75*b-40"))
    '0.25*a+0.75*b-40'
    """

    terms: tuple[tuple[str, float], ...] = ()
    offset: float = 0.0

    @classmethod
    def at(cls, point: str, offset: float = 0.0) -> Moment:
        """A point, and milliseconds after it."""
        return cls(((point, 1.0),), offset)

    @classmethod
    def parse(cls, text: str, here: str | None = None, seconds: bool = False) -> Moment:
        """Read a moment.

        Parameters
        ----------
        text : str
            ``1000`` (ms from the start), ``1.5s``, ``m1``, ``m1+200``; with ``here`` also ``+200`` and ``-0.1s``.
        here : str, optional
            The point that signed numbers count from, and that ``here``, ``word...`` and ``phone...`` mean.
        seconds : bool
            Whether plain numbers are seconds.

        Raises
        ------
        InputError
            If it cannot be understood.
        """
        terms: list[tuple[str, float]] = []
        offset, place = 0.0, 0
        signed = text.strip()[:1] in ("+", "-")
        while place < len(text):
            found = _TERM.match(text, place)
            if found is None or (place and not found["sign"]):
                raise InputError(
                    f"a time is milliseconds (1000), a place (m1, word, phone.2, end) or both (m1+200), not {text!r}"
                )
            sign = -1.0 if found["sign"] == "-" else 1.0
            if found["number"]:
                factor = 1000.0 if found["unit"] == "s" or (seconds and not found["unit"]) else 1.0
                offset += sign * round(float(found["number"]) * factor, 6)
            else:
                terms.append((_there(found["point"] or found["weighed"], here), sign * float(found["weight"] or 1)))
            place = found.end()
        if not text.strip():
            raise InputError("a time is empty: give milliseconds (1000) or a place (m1, word, end)")
        if signed and here is not None and not terms:
            terms.append((here, 1.0))
        return cls(tuple(terms), offset)

    def __str__(self) -> str:
        parts = [point if weight == 1 else f"{weight!r}*{point}" for point, weight in self.terms]
        if self.offset or not parts:
            parts.append(plain(self.offset))
        return "+".join(parts).replace("+-", "-")

    def __add__(self, milliseconds: float) -> Moment:
        return Moment(self.terms, round(self.offset + milliseconds, 6))

    def towards(self, other: Moment, share: float) -> Moment:
        """The moment that lies a share of the way to another one."""
        weights: dict[str, float] = {}
        for moment, weight in ((self, 1 - share), (other, share)):
            for point, factor in moment.terms:
                weights[point] = weights.get(point, 0.0) + factor * weight
        kept = tuple((point, round(weight, 9)) for point, weight in weights.items() if abs(weight) > 1e-9)
        return Moment(kept, round(self.offset * (1 - share) + other.offset * share, 6))

    def resolve(self, time_of: Callable[[str], float]) -> float:
        """Milliseconds, given what each point's are."""
        return round(sum(weight * time_of(point) for point, weight in self.terms) + self.offset, 3)


def _there(point: str, here: str | None) -> str:
    first = point.partition(".")[0]
    if here is not None and first in ("here", "word", "phone"):
        return here + (point[4:] if first == "here" else f".{point}")
    return point


def plain(number: float) -> str:
    """A number as it is written in a stream: the shortest that reads back exactly.

    Examples
    --------
    >>> plain(1000.0), plain(1166.5), plain(-0.015)
    ('1000', '1166.5', '-0.015')
    """
    return repr(int(number)) if number == int(number) and abs(number) < 1e15 else repr(float(number))


def clock(text: str, what: str = "a duration") -> float:
    """Milliseconds of ``500``, ``500ms`` or ``0.5s``.

    Raises
    ------
    InputError
        If it is none of these, or below 0.

    Examples
    --------
    >>> clock("0.5s"), clock("500ms"), clock("500")
    (500.0, 500.0, 500.0)
    """
    found = re.fullmatch(r"\s*\+?(\d+(?:\.\d*)?|\.\d+)\s*(ms|s)?\s*", text)
    if found is None or not math.isfinite(float(found[1])):
        raise InputError(f"{what} is such as 500, 500ms or 0.5s, not {text!r}")
    return round(float(found[1]) * (1000 if found[2] == "s" else 1), 6)
