"""Recorded marker motion on any face (SPEC A14), with a report of what the face cannot do.

Markers are laid onto the face through its shapes: where a channel moves the default face, on which the markers of all
layouts have their places (`mien.corpus.layouts`), and where the same channel moves this one, is the same place. So a
face of another maker needs no landmarks, only morph targets that are known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.channels import ALL, ARKIT, HEAD
from mien.corpus.cleaning.normalise import best_similarity, neutral_frame
from mien.corpus.layouts import Layout, load_layout
from mien.errors import InputError
from mien.face.face import Face, Part
from mien.face.library import load_face
from mien.face.rbf_retargeting import RbfRetargeter, sampled_pairs
from mien.face.retargeting import Retargeter, Site, basis_at
from mien.face.retargeting_report import AmbiguousChannel, RegionResidual, ambiguous_channels, residual_by_region
from mien.models.learned_mouth import NOT_BY_MARKERS
from mien.tracks import ChannelTrack, MarkerTrack

__all__ = [
    "METHODS",
    "MarkerPairs",
    "MarkerPlaces",
    "RetargetedMotion",
    "head_channels",
    "marker_places",
    "neutral_of",
    "retarget",
    "to_face",
]

Floats = NDArray[np.float64]
METHODS = ("least-squares", "rbf")
RIDGE, STEADINESS = 1e-4, 2e-2
"""Of the least squares here: single shapes come back within 1 %, and a tracker's noise is calmed."""
_PAIRED = (
    "eyeBlink", "eyeSquint", "browOuterUp", "browDown", "noseSneer", "mouthSmile", "mouthUpperUp", "mouthLowerDown",
)  # fmt: skip
_ANCHORS = (
    *(f"{name}{side}" for name in _PAIRED for side in ("Left", "Right")),
    *("browInnerUp", "mouthPucker", "mouthShrugLower", "jawOpen"),
)
_LEAST_ANCHORS, _AFFINE_ANCHORS = 4, 8
_IRIS = 468  # landmarks of MediaPipe's mesh from here on lie on the irises, not on the skin
_MIXTURES = 600
_NOISE_SHARE = 0.9999


@dataclass(frozen=True)
class MarkerPlaces:
    """Where markers sit on a face: ``sites`` for ``markers``; ``anchors`` channels told where (0: the default face)."""

    markers: tuple[str, ...]
    sites: tuple[Site, ...]
    anchors: int


