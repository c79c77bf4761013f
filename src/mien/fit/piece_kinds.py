"""What the loose pieces of a head are, by where they lie and what shape they have; names are not asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

__all__ = ["Piece", "kinds_of_pieces", "sphere_through"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

_EYE_NEAR_MM, _EYE_SIZES_MM, _EYE_ROUND = 14.0, (8.0, 26.0), 0.12
_SHELL = 1.2  # eyeball's radii within which shells, tear lines and caruncles lie
_LASH = 2.3  # the same of lashes
_TOOTH, _ROOT, _ROW = 0.45, 0.85, 0.62  # of the mouth's width: a single tooth's length, its height, a row's; at most
_MANY_TEETH, _SLOPES = 8, tuple(0.04 * k for k in range(-10, 11))  # height over depth
_GAP_MM = 1.5  # between the middles of upper and lower teeth, at least


@dataclass(frozen=True, eq=False)
class Piece:
    """A connected piece.

    ``kind`` is "skin", "eye_left", "eye_right", "shell" (over an eyeball), "lash", "upper", "lower", "tongue",
    "gums" (in the mouth; gums: both jaws in one piece), or "other".
    """

    kind: str
    triangles: NDArray[np.int64]  # numbers
    centre: Floats  # of an eye: its sphere's; mm
    radius: float


def kinds_of_pieces(
    points: Floats,
    triangles: Indices,
    label: NDArray[np.int64],
    eyes: Mapping[str, Floats],
    places: Mapping[str, Floats],
) -> tuple[Piece, ...]:
    """The pieces of a mesh.

    Parameters
    ----------
    points, triangles : ndarray
        The head, mm.
    label : ndarray of int64, shape (t,)
        Number of the piece of each triangle.
    eyes : mapping of "Left", "Right" to ndarray of shape (3,)
        About where the eyeballs' centres are.
    places : mapping of str to ndarray of shape (3,)
        Landmarks.
    """
    wanted = np.array([places[name] for name in places if name.startswith(("nose", "chin", "lip_corner"))])
    owner = _owner_of(points, triangles, label, wanted)  # (not the eyes' corners: lashes of their own lie there)
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    used = [points[np.unique(triangles[numbers])] for numbers in groups]
    mouth = _Mouth.of(places)
    pieces = []
    for numbers, own in zip(groups, used, strict=True):
        if int(label[numbers[0]]) in owner:
            pieces.append(Piece("skin", numbers, own.mean(0), 0.0))
        else:
            kind, centre, radius = _eye(own, eyes)
            kind = kind or (mouth.kind(own) if mouth.holds(own) else "other")
            pieces.append(Piece(kind, numbers, centre, radius))
    pieces = _with_shells(_one_centre(pieces, used), used)
    return tuple(_upper_and_lower(pieces, used, mouth))


def _owner_of(points: Floats, triangles: Indices, label: NDArray[np.int64], wanted: Floats) -> set[int]:
    """The pieces on which landmarks lie, but for those that carry a few stray ones only."""
    used, first = np.unique(triangles.ravel(), return_index=True)
    nearest = first[cKDTree(points[used]).query(wanted)[1]] // 3
    numbers, times = np.unique(label[nearest], return_counts=True)
    return {int(number) for number, count in zip(numbers, times, strict=True) if count >= 0.15 * len(wanted)}


# ------------------------------------------------------------------ eyes


def sphere_through(points: Floats) -> tuple[Floats, float, float]:
    """Centre, radius and RMS distance of a sphere by least squares."""
    middle = points.mean(0)
    arm = points - middle
    system = np.c_[2 * arm, np.ones(len(arm))]
    solution = np.linalg.lstsq(system, (arm**2).sum(1), rcond=None)[0]
    radius = float(np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 0.0)))
    left = np.linalg.norm(arm - solution[:3], axis=1) - radius
    return middle + solution[:3], radius, float(np.sqrt((left**2).mean()))


def _eye(used: Floats, eyes: Mapping[str, Floats]) -> tuple[str, Floats, float]:
    """The kind of an eyeball or a part of one ("" if it is none), its sphere's centre and radius."""
    middle = (used.max(0) + used.min(0)) / 2
    for side, place in eyes.items():
        if len(used) >= 12 and np.linalg.norm(middle - place) < _EYE_NEAR_MM:
            centre, radius, left = sphere_through(used)
            round_enough = _EYE_SIZES_MM[0] < radius < _EYE_SIZES_MM[1] and left < _EYE_ROUND * radius
            depth = np.ptp(used[:, 2]) > 0.9 * radius  # a shell over the front is none
            if round_enough and depth and np.linalg.norm(centre - place) < 1.5 * _EYE_NEAR_MM:
                return f"eye_{side.lower()}", centre, radius
    return "", used.mean(0), 0.0


def _one_centre(pieces: list[Piece], used: list[Floats]) -> list[Piece]:
    """Eyes of several pieces turn about one centre: that of the deepest piece."""
    for kind in ("eye_left", "eye_right"):
        mine = [i for i, piece in enumerate(pieces) if piece.kind == kind]
        if mine:
            main = pieces[max(mine, key=lambda i: float(np.ptp(used[i][:, 2])))]
            for i in mine:
                pieces[i] = replace(pieces[i], centre=main.centre, radius=main.radius)
    return pieces


