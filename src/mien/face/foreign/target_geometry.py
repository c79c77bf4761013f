"""What a morph target does, told by what it moves and not by its name.

Every target, of a face of ours or of another maker's, is described by its motion: displacements weighed by the area of
skin that they carry, blurred over points in front of the face. Two faces are laid over one another by their motion
alone: of all scales and shifts along the axes those count under which the targets of the one look most like channels of
the other, so that no landmark is needed. Then a target is likened to each channel by the cosine between the two.

Measured on the 47 shapes of a production head that no name was given for: see ``docs/faces.md``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ARKIT
from mien.face.library import load_face
from mien.face.model import Face, Part

__all__ = ["Likeness", "Registration", "likenesses", "registered"]

Floats = NDArray[np.float64]
Motion = Mapping[str, tuple[Floats, Floats]]
"""For each target the centres of small clumps of skin, mm, and displacement times area summed over each, mm^3."""

SURE = 0.72
"""Cosine from which on a likeness counts as sure."""
TRUSTED = 0.74
APART = 0.05
"""By how much it must be ahead of every other that is not of its family."""
_CELL, _BLUR, _GRID = 9.0, 9.0, 12.0  # mm
_FAINT = 0.2  # share of a target's greatest displacement below which a vertex is taken not to move
_STEPS = (0.16, 0.08, 0.04, 0.02)
_MIDDLE = -40.0
"""Height of the middle of the face below the eyes, mm: scales are tried about it."""
_MOST_TARGETS = 40
_FAMILIES = (
    ("mouthSmile", "mouthDimple"), ("mouthFunnel", "mouthPucker"), ("mouthClose", "mouthShrugLower"),
    ("cheekSquint", "eyeSquint"), ("mouthShrugUpper", "mouthUpperUp"), ("mouthLeft", "jawLeft"),
    ("mouthRight", "jawRight"),
)  # fmt: skip
"""Channels that move much the same skin the same way: of these the best is taken though the other is near."""


@dataclass(frozen=True)
class Likeness:
    """A channel that a target moves like.

    Attributes
    ----------
    recipe : mapping of str to float
        The channel, or both sides of it.
    cosine : float
        1: the same motion up to its size; 0: nothing in common.
    sure : bool
        Whether it is near enough, and nothing else is as near.
    others : mapping of str to float
        Cosine with every channel that the default face has.
    """

    recipe: Mapping[str, float]
    cosine: float
    sure: bool
    others: Mapping[str, float] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class Registration:
    """Scale and shift along each axis, mm, that lay another face over the default one: ``points * scale + shift``.

    Attributes
    ----------
    scale, shift : ndarray, shape (3,)
    likeness : float
        Mean over the targets of the cosine with the channel that is most like it: below `TRUSTED` the two faces have
        too little in common to tell anything by it.
    """

    scale: Floats
    shift: Floats
    likeness: float = 0.0

    @property
    def trusted(self) -> bool:
        """Whether what is told by motion can be believed."""
        return self.likeness >= TRUSTED

    def back(self, points: Floats) -> Floats:
        """Places on the default face as they lie on the other face, shape (n, 3)."""
        return np.asarray((points - self.shift) / self.scale)


def likenesses(face: Face, keys: Sequence[str] | None = None) -> tuple[dict[str, Likeness], Registration]:
    """For each target of a face the channel that it moves most like.

    Parameters
    ----------
    face : Face
        Millimetres, looking along +z, the origin between the eyes (`mien.face.foreign.drawn.drawn_face`).
    keys : sequence of str or None
        The targets that are asked about; None: all. The face is laid over ours by all of them.
    """
    motion = _motion_of(face)
    registration = registered(motion)
    asked = [key for key in motion if keys is None or key in keys]
    prints = _unit(_prints({key: motion[key] for key in asked}, registration))
    names, known = _known()
    found = {
        key: _best(row, dict(zip(names, map(float, others), strict=True)))
        for key, row, others in zip(asked, prints @ _candidates()[1].T, prints @ known.T, strict=True)
    }
    if not registration.trusted:
        found = {key: replace(likeness, sure=False) for key, likeness in found.items()}
    return found, registration


def registered(motion: Motion) -> Registration:
    """Lay a face over the default one by what its targets move."""
    chosen = dict(sorted(motion.items(), key=lambda item: -float(np.abs(item[1][1]).sum()))[:_MOST_TARGETS])
    ours, theirs = _extent(_default_motion()), _extent(chosen)
    size = np.maximum(theirs[1] - theirs[0], 1e-6)
    scale = (ours[1] - ours[0]) / size
    scale[2] = scale[1]
    middle = 0.5 * (theirs[0] + theirs[1])
    shift = 0.5 * (ours[0] + ours[1]) - middle * scale
    shift[2] = ours[1][2] - theirs[1][2] * scale[2]
    starts = [Registration(scale, shift), Registration(np.ones(3), np.zeros(3))]  # by extent, or as it was laid out
    most, best = max(((_likeness_of_all(chosen, start), start) for start in starts), key=lambda found: found[0])
    for step in _STEPS:
        for axis, scaled, moved in ((0, step, 0.0), (1, step, 0.0), (1, 0.0, step * 70), (2, 0.0, step * 70)) * 2:
            for sign in (1.0, -1.0):
                tried = _changed(best, axis, sign * scaled, sign * moved)
                likeness = _likeness_of_all(chosen, tried)
                if likeness > most:
                    best, most = tried, likeness
    return replace(best, likeness=most / len(chosen))


def _changed(given: Registration, axis: int, scaled: float, moved: float) -> Registration:
    scale, shift = given.scale.copy(), given.shift.copy()
    if scaled:
        middle = _MIDDLE if axis == 1 else 0.0
        source = (middle - shift[axis]) / scale[axis]
        scale[axis] *= 1.0 + scaled
        shift[axis] = middle - source * scale[axis]
    shift[axis] += moved
    return Registration(scale, shift)


def _likeness_of_all(motion: Motion, registration: Registration) -> float:
    return float(_cosines(motion, registration).max(axis=1).sum())


def _extent(motion: Motion) -> tuple[Floats, Floats]:
    centres = np.concatenate([centres for centres, _ in motion.values()])
    return np.percentile(centres, 3, axis=0), np.percentile(centres, 97, axis=0)


def _cosines(motion: Motion, registration: Registration) -> Floats:
    """Cosines with every candidate, shape (targets, candidates)."""
    return np.asarray(_unit(_prints(motion, registration)) @ _candidates()[1].T)


def _unit(prints: Floats) -> Floats:
    return np.asarray(prints / np.maximum(np.linalg.norm(prints, axis=1, keepdims=True), 1e-12))


def _prints(motion: Motion, registration: Registration) -> Floats:
    """The motion of each target seen at the points in front of the face, shape (targets, points * 3)."""
    centres = np.concatenate([centres for centres, _ in motion.values()])
    carried = np.concatenate([carried for _, carried in motion.values()]) * registration.scale
    first = np.cumsum([0, *(len(centres) for centres, _ in motion.values())])[:-1]
    places, points = centres * registration.scale + registration.shift, _points()
    apart = (places**2).sum(axis=1)[:, None] + (points**2).sum(axis=1)[None] - 2.0 * places @ points.T
    near = np.exp(apart.astype(np.float32) * np.float32(-0.5 / _BLUR**2))
    seen = [np.add.reduceat(near * carried[:, axis, None].astype(np.float32), first, axis=0) for axis in range(3)]
    return np.stack(seen, axis=2).reshape(len(first), -1).astype(np.float64)


def _best(row: Floats, others: Mapping[str, float]) -> Likeness:
    names = _candidates()[0]
    order = np.argsort(-row, kind="stable")
    first = names[order[0]]
    rival = next((row[place] for place in order[1:] if not _related(first, names[place])), 0.0)
    sure = bool(row[order[0]] >= SURE and row[order[0]] - rival >= APART)
    weight = 1.0 / len(first)
    return Likeness(dict.fromkeys(first, weight), round(float(row[order[0]]), 3), sure, others)


def _related(one: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Whether two candidates are sides of one another, or of one family."""
    stem, second = _stem(one), _stem(other)
    return stem == second or any(stem in family and second in family for family in _FAMILIES)


