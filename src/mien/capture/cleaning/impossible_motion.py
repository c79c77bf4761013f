"""Guesses at units and axes from what a face looks like."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.groups import MarkerGroups
from mien.capture.cleaning.repairs import complete
from mien.core.tracks import MarkerTrack

__all__ = ["UNITS", "extent", "guess_axes", "guess_units", "say_axes"]

UNITS = {"millimetres": 1.0, "metres": 1000.0, "centimetres": 10.0}
"""Millimetres per unit, by the name of the unit."""
# Diagonal of the box around a marker set: from a mouth alone to a head with a cap.
_SMALLEST, _LARGEST = 40.0, 400.0
_SURE = 0.5  # cosine that an axis of the face must have with the axis it is taken for


def extent(track: MarkerTrack) -> float:
    """Median over the frames of the diagonal of the box around all seen markers; 0 if fewer than two are ever seen."""
    seen = complete(track.positions)
    frames = np.flatnonzero(seen.sum(axis=1) >= 2)
    if not frames.size:
        return 0.0
    some = np.where(seen[:, :, None], track.positions, np.nan)[frames]
    return float(np.median(np.linalg.norm(np.nanmax(some, axis=1) - np.nanmin(some, axis=1), axis=1)))


def guess_units(track: MarkerTrack) -> str | None:
    """Name of the unit in which the markers make a face of human size, or None if none does.

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> guess_units(MarkerTrack(("brow", "chin"), [[[0.0, 0.12, 0.0], [0.0, 0.0, 0.0]]], FrameRate.of(120)))
    'metres'
    """
    size = extent(track)
    for name, factor in UNITS.items():
        if _SMALLEST <= size * factor <= _LARGEST:
            return name
    return None


def guess_axes(track: MarkerTrack, groups: MarkerGroups) -> NDArray[np.float64] | None:
    """The signed permutation that turns the axes of a track into mien's: ``mien = matrix @ recorded``.

    The line between the eyes gives x, from the mouth to the eyes y, and how far the nose stands out of the two z; the
    median over the frames counts, so the head may turn.

    Returns
    -------
    ndarray, shape (3, 3), or None
        With determinant -1 if the file's axes are left-handed (or left and right are exchanged). None if a
        marker is missing or the face stands askew to all axes.
    """
    roles = (groups.left_eye, groups.right_eye, groups.upper_lip, groups.lower_lip, groups.nose)
    if any(role not in track.names for role in roles):
        return None
    points = track.positions[:, [track.names.index(role) for role in roles]]
    whole = points[complete(points, 2)]
    if not len(whole):
        return None
    left, right, upper, lower, nose = whole.transpose(1, 0, 2)
    eyes, mouth = (left + right) / 2, (upper + lower) / 2
    x = _unit(np.median(left - right, axis=0))
    y = np.median(eyes - mouth, axis=0)
    y = _unit(y - x * (x @ y))
    z = np.median(nose - (eyes + mouth) / 2, axis=0)
    z = _unit(z - x * (x @ z) - y * (y @ z))
    face = np.stack([x, y, z])
    best = max(_signed_permutations(), key=lambda matrix: float((matrix * face).sum()))
    if not np.isfinite(face).all() or float((best * face).sum(axis=1).min()) < _SURE:
        return None
    return best


def say_axes(matrix: NDArray[np.float64]) -> str:
    """Say a signed permutation, as in ``x is -z of the file``.

    Examples
    --------
    >>> say_axes(np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    'x is x, y is z, z is -y of the file'
    """
    parts = []
    for axis, row in zip("xyz", matrix, strict=True):
        column = int(np.argmax(np.abs(row)))
        parts.append(f"{axis} is {'-' if row[column] < 0 else ''}{'xyz'[column]}")
    return ", ".join(parts) + " of the file"


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else np.full(3, np.nan)


def _signed_permutations() -> list[NDArray[np.float64]]:
    # The identity comes first, so that it wins a tie.
    return [
        np.diag(np.array(signs))[list(order)]
        for signs in product((1.0, -1.0), repeat=3)
        for order in permutations(range(3))
    ]
