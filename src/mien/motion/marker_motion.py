"""Recorded marker motion on any face (Deng et al. 2006), with a report of what the face cannot do.

Markers find their places on a face through its shapes (`mien.face.marker_sites`): a face of another maker needs no
landmarks, only morph targets that are known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import best_similarity, neutral_frame
from mien.capture.layouts import Layout, load_layout
from mien.core.border import reading
from mien.core.channels import ALL, ARKIT, HEAD
from mien.core.errors import InputError
from mien.core.limits import load_arrays
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.rbf_retargeting import RbfRetargeter, sampled_pairs
from mien.face.retargeting import Retargeter, Site, basis_at
from mien.face.retargeting_report import AmbiguousChannel, RegionResidual, ambiguous_channels, residual_by_region
from mien.motion.mouth.learned_mouth import NOT_BY_MARKERS

__all__ = [
    "METHODS",
    "MarkerPairs",
    "RetargetedMotion",
    "SkinMarkers",
    "head_channels",
    "neutral_of",
    "retarget",
    "skin_markers",
    "to_face",
]

Floats = NDArray[np.float64]
METHODS = ("least-squares", "rbf")
RIDGE, STEADINESS = 1e-4, 2e-2
"""Of the least squares here: single shapes come back within 1 %, and a tracker's noise is calmed."""
_IRIS = 468  # landmarks of MediaPipe's mesh from here on lie on the irises, not on the skin
_MIXTURES = 600
_NOISE_SHARE = 0.9999


@dataclass(frozen=True)
class SkinMarkers:
    """Markers on a face's skin: where each sits, and how that was found (`mien.face.marker_sites.Placed`)."""

    markers: tuple[str, ...]
    sites: tuple[Site, ...]
    how: str


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
        with reading(path, "an .npz with markers, channels, displacements and weights"):
            file = load_arrays(path)
            names = [tuple(str(name) for name in file[key]) for key in ("markers", "channels")]
            arrays = [np.asarray(file[key], dtype=np.float64) for key in ("displacements", "weights")]
        unknown = [name for name in names[1] if name not in ALL]
        if unknown:
            raise InputError(f"{path}: {', '.join(unknown[:5])} are not channels of mien")
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
        `mien.core.channels.ALL`; what markers cannot tell rests.
    used : tuple of str
        The channels that were sought.
    regions : tuple of RegionResidual
    ambiguous : tuple of AmbiguousChannel
        Channels that these markers can hardly tell from others: their weights are one answer of several.
    how : str
        How the markers found their places on the face, as in `SkinMarkers`.
    """

    channels: ChannelTrack
    used: tuple[str, ...]
    regions: tuple[RegionResidual, ...]
    ambiguous: tuple[AmbiguousChannel, ...]
    how: str

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


def skin_markers(face: Face, layout: Layout, markers: Sequence[str]) -> SkinMarkers:
    """Where the markers of a layout sit on a face; those on irises are left out.

    Raises
    ------
    InputError
        If a marker is not in the layout, or too few of the face's shapes are known.
    """
    layout.index(markers)
    iris = {name for landmark, name in layout.landmarks.items() if landmark >= _IRIS}
    placed = place_markers(face, layout)
    site = dict(zip(placed.names, placed.sites, strict=True))
    kept = tuple(name for name in markers if name in site and name not in iris)
    return SkinMarkers(kept, tuple(site[name] for name in kept), placed.how)


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
    places = skin_markers(face, layout, motion.names)
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
        places.how,
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


def to_face(rest: Floats, face: Face, layout: Layout, places: SkinMarkers) -> Floats:
    """From the speaker's axes and size to the face's, (3, 3): by the markers at rest and their places on the face."""
    parts = {part.name: part for part in face.parts}
    sites = np.array([parts[name].vertices[vertex] for name, vertex in places.sites], dtype=np.float64)
    goal = sites if places.how == "transferred" else layout.places[layout.index(places.markers)]
    return best_similarity(rest, goal, np.ones(len(rest)), scale=True)[:3, :3]


def _sought(face: Face, places: SkinMarkers) -> tuple[str, ...]:
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
