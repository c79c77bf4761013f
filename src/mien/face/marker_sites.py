"""Where markers sit on a face: any face, not only the one on which a layout's places were measured.

In order of trust:

1. *given*: a face whose ``sites`` hold ``marker:NAME`` says itself where a marker is;
2. *the same mesh*: a face with the default face's triangles (a likeness, another character from the same base mesh)
   has its markers on the same vertices;
3. *transferred*: the layout's places are bent onto the face by a smooth map (`warp_between`) through points that both
   faces have: named sites, eyeballs' centres, and for every channel that both know the middle of what it moves (the
   corner of the mouth is where mouthSmile pulls), then put on the nearest vertex of the skin.

Lips touch at rest, and the vertex nearest to a marker of the upper lip may belong to the lower one: which lip a vertex
is on is told by the distance along the skin (``[lips]`` in ``assets/regions``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset, asset_table
from mien.core.channels import ARKIT
from mien.core.derived import read_derived
from mien.core.errors import InputError
from mien.face.model import Face, Part

__all__ = [
    "DERIVED", "GIVEN", "MarkerPlaces", "Placed", "SkinDistances", "derived_sites", "load_marker_places",
    "place_markers", "skin_of", "sources", "warp_between",
]  # fmt: skip

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Site = tuple[str, int]

DERIVED = "marker_sites"
GIVEN = "marker:"
"""Prefix of a face's own sites of markers."""
_IRISES = {"Right": range(468, 473), "Left": range(473, 478)}  # MediaPipe's landmarks on the eyeballs
_SAME_PLACE = 0.05  # mm: sites of the face that are no farther off than this say that it is the default face
_FEWEST = 6  # points that carry a smooth map
_LEAST_MOTION = 0.3  # mm: a channel that moves less tells no place
_SHARPNESS = 4  # power of the motion that weighs where a channel acts: the strongest motion tells the place best
_SMOOTHING = 0.1
_MOST_UNLIKE = 0.4  # of the points' spread: what a similarity may leave between two faces
_FARTHEST = 25.0  # mm in the default face's size: a place that lands farther off the skin found no skin


class MarkerPlaces(Protocol):
    """What is asked of a layout, which `mien.capture.layouts.Layout` has."""

    @property
    def name(self) -> str:
        """What to call it in messages."""
        ...

    @property
    def markers(self) -> tuple[str, ...]:
        """Names."""
        ...

    @property
    def places(self) -> Floats:
        """Millimetres on the default face, shape (markers, 3)."""
        ...

    @property
    def landmarks(self) -> Mapping[int, str]:
        """Marker by its number in MediaPipe's face mesh."""
        ...


@dataclass(frozen=True, eq=False)
class _Places:
    name: str
    markers: tuple[str, ...]
    places: Floats
    landmarks: Mapping[int, str]


@dataclass(frozen=True, eq=False)
class Placed:
    """Markers on a face.

    Attributes
    ----------
    names : tuple of str
    sites : tuple of (part name, vertex index)
    places : ndarray, shape (markers, 3)
        Where they were wanted, mm on this face; a site is the vertex nearest to it.
    how : {"given", "same mesh", "transferred"}
    scale : float
        Size of this face against the default one.
    """

    names: tuple[str, ...]
    sites: tuple[Site, ...]
    places: Floats
    how: str
    scale: float


def load_marker_places(layout: str) -> MarkerPlaces:
    """Places of a layout that comes with mien, without the rest of it (`mien.capture.layouts` knows groups too).

    Examples
    --------
    >>> len(load_marker_places("mpeg4-32").markers)
    32
    """
    table: Mapping[str, Any] = _asset("markers", f"{layout}.toml")["markers"]
    places = np.array([entry["place"] for entry in table.values()], dtype=np.float64)
    landmarks = {int(entry["landmark"]): name for name, entry in table.items() if "landmark" in entry}
    return _Places(layout, tuple(table), places, landmarks)


def _asset(folder: str, name: str) -> dict[str, Any]:
    return asset_table(f"{folder}/{name}")