def _stem(candidate: tuple[str, ...]) -> str:
    name = candidate[0]
    for side in ("Left", "Right"):
        if name.endswith(side) and name not in ("mouthLeft", "mouthRight", "jawLeft", "jawRight"):
            return name[: -len(side)]
    return name


@cache
def _candidates() -> tuple[tuple[tuple[str, ...], ...], Floats]:
    """What a target may be: a channel, or both sides of one; and the unit prints of all."""
    motion = _default_motion()
    here = Registration(np.ones(3), np.zeros(3))
    seen = _prints(motion, here)
    prints: dict[tuple[str, ...], Floats] = {(name,): row for name, row in zip(motion, seen, strict=True)}
    for name in motion:
        right = name[: -len("Left")] + "Right"
        if name.endswith("Left") and right in motion and name not in ("mouthLeft", "jawLeft"):
            prints[name, right] = prints[name,] + prints[right,]
    return tuple(prints), _unit(np.array(list(prints.values())))


@cache
def _known() -> tuple[tuple[str, ...], Floats]:
    """All channels of the default face, looks and those beyond ARKit too, and their unit prints."""
    motion = _motion_of(load_face("default"))
    return tuple(motion), _unit(_prints(motion, Registration(np.ones(3), np.zeros(3))))


@cache
def _default_motion() -> Motion:
    motion = _motion_of(load_face("default"))
    # A lid that looks down moves as one that closes: the eye's own looks are told by the eyeballs.
    return {name: motion[name] for name in ARKIT if name in motion and not name.startswith("eyeLook")}


