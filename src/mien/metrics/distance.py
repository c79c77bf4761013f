"""Distance between recorded and synthesised markers.

Conventions
-----------
Positions are arrays of shape (frames, markers, 3) in millimetres, one frame of the one for one frame of the other;
the head's own motion is already taken out of both. Which frames count is chosen before (`mien.metrics.scored_takes`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["marker_rms", "squared_distances", "validate"]

Array = NDArray[np.float64]


def validate(recorded: Array, synthesised: Array) -> None:
    """Refuse positions that cannot be compared.

    Raises
    ------
    InputError
        If the shapes differ or are not (frames, markers, 3), there is no frame, or a number is not finite.
    """
    if recorded.shape != synthesised.shape or recorded.ndim != 3 or recorded.shape[2] != 3:
        raise InputError(
            f"expected two arrays of one shape (frames, markers, 3), got {recorded.shape} and {synthesised.shape}"
        )
    if not recorded.size:
        raise InputError(f"expected at least one frame and one marker to compare, got shape {recorded.shape}")
    for name, positions in (("recorded", recorded), ("synthesised", synthesised)):
        bad = ~np.isfinite(positions).all(axis=(1, 2))
        if bad.any():
            raise InputError(f"{name} positions: not finite in {bad.sum()} frames, first in frame {bad.argmax()}")


def squared_distances(recorded: Array, synthesised: Array) -> Array:
    """Squared 3D distance of every marker in every frame, shape (frames, markers), mm²."""
    validate(recorded, synthesised)
    return np.asarray(((recorded - synthesised) ** 2).sum(axis=2))


def marker_rms(recorded: Array, synthesised: Array) -> float:
    """Root of the mean squared 3D distance over markers and frames, in mm.

    Raises
    ------
    InputError
        As `validate`.

    Examples
    --------
    Every marker off by (3, 0, 4) mm:

    >>> marker_rms(np.zeros((10, 2, 3)), np.zeros((10, 2, 3)) + [3.0, 0.0, 4.0])
    5.0
    """
    return float(np.sqrt(squared_distances(recorded, synthesised).mean()))
