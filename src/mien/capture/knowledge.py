"""What the solver knows beforehand: ``assets/capture/solver.toml``, read and checked once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.channels import ARKIT
from mien.core.errors import unknown_name

__all__ = ["SOURCES", "Knowledge", "Opening", "Region", "Source", "knowledge", "source_named"]

SOURCES = ("tracker", "optical")
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Source:
    """What a kind of recording sees.

    Attributes
    ----------
    name : str
    gain : tuple of float
        Motion reported over motion that was, along x, y and z.
    weight : tuple of float
        Trust in each axis.
    floor : float
        Millimetres of misfit that a perfect recording leaves.
    """

    name: str
    gain: tuple[float, float, float]
    weight: tuple[float, float, float]
    floor: float


@dataclass(frozen=True)
class Region:
    """Markers that are heard together, and the channels that may explain their motion.

    ``x`` (without sign) and ``y`` bound their places on the default face, mm; ``count`` is how many they count as.
    """

    name: str
    x: tuple[float, float]
    y: tuple[float, float]
    count: float
    hears: tuple[str, ...]


@dataclass(frozen=True)
class Opening:
    """A distance across lips or lids: pairs of landmarks (upper, lower, weight) along an axis (0: x, 1: y).

    It is shut below ``shut_mm``, or as far as the channel ``shut_by`` shuts it, or never (the width of the mouth).
    ``weight`` is what it counts beside the others; it is shut only where the opening ``shut_with`` is.
    """

    name: str
    axis: int
    pairs: tuple[tuple[int, int, float], ...]
    shut_mm: float | None
    shut_by: str | None
    weight: float
    shut_with: str | None


@dataclass(frozen=True)
class Jaw:
    """What lips tell of a jaw: ``lower`` of the lower lip's lowering less ``upper`` of the upper one's raising."""

    lower: float
    upper: float


@dataclass(frozen=True)
class Knowledge:
    """All of the table. ``rare``: by how much some channels cost more than others."""

    sources: dict[str, Source]
    channels: dict[str, tuple[str, ...]]
    regions: tuple[Region, ...]
    antagonists: tuple[tuple[str, str], ...]
    rare: dict[str, float]
    most_of_both: float
    openings: tuple[Opening, ...]
    jaw: Jaw

    def regions_at(self, places: Floats) -> NDArray[np.int64]:
        """The region of each place (markers, 3) on the default face; -1 where there is none."""
        found = np.full(len(places), -1, dtype=np.int64)
        for number in reversed(range(len(self.regions))):
            region = self.regions[number]
            x, y = np.abs(places[:, 0]), places[:, 1]
            inside = (x >= region.x[0]) & (x <= region.x[1]) & (y >= region.y[0]) & (y <= region.y[1])
            found[inside] = number
        return found


@cache
def knowledge() -> Knowledge:
    """The table that comes with mien.

    Examples
    --------
    >>> ("jawLeft", "jawRight") in knowledge().antagonists
    True
    """
    table = asset_table("capture/solver.toml")
    always = _matched(table["channels"]["always"])
    depth = _matched(table["channels"]["with_depth"])
    return Knowledge(
        sources={
            name: Source(name, tuple(entry["gain"]), tuple(entry["weight"]), float(entry["floor"]))
            for name, entry in table["source"].items()
        },
        channels={"tracker": always, "optical": tuple(n for n in ARKIT if n in always or n in depth)},
        regions=tuple(
            Region(r["name"], tuple(r["x"]), tuple(r["y"]), float(r["count"]), _matched(r["hears"]))
            for r in table["region"]
        ),
        antagonists=tuple((one, other) for one, other in table["antagonists"]["pairs"]),
        rare={name: float(price) for name, price in table["rare"].items()},
        most_of_both=float(table["antagonists"]["most"]),
        openings=tuple(
            Opening(
                o["name"],
                "xy".index(o.get("axis", "y")),
                tuple((int(a), int(b), float(w)) for a, b, w in o["pairs"]),
                o.get("shut_mm"),
                o.get("shut_by"),
                float(o.get("weight", 1.0)),
                o.get("with"),
            )
            for o in table["opening"]
        ),
        jaw=Jaw(float(table["jaw"]["lower"]), float(table["jaw"]["upper"])),
    )


def source_named(name: str) -> Source:
    """A source by its name; InputError for one that is not known."""
    if name not in SOURCES:
        raise unknown_name("source of markers", name, SOURCES)
    return knowledge().sources[name]


def _matched(patterns: Sequence[str]) -> tuple[str, ...]:
    """ARKit's channels that fit one of the patterns, in ARKit's order."""
    return tuple(name for name in ARKIT if any(fnmatchcase(name, pattern) for pattern in patterns))