@cache
def _points() -> Floats:
    """Points in front of the default face, shape (n, 3), mm: its foremost skin over a grid."""
    skin = max(load_face("default").parts, key=lambda part: len(part.targets)).vertices.astype(np.float64)
    skin = skin[skin[:, 2] > -40.0]
    found = []
    for x in np.arange(-66.0, 67.0, _GRID):
        for y in np.arange(-105.0, 70.0, _GRID):
            near = skin[np.hypot(skin[:, 0] - x, skin[:, 1] - y) < 6.0]
            if len(near):
                found.append((x, y, near[:, 2].max()))
    return np.array(found)


def _motion_of(face: Face) -> Motion:
    """All targets of a face that move anything, over all its parts but the eyeballs."""
    eyeballs = {eye.part for eye in face.eyes}
    gathered: dict[str, list[tuple[Floats, Floats]]] = {}
    for part in face.parts:
        if part.name in eyeballs or not part.targets:
            continue
        areas = _areas(part)
        for name, target in part.targets.items():
            offsets = target.offsets.astype(np.float64)
            if len(offsets):
                places = part.vertices[target.vertices].astype(np.float64)
                gathered.setdefault(name, []).append((places, offsets * areas[target.vertices, None]))
    return {
        name: _clumped(np.concatenate([p for p, _ in pieces]), np.concatenate([c for _, c in pieces]))
        for name, pieces in gathered.items()
    }


def _areas(part: Part) -> Floats:
    """Area of skin around each vertex, mm^2."""
    corners = part.vertices[part.triangles].astype(np.float64)
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    areas = np.zeros(len(part.vertices))
    for corner in range(3):
        areas += np.bincount(part.triangles[:, corner], doubled / 6.0, len(part.vertices))
    return areas


def _clumped(places: Floats, carried: Floats) -> tuple[Floats, Floats]:
    """The same motion gathered in cells, so that dense meshes cost no more than coarse ones."""
    size = np.linalg.norm(carried, axis=1)
    kept = size > _FAINT * size.max() * 0.5
    places, carried, size = places[kept], carried[kept], size[kept]
    _, cell = np.unique(np.floor(places / _CELL).astype(np.int64), axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    total = np.bincount(cell, size)
    centres = np.stack([np.bincount(cell, size * places[:, axis]) / total for axis in range(3)], axis=1)
    return centres, np.stack([np.bincount(cell, carried[:, axis]) for axis in range(3)], axis=1)