@cache
def _default() -> Face:
    from mien.face.library import load_face

    return load_face("default")


def skin_of(face: Face) -> Part:
    """The part that is the skin: the one of that name, else the one that most channels move.

    Raises
    ------
    InputError
        If no part has morph targets.
    """
    named = next((part for part in face.parts if part.name == "skin"), None)
    if named is not None:
        return named
    moved = max(face.parts, key=lambda part: len(set(part.targets) & set(ARKIT)), default=None)
    if moved is None or not moved.targets:
        raise InputError(f"face {face.name!r} has no part 'skin' and no morph targets: markers have nothing to sit on")
    return moved


def place_markers(face: Face, layout: MarkerPlaces, names: Sequence[str] | None = None) -> Placed:
    """Put a layout's markers on a face.

    Parameters
    ----------
    face : Face
    layout : MarkerPlaces
    names : sequence of str, optional
        Which markers, in this order; None takes all.

    Raises
    ------
    InputError
        If the face gives no hold: neither sites, nor the default face's mesh, nor channels that it knows.

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> placed = place_markers(load_face(), load_marker_places("mpeg4-32"))
    >>> placed.how, placed.sites[placed.names.index("8.3")][0]
    ('same mesh', 'skin')
    """
    wanted = list(layout.markers if names is None else names)
    rows = [layout.markers.index(name) for name in wanted]
    if all(GIVEN + name in face.sites for name in wanted):
        sites = tuple(face.sites[GIVEN + name] for name in wanted)
        return Placed(tuple(wanted), sites, _positions(face, sites), "given", _scale_of(face))
    default = _default()
    if _same_mesh(face, default):
        sites = _on_default(default, layout)
        chosen = tuple(sites[row] for row in rows)
        ahead = _positions(face, chosen) - _positions(default, chosen)
        return Placed(tuple(wanted), chosen, layout.places[rows] + ahead, "same mesh", _scale_of(face))
    warp, scale = warp_between(default, face)
    places = warp(layout.places)
    sites = _on_skin(face, layout, places, scale)
    given = {name: face.sites[GIVEN + name] for name in wanted if GIVEN + name in face.sites}
    chosen = tuple(given.get(name, sites[row]) for name, row in zip(wanted, rows, strict=True))
    return Placed(tuple(wanted), chosen, places[rows], "transferred", scale)


def _on_default(default: Face, layout: MarkerPlaces) -> tuple[Site, ...]:
    """Where a layout's markers are on the default face: as it was worked out, for a layout that comes with mien."""
    kept = read_derived(DERIVED, sources()) or {}
    places, found = kept.get(f"{layout.name}/places"), kept.get(f"{layout.name}/sites")
    if places is None or found is None or not np.array_equal(places, layout.places):
        return _on_skin(default, layout, layout.places)
    return tuple((default.parts[part].name, vertex) for part, vertex in found.tolist())


def sources() -> tuple[str, ...]:
    """Files of ``assets`` that the markers' vertices on the default face are worked out from."""
    layouts = sorted(entry.name for entry in asset("markers").iterdir())
    return ("faces/default.npz", "regions/mediapipe-218.toml", *(f"markers/{name}" for name in layouts))


def derived_sites() -> dict[str, NDArray[Any]]:
    """Part and vertex of each marker of the layouts that come with mien, on the default face (`mien.core.derived`)."""
    default, found = _default(), dict[str, NDArray[Any]]()
    numbers = {part.name: number for number, part in enumerate(default.parts)}
    for source in sources()[2:]:
        layout = load_marker_places(source.removeprefix("markers/").removesuffix(".toml"))
        sites = _on_skin(default, layout, layout.places)
        found[f"{layout.name}/places"] = layout.places
        found[f"{layout.name}/sites"] = np.array([(numbers[part], vertex) for part, vertex in sites], dtype=np.int64)
    return found


def _same_mesh(face: Face, default: Face) -> bool:
    skin, known = next((p for p in face.parts if p.name == "skin"), None), default.part("skin")
    return skin is not None and len(skin.vertices) == len(known.vertices) and _equal(skin.triangles, known.triangles)


