"""Markers spread over a face by scattered-data interpolation in blended regions (Cao et al. 2005).

Every marker sits on a vertex of the skin. Its displacement from rest is a sample of the face's motion; between samples
the motion is interpolated with radial basis functions, within each region on its own::

    d_r(x) = sum_m c_rm phi(|x - x_m|) + b_r,       phi(r) = -sqrt(r^2 + c^2),  sum_m c_rm = 0
    d(x) = sum_r a_r(x) d_r(x),                     sum_r a_r(x) = 1

Regions are the lower jaw, the upper jaw, each of the four eyelids and the upper face (``assets/regions``).
The shares ``a_r`` follow the distance *along the skin* to the region's markers, so that they fade into each other over
the cheeks and at the corners but not across the gap between the lips or the lids: those part freely. A region does not
hear the markers on the other side of such a gap. Points of the skin far from all markers hold still.

All of it is linear in the displacements: one matrix (vertices x markers) does it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.assets import asset_table
from mien.core.errors import InputError
from mien.face.marker_sites import SkinDistances, load_marker_places, place_markers, skin_of
from mien.face.model import Face, Part, Target

__all__ = ["MarkerSites", "RegionDeformer", "face_by_regions", "interpolation_matrix", "sites_of_layout"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SOFTNESS = 8.0
"""mm, ``c`` of the basis function: rounds it off at the markers, so that a marker pulls no spike."""
_ANCHORS = 48  # resting points among the skin that no marker reaches
_SMALLEST = 5e-3  # mm
_IRISES = range(468, 478)  # landmarks on the eyeballs, which turn rigidly
# Parts that lie on the skin and go with it.
_ON_SKIN = ("brows", "lashes", "caruncles")


@dataclass(frozen=True)
class MarkerSites:
    """Where markers sit on a face.

    Attributes
    ----------
    names : tuple of str
    part : str
        The skin.
    vertices : ndarray of int, shape (markers,)
    regions : mapping of str to tuple of int
        Numbers of the markers in each region.
    without : mapping of str to tuple of str
        Regions whose own markers a region does not hear.
    borders : mapping of str to float
        Over how many mm along the skin each region ends.
    reach : tuple of 2 float
        Along the skin from the nearest marker: full effect, none; mm.
    """

    names: tuple[str, ...]
    part: str
    vertices: Ints
    regions: Mapping[str, tuple[int, ...]]
    without: Mapping[str, tuple[str, ...]]
    borders: Mapping[str, float]
    reach: tuple[float, float]

    def only(self, names: Collection[str]) -> MarkerSites:
        """The same sites, without the markers that are not named."""
        kept = [number for number, name in enumerate(self.names) if name in names]
        place = {old: new for new, old in enumerate(kept)}
        regions = {r: tuple(place[m] for m in members if m in place) for r, members in self.regions.items()}
        return replace(self, names=tuple(self.names[k] for k in kept), vertices=self.vertices[kept], regions=regions)


def _asset(folder: str, name: str) -> dict[str, Any]:
    return asset_table(f"{folder}/{name}")


def sites_of_layout(face: Face, layout: str = "mediapipe-218") -> MarkerSites:
    """The sites of a layout's markers on a face (`mien.face.marker_sites` says how they are found), by region.

    Raises
    ------
    InputError
        If the markers cannot be put on the face.
    """
    table, chart = _asset("markers", f"{layout}.toml")["markers"], _asset("regions", "mediapipe-218.toml")
    names = [name for name, entry in table.items() if entry["landmark"] not in _IRISES]
    placed, entries = place_markers(face, load_marker_places(layout), names), [table[name] for name in names]
    skin = skin_of(face).name
    homeless = [name for name, (part, _) in zip(names, placed.sites, strict=True) if part != skin]
    if homeless:
        raise InputError(f"face {face.name!r}: markers {', '.join(homeless[:3])} do not sit on part {skin!r}")
    low, high = chart["reach"]
    return MarkerSites(
        tuple(names),
        skin,
        np.array([vertex for _, vertex in placed.sites], dtype=np.int64),
        {name: _members(name, entries, chart) for name in chart["region"]},
        {name: tuple(facts["without"]) for name, facts in chart["region"].items()},
        {name: float(facts["border"]) * placed.scale for name, facts in chart["region"].items()},
        (float(low) * placed.scale, float(high) * placed.scale),
    )


def _members(region: str, entries: Sequence[Mapping[str, Any]], chart: Mapping[str, Any]) -> tuple[int, ...]:
    named = {number for facts in chart["region"].values() for number in facts["markers"]}
    own = set(chart["region"][region]["markers"])

    def home(entry: Mapping[str, Any]) -> str:
        height = entry["place"][1]
        if height > chart["upper_face_from"]:
            return "upper_face"
        return "lower_jaw" if entry["group"] == "lower" and height < chart["lower_jaw_below"] else "upper_jaw"

    return tuple(
        number
        for number, entry in enumerate(entries)
        if entry["landmark"] in own or (entry["landmark"] not in named and home(entry) == region)
    )


def interpolation_matrix(centres: ArrayLike, points: ArrayLike, softness: float = SOFTNESS) -> Floats:
    """Matrix that takes values at centres (m, 3) to interpolated values at points (n, 3), shape (n, m).

    Multiquadrics with a constant (Hardy 1971): exact at the centres, and a field that is the same everywhere stays so.

    Examples
    --------
    >>> centres = np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0]])
    >>> (interpolation_matrix(centres, centres) @ [1.0, 2.0, 3.0]).round(9).tolist()
    [1.0, 2.0, 3.0]
    """
    known, wanted = np.asarray(centres, dtype=np.float64), np.asarray(points, dtype=np.float64)
    reach = np.hstack([_basis(wanted, known, softness), np.ones((len(wanted), 1))])
    return np.asarray(reach @ _solved(known, softness))


def _solved(centres: Floats, softness: float) -> Floats:
    """Takes values at centres (m,) to coefficients and the constant, shape (m + 1, m)."""
    m = len(centres)
    system = np.zeros((m + 1, m + 1))
    system[:m, :m] = _basis(centres, centres, softness)
    system[:m, m] = system[m, :m] = 1.0
    return np.asarray(np.linalg.solve(system, np.eye(m + 1, m)))


def _basis(points: Floats, centres: Floats, softness: float) -> Floats:
    from scipy.spatial.distance import cdist

    return np.asarray(-np.sqrt(cdist(points, centres, "sqeuclidean") + softness**2))


class RegionDeformer:
    """Moves the skin of a face, and what lies on it, by displacements of markers.

    Parameters
    ----------
    face : Face
    sites : MarkerSites or None
        None takes those of the layout ``mediapipe-218`` (`sites_of_layout`).

    Attributes
    ----------
    matrices : dict of str to ndarray of float32, shape (vertices, markers)
        By name of the part.
    shares : dict of str to ndarray, shape (regions, vertices)
        Share of each region, by name of the part, in the order of ``sites.regions``.
    """

    def __init__(self, face: Face, sites: MarkerSites | None = None) -> None:
        self.face = face
        self.sites = sites or sites_of_layout(face)
        skin = face.part(self.sites.part)
        self._centres = skin.vertices[self.sites.vertices].astype(np.float64)
        distance = self._distances(skin)
        self._anchors = self._resting_points(skin, distance)
        self._fields = [self._field(region) for region in self.sites.regions]
        self.shares: dict[str, Floats] = {}
        self.matrices: dict[str, NDArray[np.float32]] = {}
        nearest = {skin.name: np.arange(len(skin.vertices))}
        from scipy.spatial import cKDTree

        tree = cKDTree(skin.vertices)
        for part in face.parts:
            if part.name in _ON_SKIN:
                nearest[part.name] = tree.query(part.vertices)[1]
        for name, at in nearest.items():
            points = face.part(name).vertices.astype(np.float64)
            self.shares[name] = self._shares(distance[:, at])
            self.matrices[name] = self._matrix(points, self.shares[name]).astype(np.float32)

    def offsets(self, displacements: ArrayLike) -> dict[str, NDArray[np.float32]]:
        """How far each vertex moves, (n, 3) mm by part, when the markers move by ``displacements`` (markers, 3), mm."""
        asked = np.asarray(displacements, dtype=np.float32)
        if asked.shape != (len(self.sites.names), 3):
            raise InputError(
                f"displacements: expected ({len(self.sites.names)} markers, 3 coordinates), got {asked.shape}"
            )
        return {name: matrix @ asked for name, matrix in self.matrices.items()}

    def _distances(self, skin: Part) -> Floats:
        """Along the skin from the nearest marker of each region, shape (regions, vertices), mm."""
        distances, nowhere = SkinDistances(skin), np.full(len(skin.vertices), np.inf)
        return np.array(
            [
                distances.to_nearest(self.sites.vertices[list(numbers)]) if numbers else nowhere
                for numbers in self.sites.regions.values()
            ]
        )

    def _shares(self, distance: Floats) -> Floats:
        nearest = distance.min(axis=0)
        with np.errstate(invalid="ignore"):
            borders = np.array([self.sites.borders[name] for name in self.sites.regions])[:, None]
            behind = np.where(np.isfinite(distance), distance - nearest, np.inf) / borders
        share = np.clip(1 - behind, 0, 1) ** 2
        share /= np.maximum(share.sum(axis=0), 1e-12)
        full, none = self.sites.reach
        fade = np.clip((none - nearest) / (none - full), 0, 1)
        return np.asarray(share * fade * fade * (3 - 2 * fade))

    def _matrix(self, points: Floats, shares: Floats) -> Floats:
        total = np.zeros((len(points), len(self.sites.names)))
        for (centres, chosen, solved), share in zip(self._fields, shares, strict=True):
            moved = np.flatnonzero(share > 0)
            if len(moved) and len(chosen):
                reach = np.hstack([_basis(points[moved], centres, SOFTNESS), np.ones((len(moved), 1))])
                total[np.ix_(moved, chosen)] += share[moved, None] * (reach @ solved)
        return total

    def _field(self, region: str) -> tuple[Floats, Ints, Floats]:
        """Centres of a region's interpolation, the markers among them, and what takes these to coefficients."""
        members = self.sites.regions[region]
        if not members:
            return np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros((1, 0))
        hidden = {m for other in self.sites.without[region] for m in self.sites.regions[other]} - set(members)
        heard = np.array([m for m in range(len(self.sites.names)) if m not in hidden])
        places, chosen = _apart(self._centres[heard], heard)
        centres = np.vstack([places, self._anchors])
        return centres, chosen, _solved(centres, SOFTNESS)[:, : len(chosen)]

    def _resting_points(self, skin: Part, distance: Floats) -> Floats:
        """Points spread over the skin that no marker reaches (farthest-point sampling)."""
        far = skin.vertices[distance.min(axis=0) > self.sites.reach[1]].astype(np.float64)
        if not len(far):
            return np.zeros((0, 3))
        chosen = [int(np.argmin(np.linalg.norm(far - self._centres.mean(0), axis=1)))]
        away = np.linalg.norm(far - far[chosen[0]], axis=1)
        while len(chosen) < min(_ANCHORS, len(far)) and away.max() > 1.0:
            chosen.append(int(np.argmax(away)))
            away = np.minimum(away, np.linalg.norm(far - far[chosen[-1]], axis=1))
        return np.asarray(far[chosen])


