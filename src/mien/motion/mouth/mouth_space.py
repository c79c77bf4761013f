"""What a mouth in motion is written in: the channels of the person's face, or the markers of a layout.

Speech models learn *rows*, one a frame, and give rows; a mouth space says how rows are had from a take and what they
move. Rows are such that the Euclidean distance of two is ``sqrt(points)`` times the root mean square distance in mm of
the points that they move, so that every model means the same by an error whichever space it learns in.

* `ChannelSpace`, used where a take has captured channels (`mien.capture`): what is learned is what is shown. A row is
  ``w L``, w the weights and ``L L'`` = sum over the lips' landmarks of what two channels move in common (the Gram
  matrix of the default face's displacements), so that rows lie as far apart as the lips that one sees.
* `MarkerSpace`: positions of the markers of the mouth as recorded, which is the papers' own way (Deng et al. 2006, Cao
  et al. 2005).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.errors import InputError
from mien.core.poses import read_table
from mien.corpus.take import Take

__all__ = ["ChannelSpace", "MarkerSpace", "MouthSpace", "mouth_markers", "mouth_space_of", "space_from"]

Floats = NDArray[np.float64]
Arrays = dict[str, NDArray[Any]]

LANDMARKS = "mediapipe-218"
"""Landmarks of the default face by which channels are weighed."""
LIP_EMPHASIS = 1.5
"""How much more the inner lips' motion up and down counts in learning than any other motion."""
_LEAST_MM = 0.2
"""What a channel counts besides the landmarks that it moves, mm each at full weight: none is without weight."""
_STILL = 1e-3  # a channel whose weight never leaves this range was not recorded
_NOT_LEARNED = (*channels.TONGUE, "tongueOut")
"""Mouth channels that no recording of the outside of a face shows."""


class MouthSpace(Protocol):
    """How the mouth of a take is written as rows."""

    @property
    def kind(self) -> str:
        """``channels`` or ``markers``."""

    @property
    def names(self) -> tuple[str, ...]:
        """Channels or markers."""

    @property
    def points(self) -> int:
        """Points in mm behind a row."""

    def rows_of(self, take: Take) -> Floats:
        """Rows of all frames, shape (frames, columns); NaN where something was not seen."""

    def motion_of(self, rows: Floats) -> Floats:
        """What rows move: weights (frames, channels) in 0..1, or positions (frames, markers, 3) in mm."""

    def rows_from(self, motion: Floats) -> Floats:
        """The way back from `motion_of`."""

    def differences_of(self, rows: Floats) -> Floats:
        """What differences of rows move; as `motion_of`, without bounds."""

    def opening_of(self, rows: Floats) -> Floats | None:
        """Lip opening, mm, shape (frames,); None where the middles of the lips are not known."""

    def emphasis(self) -> Floats:
        """How much each column counts in learning, shape (columns,)."""

    def rest(self) -> Floats | None:
        """The row of a mouth at rest; None where it is not known."""

    def parted(self, rows: Floats, opening_way: Floats) -> Floats:
        """Rows whose lips do not pass through each other; ``opening_way``: change of a row per mm that lips part."""

    def content(self) -> dict[str, Any]:
        """What a performer's file says of it."""

    def arrays(self) -> Arrays:
        """What a performer's file holds of it."""


class MarkerSpace:
    """Markers of the mouth, mm.

    Parameters
    ----------
    layout : str
    names : sequence of str
        Mouth markers of the layout.
    """

    kind = "markers"

    def __init__(self, layout: str, names: Sequence[str]) -> None:
        self.layout, self.names, self.points = layout, tuple(names), len(names)
        self.opening, self.facing = _lips_among(layout, self.names)

    def rows_of(self, take: Take) -> Floats:
        """Positions of the markers, shape (frames, markers * 3)."""
        missing = [name for name in self.names if name not in take.markers.names]
        if missing or len(mouth_markers(take.layout, take.markers.names)) != self.points:
            raise InputError(f"take {take.name!r} has other mouth markers than those learned: learn from one layout")
        columns = [take.markers.names.index(name) for name in self.names]
        return take.markers.positions[:, columns].reshape(len(take.markers), -1)

    def motion_of(self, rows: Floats) -> Floats:
        """Positions, shape (frames, markers, 3), mm."""
        return rows.reshape(len(rows), self.points, 3)

    def differences_of(self, rows: Floats) -> Floats:
        """Displacements, shape (frames, markers, 3), mm."""
        return self.motion_of(rows)

    def rows_from(self, motion: Floats) -> Floats:
        """Positions as rows."""
        return motion.reshape(len(motion), 3 * self.points)

    def opening_of(self, rows: Floats) -> Floats | None:
        """Distance of the middles of the lips, mm."""
        if self.opening is None:
            return None
        places = self.motion_of(rows)
        return np.asarray(np.linalg.norm(places[:, self.opening[0]] - places[:, self.opening[1]], axis=1))

    def rest(self) -> Floats | None:
        """Not known."""
        return None

    def emphasis(self) -> Floats:
        """The inner lips up and down count more."""
        found = np.ones((self.points, 3))
        found[[place for pair in (*self.facing, self.opening) if pair for place in pair], 1] = LIP_EMPHASIS
        return found.ravel()

    def parted(self, rows: Floats, opening_way: Floats) -> Floats:
        """Where a point of the inner upper lip is below the one that faces it, both meet half-way (y points up)."""
        places = self.motion_of(rows.copy())
        for upper, lower in self.facing:
            through = np.maximum(places[:, lower, 1] - places[:, upper, 1], 0.0) / 2
            places[:, upper, 1] += through
            places[:, lower, 1] -= through
        return self.rows_from(places)

    def content(self) -> dict[str, Any]:
        """What a performer's file says of it."""
        return {"kind": self.kind, "layout": self.layout, "names": self.names}

    def arrays(self) -> Arrays:
        """What a performer's file holds of it."""
        return {}


