"""Points of the face in photographs: named landmarks from a file, or what the face tracker finds.

A file gives pixels from the upper left corner of the upright picture: ``name,x,y`` (CSV), ``{"chin": [310, 520]}``
(JSON) or ``chin = [310, 520]`` (TOML); names are those of `mien.fit.landmarks`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, MissingPartError
from mien.face.head_space import head_space
from mien.fit.landmarks import known_landmarks, other_side, read_landmarks

__all__ = ["Photo", "marks_from_file", "marks_from_tracker", "mirrored_marks"]

Floats = NDArray[np.float64]

_LEAST = 6
_TRACKER_SIGMA, _FILE_SIGMA = 0.012, 0.004  # of the face's size in the picture: what points may be off
# Contour of the tracked face: it slides round the head as it turns, so it says little.
_OVAL = frozenset({
    10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377,
    152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109,
})  # fmt: skip


@dataclass(frozen=True, eq=False)
class Photo:
    """A photograph with its points.

    Attributes
    ----------
    name : str
        Of its file.
    picture : ndarray of uint8, shape (height, width, 3)
        sRGB, upright.
    names : tuple of str
        Of the points.
    vertices : ndarray of int64, shape (m,)
        Of the default skin.
    pixels : ndarray, shape (m, 2)
    sigma : ndarray, shape (m,)
        What each may be off, pixels.
    """

    name: str
    picture: NDArray[np.uint8]
    names: tuple[str, ...]
    vertices: NDArray[np.int64]
    pixels: Floats
    sigma: Floats


def _size(pixels: Floats) -> float:
    return float(np.linalg.norm(pixels.max(0) - pixels.min(0)))


def marks_from_file(name: str, picture: NDArray[np.uint8], path: str | Path) -> Photo:
    """A photograph with the landmarks of a file.

    Raises
    ------
    InputError
        If the file cannot be read, gives too few, or a point lies outside the picture.
    """
    return named_marks(name, picture, read_landmarks(path, width=2), str(path))


def named_marks(name: str, picture: NDArray[np.uint8], given: Mapping[str, tuple[float, ...]], where: str) -> Photo:
    """A photograph with landmarks by name."""
    height, width, _ = picture.shape
    if len(given) < _LEAST:
        raise InputError(f"{where}: {len(given)} landmarks for {name}; at least {_LEAST} are needed")
    for key, (x, y) in given.items():
        if not (-1 <= x <= width + 1 and -1 <= y <= height + 1):
            raise InputError(
                f"{where}: {key} at {x:g}, {y:g} lies outside {name}, which is {width} x {height} pixels upright"
            )
    names = tuple(given)
    pixels = np.array([given[key] for key in names], dtype=np.float64)
    if not np.linalg.svd(pixels - pixels.mean(0), compute_uv=False)[1] > 1e-3 * _size(pixels):
        raise InputError(f"{where}: the landmarks of {name} lie on one point or line")
    vertices = np.array([known_landmarks()[key].vertex for key in names], dtype=np.int64)
    sigma = np.full(len(names), max(_FILE_SIGMA * _size(pixels), 0.5))
    return Photo(name, picture, names, vertices, pixels, sigma)


def mirrored_marks(photo: Photo) -> NDArray[np.int64]:
    """The vertices that the points would have if left and right were exchanged."""
    if photo.names[0] in known_landmarks():
        return np.array([known_landmarks()[other_side(name)].vertex for name in photo.names], dtype=np.int64)
    rest = head_space().rest
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(rest).query(rest[photo.vertices] * [-1, 1, 1])[1], dtype=np.int64)


@cache
def _tracked() -> tuple[tuple[str, ...], NDArray[np.int64], NDArray[np.int64], Floats]:
    """Names, numbers among the tracker's points, vertices of the default skin, and how much looser than others."""
    from scipy.spatial import cKDTree

    from mien.capture.layouts import load_layout

    layout = load_layout("mediapipe-218")
    space = head_space()
    outer = np.flatnonzero(space.outer() | (space.socket > 0))
    tree = cKDTree(space.rest[outer])
    names, numbers, vertices, loose = [], [], [], []
    for number, name in layout.landmarks.items():
        if number >= 468:  # irises lie on the eyeballs
            continue
        away, near = tree.query(layout.place(name))
        if away > 4.0:
            continue
        names.append(name)
        numbers.append(number)
        vertices.append(outer[near])
        loose.append(4.0 if number in _OVAL else 1.0)
    return tuple(names), np.array(numbers), np.array(vertices, dtype=np.int64), np.array(loose)


def marks_from_tracker(name: str, picture: NDArray[np.uint8]) -> Photo:
    """A photograph with the points that the face tracker finds in it.

    Raises
    ------
    InputError
        If no face is found.
    MissingPartError
        If the tracker is not installed.
    """
    from mien.capture.tracker import shared_tracker

    try:
        found = shared_tracker().landmarks([picture])[0]
    except MissingPartError as problem:
        raise MissingPartError(f"{name}: no landmarks given, and {problem}; or give --landmarks") from problem
    if not np.isfinite(found).all():
        raise InputError(
            f"{name}: no face found in it (profiles are not): give its landmarks in a file with --landmarks"
        )
    names, numbers, vertices, loose = _tracked()
    pixels = found[numbers, :2]
    return Photo(name, picture, names, vertices, pixels, loose * max(_TRACKER_SIGMA * _size(pixels), 0.7))
