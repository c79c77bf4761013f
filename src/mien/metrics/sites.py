"""Which markers of a layout are the mouth, and which of them the lips, their middles and corners.

Read from ``assets/evaluate/mouth.toml``, so that a metric never knows a marker by its number.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from mien.capture.layouts import Layout
from mien.core.assets import asset_table
from mien.core.errors import InputError

__all__ = ["Sites", "mouth_sites"]


@dataclass(frozen=True)
class Sites:
    """Places of the mouth among the markers of a track.

    Attributes
    ----------
    mouth : tuple of int
        All mouth markers: what models learn and the RMS is taken over.
    lips : tuple of int
        Those on the lips.
    opening : tuple of (int, int)
        Middles of the upper and the lower lip.
    width : tuple of (int, int)
        Right and left corner.
    inner : bool
        Whether the opening is that of the inner lips; on the outer ones closures cannot be judged.
    """

    mouth: tuple[int, ...]
    lips: tuple[int, ...]
    opening: tuple[int, int]
    width: tuple[int, int]
    inner: bool


@cache
def _table() -> Mapping[str, Any]:
    return asset_table("evaluate/mouth.toml")


def mouth_sites(layout: Layout, names: Sequence[str]) -> Sites:
    """Find the mouth among markers.

    Parameters
    ----------
    layout : Layout
        What the names mean.
    names : sequence of str
        Markers of a track, all of the layout or some.

    Raises
    ------
    InputError
        If the middles of the lips or the corners of the mouth are not among them.
    """
    opening, inner = _pair("opening", "the middles of the upper and the lower lip", layout, names)
    width, _ = _pair("width", "the corners of the mouth", layout, names)
    members = _members(layout)
    mouth = tuple(place for place, name in enumerate(names) if name in members)
    lips = tuple(place for place in mouth if members[names[place]])
    return Sites(mouth, lips, opening, width, inner)


def _members(layout: Layout) -> dict[str, bool]:
    """Mouth markers of a layout, and whether each is on the lips."""
    table = _table()["mediapipe"]
    lips = [layout.landmarks.get(number) for number in table["outer_lips"] + table["inner_lips"]]
    chin = [layout.landmarks.get(number) for number in table["chin"]]
    if all(lips) and all(chin):
        return {str(name): place < len(lips) for place, name in enumerate(lips + chin)}
    return {name: _is_on_lips(name) for name in layout.groups["mouth"]}


def _is_on_lips(name: str) -> bool:
    table = _table()["lips"]
    return name.startswith(tuple(table["groups"])) and name not in table["chin"]


def _pair(site: str, meaning: str, layout: Layout, names: Collection[str]) -> tuple[tuple[int, int], bool]:
    """Places of a pair of markers, and whether they are the first choice or the inner lips'."""
    places = {name: place for place, name in enumerate(names)}
    choices: Mapping[str, Sequence[Any]] = _table()["sites"][site]
    for kind, pair in choices.items():
        named = [layout.landmarks.get(item, "") for item in pair] if kind == "landmark" else list(pair)
        if all(name in places for name in named):
            return (places[named[0]], places[named[1]]), kind != "outer"
    wanted = " or ".join(" and ".join(pair) for kind, pair in choices.items() if kind != "landmark")
    raise InputError(f"layout {layout.name!r} lacks {meaning}: scoring needs the markers {wanted}")
