"""The shape of a head from points in photographs of it.

First the weights of the space of heads and one pinhole camera for each photograph together, by robust least squares
under the space's prior and a prior on focal lengths. Then what the points still ask for, as a smooth displacement: a
Gaussian process whose kernel favours displacements that are alike on both sides (Luethi, Gerig, Jud, Vetter 2018,
"Gaussian process morphable models"), conditioned on the points through the cameras' Jacobians.

Photographs say nothing about size: the head gets that of the mean head, or the given distance between the eyes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.distance import cdist

from mien.core.errors import InputError, Note
from mien.face.contact import dense_targets
from mien.face.head_space import HeadSpace
from mien.fit.photo_camera import PhotoCamera, find_camera
from mien.fit.photo_marks import Photo, mirrored_marks

__all__ = ["PhotoFit", "PhotoFitSettings", "shape_from_photos"]

Floats = NDArray[np.float64]

_FRONT_DEGREES, _SIDE_DEGREES = 30.0, 20.0
_MIRROR_SHARE = 0.6
_POOR_SHARE = 0.05  # of the face's size in the picture: a worse fit is no fit
_ODD_SIGMAS, _REFUSED_SIGMAS = 5.0, 30.0


_EXPRESSIONS = {
    "smile": ("mouthSmileLeft", "mouthSmileRight"), "open mouth": ("jawOpen",),
    "raised brows": ("browInnerUp", "browOuterUpLeft", "browOuterUpRight"),
    "shut eyes": ("eyeBlinkLeft", "eyeBlinkRight"),
}  # fmt: skip
_USUAL, _SHOWN = 0.35, 0.25  # weight of one standard deviation; from where on an expression is taken to be one


@dataclass(frozen=True)
class PhotoFitSettings:
    """How freely the head is shaped.

    Attributes
    ----------
    components : int
        Of the space of heads.
    smooth_mm : tuple of (float, float)
        Standard deviation and length of each kernel of the last displacement, mm: broad ones and narrow ones.
    even : float
        Share of that displacement's variance that is alike on both sides, 0..1.
    """

    components: int = 40
    smooth_mm: tuple[tuple[float, float], ...] = ((2.0, 45.0), (1.2, 18.0))
    even: float = 0.85


@dataclass(frozen=True, eq=False)
class PhotoFit:
    """The result of `shape_from_photos`.

    Attributes
    ----------
    vertices : ndarray, shape (n, 3)
        The default skin's vertices on this head, mm.
    weights : ndarray, shape (k,)
        In the space of heads.
    cameras : tuple of PhotoCamera
    residuals : tuple of float
        RMS distance of each photograph's points, pixels, after the fit.
    notes : tuple of Note
    posed : ndarray, shape (n, 3)
        The same with the expression that the photographs show, mm.
    """

    vertices: Floats
    weights: Floats
    cameras: tuple[PhotoCamera, ...]
    residuals: tuple[float, ...]
    notes: tuple[Note, ...]
    posed: Floats


def shape_from_photos(
    space: HeadSpace,
    photos: Sequence[Photo],
    eye_distance: float | None = None,
    settings: PhotoFitSettings | None = None,
) -> PhotoFit:
    """Shape a head after photographs.

    Parameters
    ----------
    space : HeadSpace
    photos : sequence of Photo
        The first from the front (up to 30 degrees off), further ones from elsewhere.
    eye_distance : float, optional
        Between the eyeballs' centres, mm; the mean head's if not given.
    settings : PhotoFitSettings, optional

    Raises
    ------
    InputError
        If the first photograph is not from the front, all are, sides are swapped, or points do not fit a head.
    """
    settings = settings or PhotoFitSettings()
    mean = space.shape([0.0])
    cameras, notes = _first_cameras(mean, photos)
    plain, start = space, cameras
    space, settings, shown = _with_expression(plain, photos, cameras, settings)
    weights, cameras = _fitted(space, photos, start, settings)
    photos, more = _without_odd_points(space, photos, cameras, weights)
    notes += more
    if more:
        weights, cameras = _fitted(space, photos, cameras, settings)
    count = len(weights) - len(shown)
    expression = np.tensordot(weights[count:], space.components[count : len(weights)].astype(np.float64), axes=1)
    notes += _told_expression(photos[0].name, dict(zip(shown, _USUAL * weights[count:], strict=True)))
    shape = space.shape(weights)
    shape = shape + _displacement(space, shape, photos, cameras, settings)
    residuals = tuple(
        float(np.sqrt(((camera.seen(shape[photo.vertices])[0] - photo.pixels) ** 2).sum(1).mean()))
        for camera, photo in zip(cameras, photos, strict=True)
    )
    size = 1.0 if eye_distance is None else eye_distance / _eye_distance(space, shape)
    cameras = [replace(camera, shift=size * camera.shift) for camera in cameras]
    neutral = size * (shape - expression)
    return PhotoFit(neutral, weights[:count], tuple(cameras), residuals, tuple(notes), size * shape)


# ------------------------------------------------------------------ expressions


def _with_expression(
    space: HeadSpace, photos: Sequence[Photo], cameras: Sequence[PhotoCamera], settings: PhotoFitSettings
) -> tuple[HeadSpace, PhotoFitSettings, tuple[str, ...]]:
    """The space of heads with those expressions as further components that the photographs show, and their names."""
    wide, wider = _extended(space, settings, tuple(_EXPRESSIONS))
    weights, _ = _fitted(wide, photos, cameras, wider)
    values = _USUAL * weights[settings.components :]
    shown = tuple(name for name, value in zip(_EXPRESSIONS, values, strict=True) if value > _SHOWN)
    return (*_extended(space, settings, shown), shown) if shown else (space, settings, ())


def _extended(
    space: HeadSpace, settings: PhotoFitSettings, names: tuple[str, ...]
) -> tuple[HeadSpace, PhotoFitSettings]:
    moves = dense_targets(space)
    more = [_USUAL * sum(moves[channel] for channel in _EXPRESSIONS[name]) for name in names]
    components = np.concatenate([space.components[: settings.components], np.array(more, dtype=np.float32)])
    return replace(space, components=components), replace(settings, components=len(components))


def _told_expression(name: str, shown: Mapping[str, float]) -> list[Note]:
    if not shown:
        return []
    told = ", ".join(f"{word} {max(value, 0.0):.1f}" for word, value in shown.items())
    return [Note("warning", f"{name} shows an expression ({told}): taken out of the shape; one at rest serves better")]


def _eye_distance(space: HeadSpace, shape: Floats) -> float:
    return float(np.linalg.norm(shape[space.lid_loop_left].mean(0) - shape[space.lid_loop_right].mean(0)))


# ------------------------------------------------------------------ what the photographs show


def _first_cameras(mean: Floats, photos: Sequence[Photo]) -> tuple[list[PhotoCamera], list[Note]]:
    cameras = []
    for photo in photos:
        height, width, _ = photo.picture.shape
        sigma = 2 * float(np.median(photo.sigma))
        camera, left = find_camera(width, height, mean[photo.vertices], photo.pixels, sigma)
        _, mirrored = find_camera(width, height, mean[mirrored_marks(photo)], photo.pixels, sigma)
        size = float(np.linalg.norm(np.ptp(photo.pixels, axis=0)))
        if mirrored < _MIRROR_SHARE * left and left > 0.012 * size:
            raise InputError(
                f"{photo.name}: left and right are swapped in its landmarks (left is the person's own), "
                "or the picture is mirrored"
            )
        if not left <= _POOR_SHARE * size:
            raise InputError(
                f"{photo.name}: its landmarks fit no head ({left:.0f} pixels off): are they of this "
                "picture, in pixels from its upper left corner?"
            )
        cameras.append(camera)
    return cameras, _check_views(photos, cameras)


def _check_views(photos: Sequence[Photo], cameras: Sequence[PhotoCamera]) -> list[Note]:
    front = cameras[0].yaw()
    if abs(front) > _FRONT_DEGREES:
        seen = "the person's left" if front > 0 else "the person's right"
        raise InputError(f"{photos[0].name}: the first photograph has to be from the front, this one is from {seen}")
    if len(photos) == 1:
        told = "one photograph from the front: depth (nose, chin, back of the head) is guessed from other heads"
        return [Note("warning", told)]
    notes = []
    for photo, camera in zip(photos[1:], cameras[1:], strict=True):
        if abs(camera.yaw() - front) < _SIDE_DEGREES:
            told = (
                f"{photo.name} is from the front too ({abs(camera.yaw() - front):.0f} degrees apart): it adds no depth"
            )
            notes.append(Note("warning", told))
    return notes


def _without_odd_points(
    space: HeadSpace, photos: Sequence[Photo], cameras: Sequence[PhotoCamera], weights: Floats
) -> tuple[list[Photo], list[Note]]:
    """Points that lie far from where all others put them are left out; named landmarks very far off are refused."""
    shape = space.shape(weights)
    kept, notes = [], []
    for photo, camera in zip(photos, cameras, strict=True):
        away = np.linalg.norm(camera.seen(shape[photo.vertices])[0] - photo.pixels, axis=1)
        usual = max(float(np.median(away)), float(np.median(photo.sigma)))
        odd = away > np.maximum(_ODD_SIGMAS * photo.sigma, 4 * usual)
        worst = int(np.argmax(away / photo.sigma))
        if odd[worst] and away[worst] > _REFUSED_SIGMAS * photo.sigma[worst]:
            raise InputError(
                f"{photo.name}: {photo.names[worst]} lies {away[worst]:.0f} pixels from where the other landmarks "
                "put it"
            )
        for number in np.flatnonzero(odd):
            told = f"{photo.name}: {photo.names[number]} lies {away[number]:.0f} pixels off and is left out"
            notes.append(Note("warning", told))
        names = tuple(name for name, out in zip(photo.names, odd, strict=True) if not out)
        kept.append(
            replace(
                photo, names=names, vertices=photo.vertices[~odd], pixels=photo.pixels[~odd], sigma=photo.sigma[~odd]
            )
        )
    return kept, notes


# ------------------------------------------------------------------ weights and cameras together


def _fitted(
    space: HeadSpace, photos: Sequence[Photo], cameras: Sequence[PhotoCamera], settings: PhotoFitSettings
) -> tuple[Floats, list[PhotoCamera]]:
    count = settings.components
    bases = [space.components[:count, photo.vertices].astype(np.float64) for photo in photos]
    means = [(space.rest + space.mean)[photo.vertices] for photo in photos]

    def own_of(numbers: Floats, i: int) -> Floats:
        return numbers[count + 7 * i : count + 7 * i + 7]

    def points_of(numbers: Floats, i: int) -> Floats:
        return np.asarray(means[i] + np.tensordot(numbers[:count], bases[i], axes=1))

    def share(photo: Photo) -> Floats:
        return np.asarray(_fewer(photo) / np.repeat(photo.sigma, 2))

    def gaps(numbers: Floats) -> Floats:
        rows = [numbers[:count]]
        for i, photo in enumerate(photos):
            own = own_of(numbers, i)
            rows.append(np.array([cameras[i].focal_gap(own)]))
            seen = cameras[i].of(own).seen(points_of(numbers, i))[0]
            rows.append((seen - photo.pixels).ravel() * share(photo))
        return np.concatenate(rows)

    def slopes(numbers: Floats) -> Floats:
        """Of the gaps, by the weights in closed form, by each camera's seven numbers by differences."""
        blocks = [np.hstack([np.eye(count), np.zeros((count, len(numbers) - count))])]
        for i, photo in enumerate(photos):
            own, points = own_of(numbers, i), points_of(numbers, i)
            at = slice(count + 7 * i, count + 7 * i + 7)
            prior, block = np.zeros((1, len(numbers))), np.zeros((2 * len(points), len(numbers)))
            prior[0, count + 7 * i + 6] = cameras[i].focal_gap(own + np.eye(7)[6]) - cameras[i].focal_gap(own)
            moves = cameras[i].of(own).slopes(points)
            block[:, :count] = np.einsum("nij,knj->nik", moves, bases[i]).reshape(-1, count)
            steps = 1e-5 * np.eye(7)
            for k, step in enumerate(steps):
                ahead, behind = (cameras[i].of(own + sign * step).seen(points)[0] for sign in (1, -1))
                block[:, at.start + k] = (ahead - behind).ravel() / 2e-5
            blocks += [prior, block * share(photo)[:, None]]
        return np.concatenate(blocks)

    start = np.concatenate([np.zeros(count), *(camera.numbers() for camera in cameras)])
    found = least_squares(gaps, start, slopes, loss="soft_l1", f_scale=2.5, max_nfev=60, x_scale="jac")
    return np.asarray(found.x[:count]), [camera.of(own_of(found.x, i)) for i, camera in enumerate(cameras)]