def _equal(one: NDArray[np.int32], other: NDArray[np.int32]) -> bool:
    return one.shape == other.shape and bool(np.array_equal(one, other))


def _positions(face: Face, sites: Sequence[Site]) -> Floats:
    return np.array([face.part(part).vertices[vertex] for part, vertex in sites], dtype=np.float64).reshape(-1, 3)


def _scale_of(face: Face) -> float:
    """Distance of the eyes against the default face's; 1 where there are no two eyes."""
    found = []
    for each in (face, _default()):
        centres = {eye.side: np.array(eye.centre) for eye in each.eyes}
        found.append(float(np.linalg.norm(centres["Left"] - centres["Right"])) if len(centres) == 2 else 0.0)
    return found[0] / found[1] if all(found) else 1.0


# ------------------------------------------------------------ from one face to another


def warp_between(source: Face, goal: Face) -> tuple[Any, float]:
    """A smooth map of space that takes one face to the other, and how many times larger the other one is.

    Biharmonic in three dimensions with an affine part (``phi(r) = r``), lightly smoothed, through `_shared_points`.

    Raises
    ------
    InputError
        If the faces share fewer than `_FEWEST` points.
    """
    from scipy.interpolate import RBFInterpolator

    here, there = _shared_points(source, goal)
    if len(here) < _FEWEST:
        raise InputError(
            f"face {goal.name!r}: {len(here)} points are known on it (named sites, eyes, what channels move), "
            f"{_FEWEST} or more are needed to put markers on it; give sites 'marker:NAME' in its file"
        )
    _check_alike(here, there, goal)
    spread = float(np.linalg.norm(here - here.mean(axis=0)))
    scale = float(np.linalg.norm(there - there.mean(axis=0))) / max(spread, 1e-9)
    smoothing = _SMOOTHING * spread / np.sqrt(len(here))
    return RBFInterpolator(here, there, kernel="linear", degree=1, smoothing=smoothing), scale


def _check_alike(here: Floats, there: Floats, goal: Face) -> None:
    """Refuse points that no turned and scaled face could have: channels that do not act where their names say."""
    one, other = here - here.mean(axis=0), there - there.mean(axis=0)
    u, sizes, vt = np.linalg.svd(one.T @ other)
    sign = np.array([1, 1, np.linalg.det(u @ vt)])
    laid = one @ (u * sign) @ vt * ((sizes * sign).sum() / max(float((one**2).sum()), 1e-9))
    missed = float(np.sqrt(((laid - other) ** 2).sum() / max(float((other**2).sum()), 1e-9)))
    if missed > _MOST_UNLIKE:
        raise InputError(
            f"face {goal.name!r}: what its channels move lies elsewhere than on a face "
            f"({100 * missed:.0f} % off, {100 * _MOST_UNLIKE:.0f} % at most); give sites 'marker:NAME' in its file"
        )


def _shared_points(source: Face, goal: Face) -> tuple[Floats, Floats]:
    sites = [name for name in source.sites if name in goal.sites]
    here = [*_positions(source, [source.sites[name] for name in sites])]
    there = [*_positions(goal, [goal.sites[name] for name in sites])]
    eyes = {eye.side: eye.centre for eye in goal.eyes}
    for eye in source.eyes:
        if eye.side in eyes:
            here.append(np.array(eye.centre))
            there.append(np.array(eyes[eye.side]))
    acting, acting_there = _acting_places(source), _acting_places(goal)
    for name in acting:
        if name in acting_there:
            here.append(acting[name])
            there.append(acting_there[name])
    return np.array(here).reshape(-1, 3), np.array(there).reshape(-1, 3)


def _acting_places(face: Face) -> dict[str, Floats]:
    """For every ARKit channel that moves the skin, the middle of what it moves, mm."""
    skin, found = skin_of(face), {}
    area = _vertex_areas(skin)
    for name, target in skin.targets.items():
        moved = np.linalg.norm(target.offsets.astype(np.float64), axis=1)
        if name in ARKIT and moved.max(initial=0.0) > _LEAST_MOTION:
            weight = area[target.vertices] * (moved / moved.max()) ** _SHARPNESS
            if weight.sum() > 0:
                found[name] = np.asarray(weight @ skin.vertices[target.vertices] / weight.sum(), dtype=np.float64)
    return found


