"""The default face with another head's shape: all of it follows the skin, and lips and lids still meet.

A target's displacement is turned and scaled by the local change of the surface (the Jacobian of the map from the
default skin to the new one, least squares over each vertex's surroundings, smoothed). Then contact is restored as the
default face has it: lips in the shapes of a closed mouth, lids in a blink, lids outside the eyeball on their way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.contact import Seam, dense_targets, lid_seam, lip_seam
from mien.face.head_space import SKIN, HeadSpace
from mien.face.model import Eye, Face, Part, Target
from mien.face.surface import edges_of, vertex_normals
from mien.face.warps import SmoothWarp, spread_points

__all__ = ["EyePlace", "Reshaped", "reshaped_face", "sparse_target"]

SMALLEST_MOVE = 0.02  # mm
_WARP_POINTS = 420
_SMOOTHING = 300  # rounds over the mesh: displacements follow how a region changed, not how a wrinkle did
_STRETCH = (0.6, 1.7)
_AIR = 0.2  # mm between a lid and the eyeball
_MOVING_LIDS = (
    "eyeBlink", "eyeSquint", "eyeWide", "eyeLookUp", "eyeLookDown", "eyeLookIn", "eyeLookOut", "cheekSquint",
)  # fmt: skip
_SHUT_MM = 0.8  # shapes that part nine tenths of the default's lips by less than this are of a closed mouth
_BOUND = ("lashes", "brows", "caruncles")
_RIGID = ("teeth_upper", "teeth_lower", "tongue")

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class EyePlace:
    """An eyeball: its centre and its radius, mm."""

    centre: tuple[float, float, float]
    radius: float


@dataclass(frozen=True, eq=False)
class Reshaped:
    """The result of `reshaped_face`.

    Attributes
    ----------
    face : Face
    jacobians : ndarray, shape (n, 3, 3)
        What displacements of the skin were turned and scaled by.
    targets : mapping of str to ndarray of shape (n, 3)
        The skin's targets, dense.
    """

    face: Face
    jacobians: Floats
    targets: Mapping[str, Floats]


def sparse_target(offsets: NDArray[np.floating[Any]]) -> Target | None:
    """A target without the vertices that hardly move; None if none does."""
    moved = np.flatnonzero(np.abs(offsets).max(axis=1) >= SMALLEST_MOVE)
    return Target(moved.astype(np.int32), offsets[moved].astype(np.float32)) if len(moved) else None


def reshaped_face(space: HeadSpace, skin: Floats, name: str, eyes: Mapping[str, EyePlace] | None = None) -> Reshaped:
    """The default face on another skin.

    Parameters
    ----------
    space : HeadSpace
    skin : ndarray, shape (n, 3)
        New places of the default skin's vertices, mm, upright.
    name : str
        Of the new face.
    eyes : mapping of "Left", "Right" to EyePlace, optional
        Eyeballs where they are known; else they follow the margins of the lids.
    """
    jacobians = _jacobians(space, skin)
    places = {eye.side: _eye_place(space, skin, eye) for eye in space.face.eyes} | dict(eyes or {})
    skin = _lids_outside(space, skin, places)
    targets = {key: np.einsum("nij,nj->ni", jacobians, offsets) for key, offsets in dense_targets(space).items()}
    _restore_contact(space, skin, targets, places)
    chosen = spread_points(space.rest[space.outer()], _WARP_POINTS)
    anchors = np.flatnonzero(space.outer())[chosen]
    warp = SmoothWarp(space.rest[anchors], skin[anchors], smoothness=0.5)
    parts = tuple(_part(space, part, skin, jacobians, targets, places, warp) for part in space.face.parts)
    pivot = warp(np.array([space.face.head_pivot]))[0]
    face = replace(
        space.face,
        name=name,
        parts=parts,
        eyes=tuple(replace(eye, centre=places[eye.side].centre) for eye in space.face.eyes),
        head_pivot=(float(pivot[0]), float(pivot[1]), float(pivot[2])),
    )
    return Reshaped(face, jacobians, targets)


# ------------------------------------------------------------------ how the surface changed


def _jacobians(space: HeadSpace, skin: Floats) -> Floats:
    """Per vertex the linear map from the default's surroundings to the new ones, smoothed, shape (n, 3, 3)."""
    count = len(skin)
    edges = edges_of(space.triangles)
    ends = np.concatenate([edges, edges[:, ::-1]])
    before, after = (v[ends[:, 1]] - v[ends[:, 0]] for v in (space.rest, skin))
    reach = np.linalg.norm(before, axis=1, keepdims=True)
    normal, normal_after = (vertex_normals(v, space.triangles) for v in (space.rest, skin))
    ends = np.concatenate([ends, np.stack([np.arange(count), np.arange(count)], axis=1)])
    owner = ends[: len(reach), 0]
    times = np.maximum(np.bincount(owner, minlength=count), 1)
    size = np.bincount(owner, reach.ravel(), count) / times
    size_after = np.bincount(owner, np.linalg.norm(after, axis=1), count) / times
    before = np.concatenate([before, normal * size[:, None]])
    after = np.concatenate([after, normal_after * size_after[:, None]])
    weight = 1 / np.maximum((before**2).sum(1), 1e-6)
    one = sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], np.arange(len(ends)))), (count, len(ends)))
    own = one @ (weight[:, None, None] * before[:, :, None] * before[:, None, :]).reshape(-1, 9)
    mixed = one @ (weight[:, None, None] * after[:, :, None] * before[:, None, :]).reshape(-1, 9)
    mean = _mean_of_neighbours(edges, count)
    for _ in range(_SMOOTHING):
        own, mixed = mean @ own, mean @ mixed
    maps = mixed.reshape(-1, 3, 3) @ np.linalg.inv(own.reshape(-1, 3, 3) + 1e-6 * np.eye(3))
    u, sizes, vt = np.linalg.svd(maps)
    return np.asarray(u * np.clip(sizes, *_STRETCH)[:, None, :] @ vt)