def _apart(places: Floats, numbers: Ints) -> tuple[Floats, Ints]:
    """Of markers on one vertex only the first: two would make the equations singular."""
    _, first = np.unique(places.round(3), axis=0, return_index=True)
    first.sort()
    return places[first], numbers[first]


def face_by_regions(face: Face, sites: MarkerSites | None = None) -> Face:
    """A face whose skin moves as its markers do: every channel moves the markers, and they move the skin.

    Its targets are what `RegionDeformer` makes of the displacements that the face's own targets give the marker sites.
    Teeth, tongue, eyes, hair and clothes keep their own.
    """
    deformer = RegionDeformer(face, sites)
    skin = face.part(deformer.sites.part)
    displaced: dict[str, NDArray[np.float32]] = {}
    for name in sorted(skin.targets):
        dense = np.zeros((len(skin.vertices), 3), dtype=np.float32)
        np.add.at(dense, skin.targets[name].vertices, skin.targets[name].offsets)
        if dense[deformer.sites.vertices].any():
            displaced[name] = dense[deformer.sites.vertices]
    made: dict[str, dict[str, Target]] = {name: {} for name in deformer.matrices}
    asked = np.concatenate([*displaced.values(), np.zeros((len(deformer.sites.names), 0), np.float32)], axis=1)
    for part, matrix in deformer.matrices.items():
        moving = matrix @ asked  # all channels in one product
        for number, name in enumerate(displaced):
            offsets = np.ascontiguousarray(moving[:, 3 * number : 3 * number + 3])
            moved = np.flatnonzero(np.abs(offsets).max(axis=1) > _SMALLEST)
            if len(moved):
                made[part][name] = Target(moved.astype(np.int32), offsets[moved])
    return replace(
        face,
        tree=None,
        parts=tuple(replace(p, targets=made[p.name]) if p.name in made else p for p in face.parts),
    )
