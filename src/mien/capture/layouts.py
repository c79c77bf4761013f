"""`Layout`: a named set of markers, the group of each, and its place on the default face.

Layouts are data: ``assets/markers/NAME.toml``, written by ``tools/place_markers.py``. Names are those of the MPEG-4
feature points (ISO/IEC 14496-2, annex C: 8.3 is the left corner of the outer lip) where one exists; left is the
speaker's own.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.groups import MarkerGroups
from mien.core.assets import asset, assets_in
from mien.core.border import reading
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import read_plain_text

__all__ = ["GROUPS", "Layout", "find_layout", "known_layouts", "load_layout"]

GROUPS = ("mouth", "upper", "lower")
"""Motion groups: lips and chin; brows, lids, forehead and nose; cheeks and jaw."""


@dataclass(frozen=True, eq=False)
class Layout:
    """A set of markers.

    Attributes
    ----------
    name : str
    about : str
        One line: what the set is.
    markers : tuple of str
        In the order in which a corpus keeps them.
    groups : mapping of str to tuple of str
        Markers of each of `GROUPS`; every marker is in one.
    rigid : tuple of str
        Markers that move with the skull and hardly otherwise: the head's motion is fitted to them.
    places : ndarray, shape (markers, 3)
        Where each marker sits on the default face at rest: millimetres, in the axes of `mien.face.model`.
    landmarks : mapping of int to str
        Marker by its number in MediaPipe's face mesh, where it has one.
    scale : tuple of (str, str, float), or None
        Two markers and their distance in mm, for recordings that do not know their own scale.
    """

    name: str
    about: str
    markers: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]]
    rigid: tuple[str, ...]
    places: NDArray[np.float64]
    landmarks: Mapping[int, str] = field(default_factory=dict)
    scale: tuple[str, str, float] | None = None

    def place(self, marker: str) -> NDArray[np.float64]:
        """Where a marker sits on the default face, mm, shape (3,)."""
        return np.asarray(self.places[self.index([marker])[0]])

    def index(self, markers: Collection[str]) -> list[int]:
        """Numbers of the named markers."""
        position = {name: number for number, name in enumerate(self.markers)}
        for marker in markers:
            if marker not in position:
                raise unknown_name(f"marker in layout {self.name}", marker, self.markers)
        return [position[marker] for marker in markers]

    def motion_groups(self) -> MarkerGroups:
        """The groups as the cleaning steps take them."""
        inner = "2.2" in self.markers and "2.3" in self.markers
        return MarkerGroups(
            rigid=self.rigid,
            upper_face=self.groups["upper"],
            mouth=self.groups["mouth"],
            nose="9.3",
            left_eye="3.7",
            right_eye="3.12",
            upper_lip="2.2" if inner else "8.1",
            lower_lip="2.3" if inner else "8.2",
        )


def known_layouts() -> tuple[str, ...]:
    """Names of the layouts that come with mien.

    Examples
    --------
    >>> known_layouts()
    ('expression-109', 'face-102', 'mediapipe-218', 'mpeg4-32')
    """
    return tuple(assets_in("markers"))


@cache
def load_layout(name: str) -> Layout:
    """Read a layout by its name, or from a file of your own.

    Parameters
    ----------
    name : str
        One of `known_layouts`, or the path of a ``.toml`` file.

    Raises
    ------
    InputError
        If the name is not known, or the file is missing or damaged.

    Examples
    --------
    >>> layout = load_layout("mediapipe-218")
    >>> len(layout.markers), layout.landmarks[61], layout.scale
    (218, '8.4', ('3.12', '3.7', 90.0))
    """
    if name.endswith(".toml"):
        path = Path(name)
    elif name in known_layouts():
        path = asset(f"markers/{name}.toml")
    else:
        raise unknown_name("marker layout", name, known_layouts())
    with reading(path, "a marker layout"):
        return _parsed(path, tomllib.loads(read_plain_text(path, "a marker layout")[0]))


def _parsed(path: Path, content: Mapping[str, Any]) -> Layout:
    try:
        table: Mapping[str, Mapping[str, Any]] = content["markers"]
        markers = tuple(table)
        groups = {group: tuple(m for m in markers if table[m]["group"] == group) for group in GROUPS}
        layout = Layout(
            name=str(content["name"]),
            about=str(content["about"]),
            markers=markers,
            groups=groups,
            rigid=tuple(m for m in markers if table[m].get("rigid", False)),
            places=np.array([table[m]["place"] for m in markers], dtype=np.float64),
            landmarks={int(table[m]["landmark"]): m for m in markers if "landmark" in table[m]},
            scale=_scale(content.get("scale")),
        )
    except (KeyError, TypeError, ValueError) as problem:
        raise InputError(
            f"{path}: expected name, about and [markers] with group and place each ({problem})"
        ) from problem
    ungrouped = [m for m in markers if not any(m in members for members in groups.values())]
    if ungrouped or layout.places.shape != (len(markers), 3) or len(layout.rigid) < 3:
        raise InputError(
            f"{path}: every marker needs a group of {', '.join(GROUPS)} and a place of three numbers, and three "
            f"markers or more must be rigid (no group: {', '.join(ungrouped) or 'none'}; rigid: {len(layout.rigid)})"
        )
    return layout


def _scale(entry: Mapping[str, Any] | None) -> tuple[str, str, float] | None:
    if entry is None:
        return None
    first, second = entry["between"]
    return str(first), str(second), float(entry["mm"])


def find_layout(names: Collection[str], source: str = "the recording") -> Layout:
    """The smallest known layout that has every one of these markers.

    Raises
    ------
    InputError
        If there is none; the message names markers that the nearest layout lacks.

    Examples
    --------
    >>> find_layout(["8.3", "8.4", "9.3"]).name
    'mpeg4-32'
    """
    layouts = sorted((load_layout(name) for name in known_layouts()), key=lambda layout: len(layout.markers))
    best, strangers = layouts[0], sorted(names)
    for layout in layouts:
        missing = sorted(set(names) - set(layout.markers))
        if not missing and names:
            return layout
        if len(missing) < len(strangers):
            best, strangers = layout, missing
    raise InputError(
        f"{source}: its {len(names)} markers are those of no known layout ({best.name} lacks {len(strangers)} of them, "
        f"such as {', '.join(strangers[:3])}); name the layout, and [rename] the markers, in a recipe"
    )
