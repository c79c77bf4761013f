"""What lies before the face in a photograph from the front: hair over the forehead, glasses.

Both would be painted on the skin. The forehead is held against the cheek of its own side, in lightness and in colour;
glasses show as an edge across the bridge of the nose together with edges below the eyes, where skin changes smoothly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import Note
from mien.face.head_space import HeadSpace
from mien.fit.photo_camera import PhotoCamera

__all__ = ["obstacles"]

Floats = NDArray[np.float64]

_FAR_LIGHT, _FAR_COLOUR = 0.65, 0.06  # of what differs from a cheek: natural logarithm of light; share of red or green
_COVERED = 0.25  # of the forehead
_STEP_MM, _EDGE = 2.0, 0.22  # rows across the bridge; how far a row leaves the parabola through all, in log light


def obstacles(
    space: HeadSpace, skin: Floats, picture: NDArray[np.uint8], camera: PhotoCamera, name: str
) -> tuple[Note, ...]:
    """Warnings about what covers the face.

    Parameters
    ----------
    space : HeadSpace
    skin : ndarray, shape (n, 3)
        The default skin as it stands in the photograph, mm.
    picture : ndarray of uint8, shape (height, width, 3)
    camera : PhotoCamera
    name : str
        Of the photograph.
    """
    x, y, z = space.rest.T
    front = space.outer() & (z > 0)
    notes = []
    share = _covered(x, y, front, lambda chosen: _looked(skin[chosen], picture, camera))
    if share > _COVERED:
        told = f"{name}: hair or a hat covers about {share:.0%} of the forehead and is painted on it: brush it back"
        notes.append(Note("warning", told))

    def edge(left: float, right: float, low: float, high: float) -> float:
        chosen = front & (x > left) & (x < right) & (y > low) & (y < high)
        return _edge(y[chosen], _looked(skin[chosen], picture, camera))

    rims = edge(20, 38, -36, -15), edge(-38, -20, -36, -15)
    if min(edge(-5, 5, -16, 12), max(rims)) > _EDGE:
        notes.append(Note("warning", f"{name}: there seem to be glasses, which are painted on the skin: take them off"))
    return tuple(notes)


def _looked(points: Floats, picture: NDArray[np.uint8], camera: PhotoCamera) -> Floats:
    """Colours, 0..1, where points are seen; black where the picture ends."""
    column, row = np.rint(camera.seen(points)[0]).astype(int).T
    height, width = picture.shape[:2]
    inside = (column >= 0) & (row >= 0) & (column < width) & (row < height)
    found = picture[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)] / 255
    return np.where(inside[:, None], found, 0.0)


def _light(colours: Floats) -> Floats:
    return np.asarray(np.log(np.maximum(colours.mean(axis=1), 0.01)))


def _covered(x: Floats, y: Floats, front: NDArray[np.bool_], look) -> float:  # type: ignore[no-untyped-def]
    """Share of the forehead that looks like no skin of this face."""
    far = []
    for side in (1.0, -1.0):
        half = front & (side * x > 0)
        cheek = look(half & (np.abs(x) > 18) & (np.abs(x) < 42) & (y > -48) & (y < -24))
        forehead = look(half & (np.abs(x) < 32) & (y > 24) & (y < 52))
        lighter = np.abs(_light(forehead) - np.median(_light(cheek)))
        hue, usual = (c / np.maximum(c.sum(axis=1, keepdims=True), 0.02) for c in (forehead, cheek))
        tinted = np.abs(hue - np.median(usual, axis=0))[:, :2].max(axis=1)
        far.append((lighter > _FAR_LIGHT) | (tinted > _FAR_COLOUR))
    return float(np.concatenate(far).mean())


def _edge(height: Floats, colours: Floats) -> float:
    """How far a row of skin is from a smooth course of light down the face."""
    row = np.floor(height / _STEP_MM).astype(int)
    rows = np.unique(row)
    if len(rows) < 5:
        return 0.0
    light = np.array([np.median(_light(colours[row == each])) for each in rows])
    course = np.polynomial.polynomial.Polynomial.fit(rows, light, 2)
    return float(np.abs(light - course(rows)).max())