def _with_shells(pieces: list[Piece], used: list[Floats]) -> list[Piece]:
    """What lies about an eyeball: irises and pupils inside turn with it, shells lie over it, lashes stand out."""
    balls = {piece.kind: piece for piece in pieces if piece.kind.startswith("eye_")}
    for i, piece in enumerate(pieces):
        if piece.kind != "other":
            continue
        for kind, ball in balls.items():
            away = np.linalg.norm(used[i] - ball.centre, axis=1) / ball.radius
            if away.max() < _SHELL:
                wide = np.ptp(used[i][:, :2], axis=0).max()
                off = np.linalg.norm(used[i].mean(0)[:2] - ball.centre[:2])
                inside = away.max() < 1.1 and wide < 1.5 * ball.radius and off < 0.3 * ball.radius  # an iris
                pieces[i] = replace(piece, kind=kind if inside else "shell", centre=ball.centre, radius=ball.radius)
            elif away.max() < _LASH and away.min() > 0.75 and used[i][:, 2].min() > ball.centre[2] - 0.3 * ball.radius:
                pieces[i] = replace(piece, kind="lash")
    return pieces


# ------------------------------------------------------------------ mouth


@dataclass(frozen=True, eq=False)
class _Mouth:
    """The middle between the mouth's corners, its usual width, and how far forward the lips reach; mm."""

    middle: Floats
    width: float
    front: float

    @classmethod
    def of(cls, places: Mapping[str, Floats]) -> _Mouth:
        one, other = places["lip_corner_left"], places["lip_corner_right"]
        eyes = places["eye_outer_left"] - places["eye_outer_right"]
        middle, width = (one + other) / 2, max(float(np.linalg.norm(one - other)), 0.5 * float(np.linalg.norm(eyes)))
        lips = [place[2] for name, place in places.items() if name in ("lip_upper_outer", "lip_lower_outer")]
        return cls(middle, width, max([*lips, middle[2] + 0.3 * width]))

    def holds(self, used: Floats) -> bool:
        """Whether a piece lies behind the lips, in the mouth."""
        arm = (used - self.middle) / self.width
        inside = (np.abs(arm[:, 0]) < 0.9) & (np.abs(arm[:, 1]) < 0.85) & (arm[:, 2] > -2.4)
        return bool((inside & (used[:, 2] < self.front)).mean() > 0.95)

    def kind(self, used: Floats) -> str:
        """What is told of a piece here: "tooth" (upper or lower is seen later), "tongue" or "gums"."""
        long, high, deep = np.ptp(used, axis=0) / self.width
        if max(long, deep) < _TOOTH and high < _ROOT:  # a tooth may have its root
            return "tooth"
        arm = (used - (used.max(0) + used.min(0)) / 2) / self.width
        filled = float(((np.abs(arm[:, 0]) < 0.12) & (arm[:, 2] < 0.1)).mean()) > 0.05  # no horseshoe
        low = used[:, 1].mean() < self.middle[1]
        if filled and low and long < 0.95 and deep > 0.5 and high < 0.85:
            return "tongue"
        return "tooth" if high < _ROW else "gums"


def _upper_and_lower(pieces: list[Piece], used: list[Floats], mouth: _Mouth) -> list[Piece]:
    """Teeth, single or in rows, by a gap in height between their middles; rows of a head that nods slope."""
    teeth = [i for i, piece in enumerate(pieces) if piece.kind == "tooth"]
    if not teeth:
        return pieces
    middle = np.array([(used[i].max(0) + used[i].min(0)) / 2 for i in teeth]) - mouth.middle
    slopes = _SLOPES if len(teeth) >= _MANY_TEETH else (0.0,)
    found = [_border(middle[:, 1] - slope * middle[:, 2], mouth.width) for slope in slopes]
    best = max(range(len(slopes)), key=lambda each: (round(found[each][0], 3), -abs(slopes[each])))
    height, border = middle[:, 1] - slopes[best] * middle[:, 2], found[best][1]
    for i, own in zip(teeth, height, strict=True):
        pieces[i] = replace(pieces[i], kind="upper" if own > border else "lower")
    return pieces


def _border(height: Floats, width: float) -> tuple[float, float]:
    """Share of the heights' variance that lies between two rows (Otsu 1979), and the height between these."""
    order = np.sort(height)
    below = np.arange(1, len(order))
    total = np.cumsum(order)[:-1]
    apart = (order.sum() - total) / (len(order) - below) - total / below  # of the means above and below each gap
    near = np.maximum(1 - np.abs((order[1:] + order[:-1]) / 2) / (0.35 * width), 0)
    score = below * (len(order) - below) * apart**2 * near * (np.diff(order) > _GAP_MM)
    if not score.max(initial=0.0) > 0:
        return 0.0, 0.0
    widest = int(np.argmax(score))
    share = float(score[widest] / near[widest] / (len(order) ** 2 * max(order.var(), 1e-9)))
    return share, float(order[widest] + order[widest + 1]) / 2