def _mean_of_neighbours(edges: NDArray[np.int32], count: int) -> sparse.csr_matrix:
    ends = np.concatenate([edges, edges[:, ::-1]])
    beside = sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (count, count))
    beside = beside + sparse.identity(count)
    return sparse.diags(1 / np.asarray(beside.sum(1)).ravel()) @ beside


# ------------------------------------------------------------------ eyes


def _eye_place(space: HeadSpace, skin: Floats, eye: Eye) -> EyePlace:
    """The default's eyeball scaled and moved as the margins of its lids were (no rotation)."""
    loop = space.lid_loop_left if eye.side == "Left" else space.lid_loop_right
    before, after = space.rest[loop], skin[loop]
    a, b = before.mean(0), after.mean(0)
    scale = float(np.sqrt(((after - b) ** 2).sum() / ((before - a) ** 2).sum()))
    centre = b + scale * (np.array(eye.centre) - a)
    return EyePlace((float(centre[0]), float(centre[1]), float(centre[2])), scale * _radius(space.face, eye))


def _radius(face: Face, eye: Eye) -> float:
    return float(np.median(np.linalg.norm(face.part(eye.part).vertices - np.array(eye.centre), axis=1)))


def _near_eye(space: HeadSpace, side: str) -> NDArray[np.int64]:
    """The lids' outer skin and their margins (not what lies behind them)."""
    eye = next(eye for eye in space.face.eyes if eye.side == side)
    away = np.linalg.norm(space.rest - np.array(eye.centre), axis=1)
    return np.flatnonzero((away < 2.2 * _radius(space.face, eye)) & (space.socket < 0.5))


def _pushed_out(points: Floats, place: EyePlace, air: float) -> Floats:
    arm = points - np.array(place.centre)
    distance = np.maximum(np.linalg.norm(arm, axis=1, keepdims=True), 1e-6)
    return np.asarray(arm / distance * np.maximum(place.radius + air - distance, 0))


def _lids_outside(space: HeadSpace, skin: Floats, places: Mapping[str, EyePlace]) -> Floats:
    skin = skin.copy()
    for side, place in places.items():
        near = _near_eye(space, side)
        skin[near] += _pushed_out(skin[near], place, _AIR)
    return skin


# ------------------------------------------------------------------ contact


def _restore_contact(
    space: HeadSpace, skin: Floats, targets: dict[str, Floats], places: Mapping[str, EyePlace]
) -> None:
    """Mend targets so that lips and lids meet as they do on the default face."""
    own = dense_targets(space)
    lips = lip_seam()
    rest_gap, own_gap = lips.gaps(skin), lips.gaps(space.rest)
    for name in targets:
        parted = lips.gaps(space.rest + own[name]) - own_gap
        if (
            name == "mouthClose"
            or np.percentile(np.abs(parted), 90) > _SHUT_MM
            or not np.abs(lips.upper @ own[name]).max() > 0.05
        ):
            continue
        targets[name] = targets[name] + lips.closing(skin + targets[name], rest_gap + parted, smooth_mm=4.0)
    if "mouthClose" in targets and "jawOpen" in targets:
        wanted = rest_gap + lips.gaps(space.rest + own["jawOpen"] + own["mouthClose"]) - own_gap
        together = skin + targets["jawOpen"] + targets["mouthClose"]
        targets["mouthClose"] = targets["mouthClose"] + lips.closing(together, wanted)
    for side, place in places.items():
        _mend_lids(space, skin, targets, side, place, own)


