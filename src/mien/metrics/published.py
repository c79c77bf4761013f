"""Measures of the talking-head literature, with the definitions of their authors.

Conventions
-----------
Positions are arrays of shape (frames, vertices, 3) in millimetres, as in `mien.metrics.distance`. Markers stand for
the vertices of the papers, so that figures here compare with one another and not with those on a dense mesh.

Sources
-------
Xing, Xia, Zhang, Cun, Wang, Wong 2023: CodeTalker, section 4.2 (lip-vertex error, upper-face dynamics deviation).
TorchMetrics 1.8, ``LipVertexError``. Richard et al. 2021 (MeshTalk) first used the maximum over the lips, not squared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.metrics.distance import squared_distances, validate
from mien.metrics.trajectory import rms_error

__all__ = ["lip_vertex_error", "mouth_opening_difference", "upper_face_dynamics", "upper_face_dynamics_deviation"]

Array = NDArray[np.float64]


def lip_vertex_error(recorded: Array, synthesised: Array) -> float:
    """Maximum over the lip vertices of the *squared* 3D distance, mean over frames, in mm².

    The definition of CodeTalker's code and of TorchMetrics. Give the lip vertices only.

    Raises
    ------
    InputError
        If the positions cannot be compared.

    Examples
    --------
    One of two vertices off by 2 mm in one of two frames:

    >>> recorded = np.zeros((2, 2, 3)); synthesised = np.zeros((2, 2, 3)); synthesised[0, 1, 1] = 2.0
    >>> lip_vertex_error(recorded, synthesised)
    2.0
    """
    return float(squared_distances(recorded, synthesised).max(axis=1).mean())


def upper_face_dynamics(positions: Array, rest: Array, *, squared: bool = False) -> Array:
    """How much each vertex's displacement from rest varies over time (standard deviation), shape (vertices,).

    Parameters
    ----------
    positions : ndarray, shape (frames, vertices, 3)
    rest : ndarray, shape (vertices, 3)
        The neutral face.
    squared : bool
        The length of the displacement as in CodeTalker's paper (mm), or squared as in its code (mm²).
    """
    if positions.ndim != 3 or rest.shape != positions.shape[1:]:
        raise InputError(f"expected a rest of shape {positions.shape[1:]} (vertices, 3), got {rest.shape}")
    lengths = ((positions - rest) ** 2).sum(axis=2)
    return np.asarray((lengths if squared else np.sqrt(lengths)).std(axis=0))


def upper_face_dynamics_deviation(
    recorded: Array, synthesised: Array, rest: Array, *, squared: bool = False
) -> tuple[float, float]:
    """Mean over upper-face vertices of the recorded less the synthesised dynamics: signed, and absolute.

    The signed one is CodeTalker's FDD: there vertices that move too much cancel those that move too little, which
    the absolute one does not allow. Above zero the synthesised face moves too little.

    Returns
    -------
    signed, absolute : float
        mm, or mm² if ``squared`` (as in CodeTalker's code).

    Raises
    ------
    InputError
        If the positions cannot be compared.

    Examples
    --------
    One vertex of two swings and should not, the other should and does not:

    >>> recorded = np.zeros((2, 2, 3)); synthesised = np.zeros((2, 2, 3))
    >>> recorded[1, 0, 0] = 2.0; synthesised[1, 1, 0] = 2.0
    >>> upper_face_dynamics_deviation(recorded, synthesised, np.zeros((2, 3)))
    (0.0, 1.0)
    """
    validate(recorded, synthesised)
    difference = upper_face_dynamics(recorded, rest, squared=squared) - upper_face_dynamics(
        synthesised, rest, squared=squared
    )
    return float(difference.mean()), float(np.abs(difference).mean())


def mouth_opening_difference(recorded: Array, synthesised: Array) -> float:
    """RMS of the difference of two curves of lip opening, in mm.

    Examples
    --------
    >>> mouth_opening_difference(np.array([1.0, 5.0]), np.array([2.0, 4.0]))
    1.0
    """
    return rms_error(recorded, synthesised)
