"""Named places on the skin, for markers and measurements."""

from __future__ import annotations

import numpy as np
from contact import Edges, split_loop
from eyelids import lid_loops
from head import Head
from makehuman import Floats, Ints

_PAIRS = 3  # inner-lip pairs on each side of the middle


def _nearest(points: Floats, wanted: Floats, among: Ints) -> int:
    return int(among[np.argmin(np.linalg.norm(points[among] - wanted, axis=1))])


def find_sites(head: Head, lips: Edges) -> dict[str, tuple[str, int]]:
    """Sites by name, as (part, vertex)."""
    found = {**_lip_sites(head, lips), **_eye_sites(head), **_profile_sites(head)}
    return {name: ("skin", int(vertex)) for name, vertex in sorted(found.items())}


def _at_x(points: Floats, row: Ints, x: float) -> int:
    return int(row[np.argmin(np.abs(points[row][:, 0] - x))])


def _lip_sites(head: Head, lips: Edges) -> dict[str, int]:
    """Corners, red borders, and where the lips meet: the lowest of the upper and the highest of the lower lip."""
    points = head.skin.vertices
    _, _, (left, right) = split_loop(points, head.lip_loop)
    upper, lower = (np.unique(lips.triangles[side]) for side in (lips.upper, lips.lower))
    upper, lower = upper[lips.upper_pull[upper] > 0.3], lower[lips.lower_pull[lower] > 0.3]
    sites = {"lip_corner_left": left, "lip_corner_right": right}
    reach = points[left, 0]
    for step in range(_PAIRS + 1):
        for side, sign in (("l", 1), ("r", -1)) if step else (("", 1),):
            x = sign * reach * step / (_PAIRS + 1)
            name = f"_{side}{step}" if step else ""
            sites["lip_lower_inner" + name] = below = _edge_near(points, lower, x, 1.0)
            sites["lip_upper_inner" + name] = _edge_near(points, upper, points[below, 0], -1.0)
    middle = np.flatnonzero(np.abs(points[:, 0]) < 0.05)
    red = middle[(head.masks["lips"][middle] > 0.5) & (points[middle, 2] > points[sites["lip_upper_inner"], 2])]
    sites["lip_upper_outer"] = int(red[np.argmax(points[red, 1])])
    sites["lip_lower_outer"] = int(red[np.argmin(points[red, 1])])
    return sites


def _edge_near(points: Floats, row: Ints, x: float, up: float) -> int:
    """The vertex at the edge of a lip near x: how far it stands out counts, less half the distance from x."""
    return int(row[np.argmax(up * points[row][:, 1] - 0.8 * np.abs(points[row][:, 0] - x))])


def _eye_sites(head: Head) -> dict[str, int]:
    points = head.skin.vertices
    sites: dict[str, int] = {}
    for side, sign, loop, centre in zip(("left", "right"), (1, -1), lid_loops(head), head.eye_centres, strict=True):
        upper, lower, corners = split_loop(points, loop)
        outer, inner = corners if sign > 0 else corners[::-1]
        sites |= {f"eye_outer_{side}": outer, f"eye_inner_{side}": inner}
        sites[f"lid_upper_{side}"] = _at_x(points, upper, centre[0])
        sites[f"lid_lower_{side}"] = _at_x(points, lower, centre[0])
        front = np.flatnonzero(points[:, 2] > centre[2])
        for name, x, y in (("inner", 13.0, 16.5), ("middle", 31.0, 22.0), ("outer", 46.0, 18.0)):
            sites[f"brow_{name}_{side}"] = int(
                front[np.argmin(np.hypot(points[front, 0] - sign * x, points[front, 1] - y))]
            )
    return sites


def _profile_sites(head: Head) -> dict[str, int]:
    points = head.skin.vertices
    middle = np.flatnonzero((np.abs(points[:, 0]) < 0.05) & (points[:, 2] > 0) & (head.masks["inside-mouth"] < 0.1))
    nose = middle[(points[middle, 1] < -15) & (points[middle, 1] > -55)]
    mouth = points[head.lip_loop][:, 1].mean()
    chin = middle[(points[middle, 1] < mouth - 20) & (points[middle, 1] > mouth - 45)]
    cheeks = {
        f"cheek_{side}": _nearest(points, np.array([sign * 42.0, -38.0, 5.0]), np.arange(len(points)))
        for side, sign in (("left", 1), ("right", -1))
    }
    return {
        "nose_tip": int(nose[np.argmax(points[nose, 2])]),
        "chin": int(chin[np.argmax(points[chin, 2])]),
        **cheeks,
    }