class ChannelSpace:
    """Channels of the mouth, weighed by what they move on the default face.

    Parameters
    ----------
    names : sequence of str
        Of `mien.core.channels.MOUTH`.
    root : ndarray, shape (channels, channels)
        L of the module: rows are weights times it.
    gap : ndarray, shape (1 + channels,)
        Height of the middle of the inner upper lip over the lower one at rest, mm, and what each channel adds.
    points : int
        Landmarks behind ``root``.

    Examples
    --------
    >>> space = ChannelSpace.of(("jawOpen", "mouthPucker"))
    >>> weights = np.array([[0.0, 0.0], [0.5, 0.2]])
    >>> bool(np.allclose(space.motion_of(space.rows_from(weights)), weights))
    True
    >>> bool(space.opening_of(space.rows_from(weights))[1] > 10)
    True
    """

    kind = "channels"

    def __init__(self, names: Sequence[str], root: Floats, gap: Floats, points: int) -> None:
        self.names, self.root, self.gap, self.points = tuple(names), root, gap, points
        self._back = np.linalg.inv(root)
        self._opening_of_row = self._back @ gap[1:]

    @classmethod
    def of(cls, names: Sequence[str]) -> ChannelSpace:
        """Weighed by the default face."""
        moves, gap = _on_default_face()
        rows = [channels.WEIGHTS.index(name) for name in names]
        moved = moves[rows].reshape(len(rows), -1)
        points = moves.shape[1]
        root = np.linalg.cholesky(moved @ moved.T + points * _LEAST_MM**2 * np.eye(len(rows)))
        return cls(names, root, gap[[0, *(1 + row for row in rows)]], points)

    def rows_of(self, take: Take) -> Floats:
        """Captured weights, times the root."""
        if take.channels is None:
            raise InputError(f"take {take.name!r} has no captured channels: run mien corpus upgrade on its corpus")
        rows = self.rows_from(take.channels.select(self.names).values)
        seen = take.markers.positions[: len(rows), list(mouth_markers(take.layout, take.markers.names))]
        rows[: len(seen)][~np.isfinite(seen).all(axis=(1, 2))] = np.nan  # bridged in the capture: not learned from
        return rows

    def motion_of(self, rows: Floats) -> Floats:
        """Weights in 0..1, shape (frames, channels)."""
        weights = self.differences_of(rows)
        return np.clip(weights, 0.0, 1.0, out=weights)

    def differences_of(self, rows: Floats) -> Floats:
        """Weights without bounds, shape (frames, channels)."""
        return np.asarray(rows @ self._back)

    def rows_from(self, motion: Floats) -> Floats:
        """Weights as rows."""
        return np.asarray(motion @ self.root)

    def opening_of(self, rows: Floats) -> Floats:
        """Height of the inner upper lip over the lower one on the default face, mm; below 0 where they pass."""
        return np.asarray(self.gap[0] + rows @ self._opening_of_row)

    def rest(self) -> Floats:
        """No channel moves."""
        return np.zeros(len(self.names))

    def emphasis(self) -> Floats:
        """All count alike: the root has the emphasis."""
        return np.ones(len(self.names))

    def parted(self, rows: Floats, opening_way: Floats) -> Floats:
        """Weights within 0..1, and lips that would pass through each other opened until they touch."""
        rows = self.rows_from(self.motion_of(rows))
        if not len(opening_way):
            return rows
        through = np.maximum(-self.opening_of(rows), 0.0)
        return rows + through[:, None] * opening_way

    def content(self) -> dict[str, Any]:
        """What a performer's file says of it."""
        return {"kind": self.kind, "names": self.names, "points": self.points}

    def arrays(self) -> Arrays:
        """What a performer's file holds of it."""
        return {"root": self.root, "gap": self.gap}


