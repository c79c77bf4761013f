"""Regions of influence in a tree configuration: which vertices, and with what weight.

Each kind reads its words, finds its weights on a mesh, and spells itself again so that what is read back is equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["REGIONS", "Everywhere", "Listed", "Region", "Side", "Sphere", "read_number", "read_three", "spelt"]

Chosen = tuple[NDArray[np.int64], NDArray[np.float64]]
Vector = tuple[float, float, float]
_MOST_VERTICES = 10**7
_PER_LINE = 12


class Region(Protocol):
    """What every kind of region offers."""

    def on(self, part: str, vertices: NDArray[np.floating]) -> Chosen:
        """Vertices of a part and their weights; ValueError where it does not fit the part."""
        ...

    def lines(self, part: str | None) -> list[str]:
        """The statements that say it."""
        ...


def spelt(*numbers: float) -> str:
    """Numbers as text that reads back as the same bits.

    Examples
    --------
    >>> spelt(1.0, -0.1, 2.5e-07)
    '1 -0.1 2.5e-07'
    """
    return " ".join([repr(float(number)).removesuffix(".0") for number in numbers])


def read_number(text: str) -> float:
    """A finite number; ValueError otherwise."""
    try:
        number = float(text)
    except ValueError:
        raise ValueError(f"expected a number, got {text!r}") from None
    if not math.isfinite(number):
        raise ValueError(f"expected a finite number, got {text!r}")
    return number


def read_three(words: Sequence[str], what: str) -> Vector:
    """Three finite numbers; ValueError otherwise."""
    if len(words) != 3:
        raise ValueError(f"{what} has three numbers, got {len(words)}")
    return read_number(words[0]), read_number(words[1]), read_number(words[2])


def _named(part: str | None) -> str:
    return "" if part is None else f"part:{part} "


@dataclass(frozen=True)
class Everywhere:
    """``all WEIGHT``."""

    weight: float = 1.0

    @classmethod
    def read(cls, words: Sequence[str]) -> Everywhere:
        """From the words behind ``all``."""
        if len(words) != 1:
            raise ValueError("expected 'all WEIGHT'")
        return cls(read_number(words[0]))

    def on(self, part: str, vertices: NDArray[np.floating]) -> Chosen:
        """All vertices."""
        return np.arange(len(vertices)), np.full(len(vertices), self.weight)

    def lines(self, part: str | None) -> list[str]:
        """As a statement."""
        return [f"all {_named(part)}{spelt(self.weight)}"]


@dataclass(frozen=True)
class Sphere:
    """``sphere X Y Z radius R soft S [weight W]``: W inside, smoothly 0 at R + S."""

    centre: Vector
    radius: float
    soft: float
    weight: float = 1.0

    @classmethod
    def read(cls, words: Sequence[str]) -> Sphere:
        """From the words behind ``sphere``."""
        if len(words) not in (7, 9) or words[3] != "radius" or words[5] != "soft" or words[7:8] not in ([], ["weight"]):
            raise ValueError("expected 'sphere X Y Z radius R soft S' and, if wanted, 'weight W'")
        radius, soft = read_number(words[4]), read_number(words[6])
        if radius < 0 or soft < 0:
            raise ValueError("a radius and a soft edge are not negative")
        return cls(read_three(words[:3], "a centre"), radius, soft, read_number(words[8]) if len(words) == 9 else 1.0)

    def on(self, part: str, vertices: NDArray[np.floating]) -> Chosen:
        """The vertices in it."""
        return _faded(np.linalg.norm(vertices - np.array(self.centre), axis=1) - self.radius, self.soft, self.weight)

    def lines(self, part: str | None) -> list[str]:
        """As a statement."""
        sizes = f"radius {spelt(self.radius)} soft {spelt(self.soft)}{_weighed(self.weight)}"
        return [f"sphere {_named(part)}{spelt(*self.centre)} {sizes}"]


@dataclass(frozen=True)
class Side:
    """``side NX NY NZ of X Y Z soft S [weight W]``: W where the normal points, smoothly 0 at S before."""

    normal: Vector
    point: Vector
    soft: float
    weight: float = 1.0

    @classmethod
    def read(cls, words: Sequence[str]) -> Side:
        """From the words behind ``side``."""
        if len(words) not in (9, 11) or words[3] != "of" or words[7] != "soft" or words[9:10] not in ([], ["weight"]):
            raise ValueError("expected 'side NX NY NZ of X Y Z soft S' and, if wanted, 'weight W'")
        normal, point = read_three(words[:3], "a normal"), read_three(words[4:7], "a point")
        soft, weight = read_number(words[8]), read_number(words[10]) if len(words) == 11 else 1.0
        if not any(normal):
            raise ValueError("the normal has no length")
        if soft < 0:
            raise ValueError("a soft edge is not negative")
        return cls(normal, point, soft, weight)

    def on(self, part: str, vertices: NDArray[np.floating]) -> Chosen:
        """The vertices on that side."""
        unit = np.array(self.normal) / np.linalg.norm(self.normal)
        return _faded(-((vertices - np.array(self.point)) @ unit), self.soft, self.weight)

    def lines(self, part: str | None) -> list[str]:
        """As a statement."""
        where = f"{spelt(*self.normal)} of {spelt(*self.point)} soft {spelt(self.soft)}"
        return [f"side {_named(part)}{where}{_weighed(self.weight)}"]


@dataclass(frozen=True)
class Listed:
    """``weights PART VERTEX:WEIGHT FIRST-LAST:WEIGHT ...``; runs are (first, last, weight), last included."""

    runs: tuple[tuple[int, int, float], ...]

    @classmethod
    def read(cls, words: Sequence[str]) -> Listed:
        """From the words behind ``weights PART``."""
        return cls(tuple(_run(word) for word in words))

    def on(self, part: str, vertices: NDArray[np.floating]) -> Chosen:
        """The vertices named."""
        last = max(run[1] for run in self.runs)
        if last >= len(vertices):
            raise ValueError(f"vertex {last} is beyond the {len(vertices)} of part {part!r}")
        chosen = np.concatenate([np.arange(first, last + 1) for first, last, _ in self.runs])
        return chosen, np.concatenate([np.full(last - first + 1, weight) for first, last, weight in self.runs])

    def lines(self, part: str | None) -> list[str]:
        """As statements of a readable length."""
        words = [f"{a}-{b}:{spelt(weight)}" if b > a else f"{a}:{spelt(weight)}" for a, b, weight in self.runs]
        return [f"weights {part} {' '.join(words[i : i + _PER_LINE])}" for i in range(0, len(words), _PER_LINE)]


def _run(word: str) -> tuple[int, int, float]:
    places, colon, weight = word.partition(":")
    first, dash, last = places.partition("-")
    if not colon or not _is_index(first) or (dash and not _is_index(last)):
        raise ValueError(f"expected VERTEX:WEIGHT or FIRST-LAST:WEIGHT, got {word!r}")
    begin, end = int(first), int(last or first)
    if end < begin:
        raise ValueError(f"{word!r} runs backwards")
    if end >= _MOST_VERTICES:
        raise ValueError(f"{word!r} names more vertices than any mesh has")
    return begin, end, read_number(weight)


def _is_index(text: str) -> bool:
    return text.isascii() and text.isdecimal()


def _weighed(weight: float) -> str:
    return "" if weight == 1.0 else f" weight {spelt(weight)}"


def _faded(outside: NDArray[np.floating], soft: float, weight: float) -> Chosen:
    share = np.clip(1 - outside / max(soft, 1e-9), 0, 1)
    chosen = np.flatnonzero(share > 0)
    return chosen, weight * (share * share * (3 - 2 * share))[chosen]


REGIONS: dict[str, Callable[[Sequence[str]], Region]] = {
    "all": Everywhere.read,
    "sphere": Sphere.read,
    "side": Side.read,
}
"""How the regions that are shapes are read."""