@dataclass(frozen=True)
class MarkerPairs:
    """Pairs of marker displacements and weights that somebody made, for ``rbf``.

    Attributes
    ----------
    markers, channels : tuple of str
    displacements : ndarray, shape (pairs, markers, 3)
        Millimetres from rest, in the recording's axes.
    weights : ndarray, shape (pairs, channels)
        0..1.
    """

    markers: tuple[str, ...]
    channels: tuple[str, ...]
    displacements: Floats
    weights: Floats

    @classmethod
    def read(cls, path: str | Path) -> MarkerPairs:
        """Read ``.npz`` with the arrays ``markers``, ``channels``, ``displacements`` and ``weights``.

        Raises
        ------
        InputError
            If it is none, or names channels that there are not.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                names = [tuple(str(name) for name in file[key]) for key in ("markers", "channels")]
                arrays = [np.asarray(file[key], dtype=np.float64) for key in ("displacements", "weights")]
        except (OSError, ValueError, KeyError, BadZipFile) as problem:
            raise InputError(
                f"{path}: expected a .npz with markers, channels, displacements and weights: {problem}"
            ) from problem
        unknown = [name for name in names[1] if name not in ALL]
        if unknown:
            raise InputError(f"{path}: {', '.join(unknown[:5])} are no channels of mien")
        if arrays[0].shape[1:] != (len(names[0]), 3) or arrays[1].shape != (len(arrays[0]), len(names[1])):
            raise InputError(
                f"{path}: expected displacements (pairs, {len(names[0])}, 3) and weights (pairs, {len(names[1])}), "
                f"got {arrays[0].shape} and {arrays[1].shape}"
            )
        return cls(names[0], names[1], arrays[0], arrays[1])


@dataclass(frozen=True)
class RetargetedMotion:
    """Channels for a recording, and how well the face shows it.

    Attributes
    ----------
    channels : ChannelTrack
        `mien.channels.ALL`; what markers cannot tell rests.
    used : tuple of str
        The channels that were sought.
    regions : tuple of RegionResidual
    ambiguous : tuple of AmbiguousChannel
        Channels that these markers can hardly tell from others: their weights are one answer of several.
    anchors : int
        As in `MarkerPlaces`.
    """

    channels: ChannelTrack
    used: tuple[str, ...]
    regions: tuple[RegionResidual, ...]
    ambiguous: tuple[AmbiguousChannel, ...]
    anchors: int

    def lines(self) -> list[str]:
        """The report in words."""
        told = [f"{len(self.used)} channels sought; what the face cannot show of the motion, by region:"]
        told += [f"  {region.line()}" for region in self.regions]
        for found in self.ambiguous:
            told.append(
                f"  {found.channel} is hardly told from {', '.join(found.stand_ins) or 'others'} by these markers "
                f"({found.own:.0%} of it is its own)"
            )
        return told


def marker_places(face: Face, layout: Layout, markers: Sequence[str]) -> MarkerPlaces:
    """Where the markers of a layout sit on a face; those on irises have no place.

    Raises
    ------
    InputError
        If a marker is not in the layout, or too few of the face's shapes are known.
    """
    iris = {name for landmark, name in layout.landmarks.items() if landmark >= _IRIS}
    kept = tuple(name for name in markers if name not in iris)
    places = layout.places[layout.index(kept)]
    default = load_face("default")
    skin = default.part("skin")
    _, vertices = cKDTree(skin.vertices).query(places)
    twin = next((part for part in face.parts if part.name == "skin"), None)
    if twin is not None and len(twin.vertices) == len(skin.vertices):
        return MarkerPlaces(kept, tuple(("skin", int(v)) for v in vertices), 0)
    ours, theirs = _centres(default), _centres(face)
    shared = [name for name in _ANCHORS if name in ours and name in theirs]
    if len(shared) < _LEAST_ANCHORS:
        raise InputError(
            f"face {face.name!r}: markers find their places through shapes that both faces have; it has {len(shared)} "
            f"of them ({', '.join(shared) or 'none'}), {_LEAST_ANCHORS} are needed, such as {', '.join(_ANCHORS[:4])}"
        )
    carry = _carrying(np.array([ours[name] for name in shared]), np.array([theirs[name] for name in shared]))
    return MarkerPlaces(kept, _nearest(face, shared, places @ carry[:3] + carry[3]), len(shared))


def _centres(face: Face) -> dict[str, Floats]:
    """The middle of what each anchor moves, weighed by how far, mm."""
    found: dict[str, Floats] = {}
    for name in _ANCHORS:
        points, weights = [], []
        for part in face.parts:
            target = part.targets.get(name)
            if target is not None and len(target.vertices):
                points.append(part.vertices[target.vertices].astype(np.float64))
                weights.append((target.offsets.astype(np.float64) ** 2).sum(axis=1))
        total = float(sum(weight.sum() for weight in weights))
        if total > 0:
            joined, shares = np.concatenate(points), np.concatenate(weights) / total
            found[name] = shares @ joined
    return found


def _carrying(ours: Floats, theirs: Floats) -> Floats:
    """An affine map as rows (4, 3): the similarity of best fit, bent to the anchors where there are enough of them."""
    alike = best_similarity(ours, theirs, np.ones(len(ours)), scale=True)
    start = np.vstack([alike[:3, :3].T, alike[:3, 3]])
    if len(ours) < _AFFINE_ANCHORS:
        return start
    design = np.hstack([ours, np.ones((len(ours), 1))])
    spread = np.diag([1e2, 1e2, 1e3, 1e-2])  # depth is told worst by anchors on the front of a face
    change = np.linalg.solve(design.T @ design + spread, design.T @ (theirs - design @ start))
    return np.asarray(start + change)


def _nearest(face: Face, shared: Sequence[str], places: Floats) -> tuple[Site, ...]:
    """The nearest vertices among parts that many anchors move: the skin, not teeth and lashes."""
    moved = [sum(name in part.targets for name in shared) for part in face.parts]
    skins: list[Part] = [part for part, count in zip(face.parts, moved, strict=True) if 2 * count >= max(moved)]
    largest = max(len(part.vertices) for part in skins)
    skins = [part for part in skins if 10 * len(part.vertices) >= largest]
    points = np.concatenate([part.vertices for part in skins])
    owners = [(part.name, vertex) for part in skins for vertex in range(len(part.vertices))]
    _, rows = cKDTree(points).query(places)
    return tuple(owners[int(row)] for row in rows)


def retarget(
    motion: MarkerTrack,
    layout: Layout | str,
    face: Face,
    method: str = "least-squares",
    pairs: MarkerPairs | None = None,
    rest: int | None = None,
    seed: int = 0,
) -> RetargetedMotion:
    """Channels that move a face as markers were recorded.

    Parameters
    ----------
    motion : MarkerTrack
        Cleaned, the head's own motion taken out (a take of a corpus).
    layout : Layout or str
    face : Face
        With targets named by channels (`mien.face.foreign.drawn.DrawnFace.by_channels` for one of another maker).
    method : {"least-squares", "rbf"}
        Bounded least squares on the face's marker sites, or regression on radial basis functions.
    pairs : MarkerPairs, optional
        For ``rbf``: examples made by hand; else they are drawn from the face's own shapes.
    rest : int, optional
        The frame that shows the speaker at rest; None finds the most neutral one.
    seed : int
        Of the drawn examples.

    Raises
    ------
    InputError
        If markers, pairs or face do not fit.
    """
    if method not in METHODS:
        raise InputError(f"a method is {' or '.join(METHODS)}, not {method!r}")
    if pairs is not None and method != "rbf":
        raise InputError("pairs are for the method rbf")
    layout = load_layout(layout) if isinstance(layout, str) else layout
    places = marker_places(face, layout, motion.names)
    columns = [motion.names.index(name) for name in places.markers]
    positions = motion.positions[:, columns]
    if not np.isfinite(positions).all():
        frame, marker = np.argwhere(~np.isfinite(positions))[0][:2]
        raise InputError(f"marker {places.markers[marker]} was not seen in frame {frame}; import fills gaps")
    still = neutral_of(motion, layout) if rest is None else rest
    if not 0 <= still < len(motion):
        raise InputError(f"the frame at rest is one of 0 to {len(motion) - 1}, not {still}")
    asked = (positions - positions[still]) @ to_face(positions[still], face, layout, places).T
    used = _sought(face, places)
    basis = basis_at(face, places.sites, used)
    if method == "least-squares":
        weights = Retargeter(face, places.sites, used, RIDGE, STEADINESS).solve(asked, motion.rate.fps).weights
    elif pairs is None:
        shown, wanted = sampled_pairs(basis, _MIXTURES, np.random.default_rng(seed))
        weights = RbfRetargeter(variance=_NOISE_SHARE).fit(shown, wanted).solve(asked, motion.rate.fps)
    else:
        used = pairs.channels
        basis = basis_at(face, places.sites, used)
        weights = _by_pairs(pairs, places.markers, positions - positions[still], motion.rate.fps)
    reached = np.einsum("tc,cmk->tmk", weights, basis)
    values = np.zeros((len(motion), len(ALL)))
    values[:, [ALL.index(name) for name in used]] = weights
    return RetargetedMotion(
        ChannelTrack(ALL, values, motion.rate),
        tuple(used),
        residual_by_region(asked, reached, places.markers, layout.groups),
        ambiguous_channels(basis, used) if method == "least-squares" or pairs is None else (),
        places.anchors,
    )


def _by_pairs(pairs: MarkerPairs, markers: Sequence[str], displacements: Floats, fps: float) -> Floats:
    missing = [name for name in pairs.markers if name not in markers]
    if missing:
        raise InputError(f"the pairs have markers that the recording has not: {', '.join(missing[:5])}")
    columns = [list(markers).index(name) for name in pairs.markers]
    learned = RbfRetargeter().fit(pairs.displacements, pairs.weights)
    return learned.solve(displacements[:, columns], fps)


def neutral_of(motion: MarkerTrack, layout: Layout) -> int:
    """The frame of a recording that best shows the speaker at rest."""
    groups = layout.motion_groups()
    return neutral_frame(motion, groups.upper_lip, groups.lower_lip, layout.rigid)


def to_face(rest: Floats, face: Face, layout: Layout, places: MarkerPlaces) -> Floats:
    """From the speaker's axes and size to the face's, (3, 3): by the markers at rest and their places on the face."""
    parts = {part.name: part for part in face.parts}
    sites = np.array([parts[name].vertices[vertex] for name, vertex in places.sites], dtype=np.float64)
    goal = sites if places.anchors else layout.places[layout.index(places.markers)]
    return best_similarity(rest, goal, np.ones(len(rest)), scale=True)[:3, :3]


def _sought(face: Face, places: MarkerPlaces) -> tuple[str, ...]:
    """ARKit's channels that move the sites and that markers can tell."""
    there = {name for part in face.parts for name in part.targets}
    names = [n for n in ARKIT if n in there and n not in NOT_BY_MARKERS and not n.startswith("eyeLook")]
    basis = basis_at(face, places.sites, names)
    moved = tuple(name for name, rows in zip(names, basis, strict=True) if np.abs(rows).max(initial=0.0) > 0.05)
    if not moved:
        raise InputError(f"face {face.name!r}: none of its shapes moves a marker")
    return moved


def head_channels(head: Floats) -> Mapping[str, Floats]:
    """Yaw, pitch and roll in degrees of a take's head motion (frames, 4, 4), from the pose that it holds most."""
    from scipy.spatial.transform import Rotation

    turns = head[:, :3, :3] / np.cbrt(np.linalg.det(head[:, :3, :3]))[:, None, None]
    rotations = Rotation.from_matrix(turns)
    # From the speaker's own rest: the axes are the face's, in which the markers were normalised.
    angles = (rotations.mean().inv() * rotations).as_euler("YXZ", degrees=True)
    return dict(zip(HEAD, (angles[:, 0], -angles[:, 1], -angles[:, 2]), strict=True))