def space_from(content: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> MarkerSpace | ChannelSpace:
    """A space as its `content` and `arrays` have it."""
    if content["kind"] == MarkerSpace.kind:
        return MarkerSpace(content["layout"], content["names"])
    return ChannelSpace(content["names"], arrays["root"], arrays["gap"], content["points"])


def mouth_space_of(takes: Sequence[Take], learn_in: str | None = None) -> MarkerSpace | ChannelSpace:
    """The space in which takes are learned.

    Parameters
    ----------
    takes : sequence of Take
    learn_in : {"channels", "markers"} or None
        None: channels where every take has them.

    Raises
    ------
    InputError
        If there is no take, they do not share their markers, or channels are asked for and not there.
    """
    if not takes:
        raise InputError("no take to learn from")
    bare = next((take for take in takes if take.channels is None), None)
    if learn_in == "channels" and bare is not None:
        raise InputError(f"take {bare.name!r} has no captured channels: run mien corpus upgrade on its corpus")
    if learn_in != "markers" and bare is None:
        return ChannelSpace.of(_moving(takes))
    first = takes[0]
    names = first.markers.names
    other = next((take for take in takes if take.markers.names != names), None)
    if other is not None:
        raise InputError(f"take {other.name!r} has other markers than take {first.name!r}: learn from one layout")
    return MarkerSpace(first.layout, [names[place] for place in mouth_markers(first.layout, names)])


def mouth_markers(layout: str, names: Sequence[str]) -> tuple[int, ...]:
    """Places of the mouth markers of a layout among marker names, in the order of ``names``.

    Raises
    ------
    InputError
        If the layout is not known, or no name belongs to its mouth.

    Examples
    --------
    >>> mouth_markers("mediapipe-218", ("11.1", "2.2", "2.3"))
    (1, 2)
    """
    members = set(load_layout(layout).groups["mouth"])
    places = tuple(place for place, name in enumerate(names) if name in members)
    if not places:
        raise InputError(
            f"none of the {len(names)} markers belongs to the mouth of layout {layout!r}: nothing to learn"
        )
    return places


def _moving(takes: Sequence[Take]) -> tuple[str, ...]:
    """Mouth channels that move in a take or more, in the order of `mien.core.channels`."""
    moved: set[str] = set()
    for take in takes:
        if take.channels is not None:
            moved |= {
                n for n, top in zip(take.channels.names, take.channels.values.max(axis=0), strict=True) if top > _STILL
            }
    names = tuple(name for name in channels.MOUTH if name in moved and name not in _NOT_LEARNED)
    if not names:
        raise InputError(f"no channel of the mouth moves in the {len(takes)} takes: nothing to learn")
    return names


def _lips_among(layout: str, names: Sequence[str]) -> tuple[tuple[int, int] | None, tuple[tuple[int, int], ...]]:
    """Middles of the upper and lower inner lip, and points of the inner lips that face each other, among markers."""
    table = read_table("lips.toml")
    place = {name: number for number, name in enumerate(names)}
    landmarks = load_layout(layout).landmarks
    opening = next(((place[a], place[b]) for a, b in table["opening"]["choices"] if a in place and b in place), None)
    named = [(landmarks.get(a, ""), landmarks.get(b, "")) for a, b in table["facing"]["mediapipe"]]
    named += [(a, b) for a, b in table["facing"]["mpeg4"] if (a, b) not in named]
    return opening, tuple((place[a], place[b]) for a, b in named if a in place and b in place)


@cache
def _on_default_face() -> tuple[Floats, Floats]:
    """Moves of the mouth's landmarks, shape (channels, landmarks, 3), emphasised; the gap of the lips, see above."""
    from mien.face.library import load_face
    from mien.face.marker_sites import place_markers
    from mien.face.retargeting import basis_at

    face, layout = load_face("default"), load_layout(LANDMARKS)
    names = layout.groups["mouth"]
    sites = place_markers(face, layout, names).sites
    moves = basis_at(face, sites, channels.WEIGHTS)
    (upper, lower), facing = _lips_among(LANDMARKS, names)  # type: ignore[misc]  # this layout has both
    rest = [face.part(part).vertices[vertex] for part, vertex in (sites[upper], sites[lower])]
    gap = np.concatenate([[float(rest[0][1] - rest[1][1])], moves[:, upper, 1] - moves[:, lower, 1]])
    weighed = moves.copy()
    weighed[:, [place for pair in (*facing, (upper, lower)) for place in pair], 1] *= LIP_EMPHASIS
    return weighed, gap