def _mend_lids(
    space: HeadSpace,
    skin: Floats,
    targets: dict[str, Floats],
    side: str,
    place: EyePlace,
    own: Mapping[str, Floats],
) -> None:
    lids: Seam = lid_seam(side)
    blink = "eyeBlink" + side
    near = _near_eye(space, side)
    wanted = lids.gaps(space.rest + own[blink])
    for _ in range(3):
        targets[blink] = targets[blink] + lids.closing(skin + targets[blink], wanted)
        for name in (kind + side for kind in _MOVING_LIDS):
            moving = (np.abs(targets[name][near]).max(axis=1) > 1e-9)[:, None]
            for weight in np.linspace(0.1, 1.0, 10):
                points = skin[near] + weight * targets[name][near]
                targets[name][near] += moving * _pushed_out(points, place, 0.8 * _AIR) / weight


# ------------------------------------------------------------------ the other parts


def _part(
    space: HeadSpace,
    part: Part,
    skin: Floats,
    jacobians: Floats,
    targets: Mapping[str, Floats],
    places: Mapping[str, EyePlace],
    warp: SmoothWarp,
) -> Part:
    if part.name == SKIN:
        found = {name: sparse_target(offsets) for name, offsets in targets.items()}
        kept = {name: target for name, target in found.items() if target is not None}
        return replace(part, vertices=skin.astype(np.float32), targets=kept)
    for eye in space.face.eyes:
        if eye.part == part.name:
            place = places[eye.side]
            scale = place.radius / _radius(space.face, eye)
            vertices = np.array(place.centre) + scale * (part.vertices - np.array(eye.centre))
            return replace(part, vertices=vertices.astype(np.float32))
    if part.name in _RIGID:
        return _scaled(space, part, skin)
    if part.name in _BOUND:
        return _bound(space, part, skin, jacobians, targets)
    moved = warp(part.vertices.astype(np.float64))
    return replace(part, vertices=moved.astype(np.float32), targets=_turned(space, part, jacobians))


def _turned(space: HeadSpace, part: Part, jacobians: Floats) -> dict[str, Target]:
    """The part's targets, turned and scaled as the nearest skin's are."""
    nearest = cKDTree(space.rest).query(part.vertices)[1]
    return {
        name: replace(
            target,
            offsets=np.einsum("nij,nj->ni", jacobians[nearest[target.vertices]], target.offsets).astype(np.float32),
        )
        for name, target in part.targets.items()
    }


def _scaled(space: HeadSpace, part: Part, skin: Floats) -> Part:
    """Teeth and tongue: moved and scaled, one number, as the lips and the mouth's inside are; never turned."""
    around = np.flatnonzero((space.lips > 0.3) | ((space.inside_mouth > 0.5) & (space.rest[:, 2] > -10)))
    before, after = space.rest[around], skin[around]
    a, b = before.mean(0), after.mean(0)
    scale = float(np.sqrt(((after - b) ** 2).sum() / ((before - a) ** 2).sum()))
    targets = {
        name: replace(target, offsets=(scale * target.offsets).astype(np.float32))
        for name, target in part.targets.items()
    }
    return replace(part, vertices=(b + scale * (part.vertices - a)).astype(np.float32), targets=targets)


def _bound(space: HeadSpace, part: Part, skin: Floats, jacobians: Floats, targets: Mapping[str, Floats]) -> Part:
    """Lashes, brows: each vertex keeps its place over the skin next to it, and moves with that as it did."""
    nearest = cKDTree(space.rest).query(part.vertices, k=4)
    share = 1 / np.maximum(nearest[0], 0.2) ** 2
    share /= share.sum(axis=1, keepdims=True)
    near = nearest[1]
    arm = part.vertices[:, None, :] - space.rest[near]
    placed = skin[near] + np.einsum("nkij,nkj->nki", jacobians[near], arm)
    vertices = (share[:, :, None] * placed).sum(axis=1)
    turned = np.einsum("nk,nkij->nij", share, jacobians[near])
    own = dense_targets(space)
    moved = {}
    for name, target in part.targets.items():
        offsets = np.zeros((len(part.vertices), 3))
        offsets[target.vertices] = target.offsets
        offsets = np.einsum("nij,nj->ni", turned, offsets)
        if name in targets:
            mended = targets[name] - np.einsum("nij,nj->ni", jacobians, own[name])
            offsets += (share[:, :, None] * mended[near]).sum(axis=1)
        found = sparse_target(offsets)
        if found is not None:
            moved[name] = found
    return replace(part, vertices=vertices.astype(np.float32), targets=moved)