def _vertex_areas(part: Part) -> Floats:
    corner = part.vertices.astype(np.float64)[part.triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 6
    total = np.zeros(len(part.vertices))
    for column in range(3):
        np.add.at(total, part.triangles[:, column], area)
    return total


# ------------------------------------------------------------ from places to vertices


def _on_skin(face: Face, layout: MarkerPlaces, places: Floats, scale: float = 1.0) -> tuple[Site, ...]:
    """The vertex nearest to each place, on the eyeballs for irises, on its own lip for lips."""
    from scipy.spatial import cKDTree

    skin = skin_of(face)
    away, vertices = cKDTree(skin.vertices).query(places)
    row = {number: layout.markers.index(name) for number, name in layout.landmarks.items()}
    sites: list[Site] = [(skin.name, int(vertex)) for vertex in vertices]
    balls = {eye.side: face.part(eye.part) for eye in face.eyes}
    for side, landmarks in _IRISES.items():
        for number in landmarks:
            if number in row:
                away[row[number]] = 0.0
                if side in balls:
                    ball = balls[side]
                    sites[row[number]] = (ball.name, int(cKDTree(ball.vertices).query(places[row[number]])[1]))
    off = [name for name, distance in zip(layout.markers, away, strict=True) if distance > _FARTHEST * scale]
    if off:
        raise InputError(
            f"face {face.name!r}: the places of {len(off)} markers ({', '.join(off[:3])}...) lie off its skin; "
            "give sites 'marker:NAME' in its file"
        )
    for number, vertex in _own_lips(skin, places, vertices, row).items():
        sites[number] = (skin.name, vertex)
    return tuple(sites)


def _own_lips(skin: Part, places: Floats, vertices: Ints, row: Mapping[int, int]) -> dict[int, int]:
    """For each marker of a lip the nearest vertex of that lip."""
    lips = _asset("regions", "mediapipe-218.toml")["lips"]
    sure = {lip: [vertices[row[mark]] for mark in facts["sure"] if mark in row] for lip, facts in lips.items()}
    if not all(sure.values()):
        return {}
    distances = SkinDistances(skin)
    distance = {lip: distances.to_nearest(np.array(seeds, dtype=np.int64)) for lip, seeds in sure.items()}
    found = {}
    for lip, other in (("upper", "lower"), ("lower", "upper")):
        own = np.flatnonzero(distance[lip] < distance[other])
        for mark in lips[lip]["all"]:
            if mark in row and len(own):
                away = np.linalg.norm(skin.vertices[own] - places[row[mark]], axis=1)
                found[row[mark]] = int(own[np.argmin(away)])
    return found


class SkinDistances:
    """Distances along the edges of a part, mm; seams of the texture are closed.

    Parameters
    ----------
    part : Part
    """

    def __init__(self, part: Part) -> None:
        from scipy.sparse import csr_matrix

        from mien.face.posing import welded_vertices

        self._welded = welded_vertices(part)
        sides = np.vstack([self._welded[part.triangles[:, [k, (k + 1) % 3]]] for k in range(3)])
        sides = np.unique(np.sort(sides, axis=1), axis=0)
        sides = sides[sides[:, 0] != sides[:, 1]]
        length = np.linalg.norm(part.vertices[sides[:, 0]] - part.vertices[sides[:, 1]], axis=1) + 1e-9
        n = len(part.vertices)
        self._graph = csr_matrix((length, (sides[:, 0], sides[:, 1])), (n, n))

    def to_nearest(self, seeds: Ints) -> Floats:
        """From the nearest seed, shape (vertices,); infinite where no edge leads."""
        from scipy.sparse.csgraph import dijkstra

        found = dijkstra(self._graph, directed=False, indices=np.unique(self._welded[seeds]), min_only=True)
        return np.asarray(found[self._welded], dtype=np.float64)