def _fewer(photo: Photo) -> float:
    """Hundreds of tracked points are not independent: together they count as forty."""
    return float(np.sqrt(min(1.0, 40.0 / len(photo.vertices))))


# ------------------------------------------------------------------ what is left


def _kernel(a: Floats, b: Floats, settings: PhotoFitSettings) -> Floats:
    """Covariances (3 len(a), 3 len(b)) of displacements at places of the face, mm^2."""
    mirror = np.array([-1.0, 1.0, 1.0])
    near, across = cdist(a, b), cdist(a, b * mirror)
    own, other = (
        sum(s**2 * np.exp(-((d / length) ** 2) / 2) for s, length in settings.smooth_mm) for d in (near, across)
    )
    alike = settings.even / 2 * (np.kron(own, np.eye(3)) + np.kron(other, np.diag(mirror)))
    return np.asarray(alike + (1 - settings.even) * np.kron(own, np.eye(3)))


def _displacement(
    space: HeadSpace,
    shape: Floats,
    photos: Sequence[Photo],
    cameras: Sequence[PhotoCamera],
    settings: PhotoFitSettings,
) -> Floats:
    """The mean of the Gaussian process given the points, at every vertex of the skin, mm."""
    marks = np.unique(np.concatenate([photo.vertices for photo in photos]))
    rows, right = [], []
    for photo, camera in zip(photos, cameras, strict=True):
        seen, _ = camera.seen(shape[photo.vertices])
        slopes = camera.slopes(shape[photo.vertices])
        column = np.searchsorted(marks, photo.vertices)
        weight = _fewer(photo) / photo.sigma
        for i in range(len(photo.vertices)):
            row = np.zeros((2, 3 * len(marks)))
            row[:, 3 * column[i] : 3 * column[i] + 3] = slopes[i] * weight[i]
            rows.append(row)
            right.append((photo.pixels[i] - seen[i]) * weight[i])
    design, wanted = np.concatenate(rows), np.concatenate(right)
    places = space.rest[marks]
    prior = _kernel(places, places, settings)
    system = design @ prior @ design.T + np.eye(len(design))
    pull = design.T @ np.linalg.solve(system, wanted)
    moved = np.concatenate(
        [_kernel(space.rest[first : first + 4096], places, settings) @ pull for first in range(0, len(shape), 4096)]
    )
    return moved.reshape(-1, 3)
