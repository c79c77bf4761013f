"""The recorded person's head: weights of the space of heads and a similarity, fitted to the markers at rest together.

Alternately the similarity that lays the markers on the head (Umeyama 1991) and the weights under the space's prior
(a head of unit variance in each component is as likely as any other). Markers are correlated: together they count as
`_COUNT`. Silhouettes (what lies on the rim of the face) tell least, since a tracker draws them where the picture ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import best_similarity
from mien.capture.knowledge import Source
from mien.face.head_space import HeadSpace
from mien.face.marker_sites import Placed

__all__ = ["Head", "fit_head_to_markers"]

Floats = NDArray[np.float64]

_COMPONENTS = 30
_COUNT = 60.0
_MISFIT_MM = 2.0  # between a marker's place on a person and on the head of the space that is most like theirs
_RIM_SHARE = 0.15
_DEPTH_SHARE = 0.3  # of height's weight in a tracker's shape at rest
_ROUNDS = 12


@dataclass(frozen=True, eq=False)
class Head:
    """A head of the space.

    Attributes
    ----------
    weights : ndarray, shape (components,)
        Standard deviations.
    skin : ndarray, shape (n, 3)
        The default skin's vertices on it, mm.
    residual : float
        Root mean square distance of the markers from their places on it, mm of the head.
    """

    weights: Floats
    skin: Floats
    residual: float


def fit_head_to_markers(
    space: HeadSpace, placed: Placed, rest: Floats, source: Source, on_rim: NDArray[np.bool_]
) -> Head:
    """Fit the head of a person to their markers at rest.

    Parameters
    ----------
    space : HeadSpace
    placed : Placed
        The markers on the default face.
    rest : ndarray, shape (markers, 3)
        As recorded.
    source : Source
    on_rim : ndarray of bool, shape (markers,)
        Markers on the rim of the face.
    """
    on_skin = np.array([part == space.skin.name for part, _ in placed.sites])
    vertices = np.array([vertex for _, vertex in placed.sites])[on_skin]
    offset = placed.places[on_skin] - space.rest[vertices]
    basis = space.components[:_COMPONENTS, vertices].astype(np.float64)
    mean = (space.rest + space.mean)[vertices] + offset
    weight = np.where(on_rim[on_skin], _RIM_SHARE, 1.0)
    weight *= min(1.0, _COUNT / weight.sum()) / _MISFIT_MM**2
    axes = np.array([1.0, 1.0, 1.0 if source.gain[2] == 1.0 else _DEPTH_SHARE])
    trust = weight[:, None] * axes
    flat = basis.reshape(len(basis), -1)
    system = (flat * trust.ravel()) @ flat.T + np.eye(len(basis))
    markers, found = rest[on_skin], np.zeros(len(basis))
    for _ in range(_ROUNDS):
        own = mean + np.tensordot(found, basis, axes=1)
        lay = best_similarity(markers, own, weight, scale=True)
        asked = markers @ lay[:3, :3].T + lay[:3, 3] - mean
        found = np.linalg.solve(system, flat @ (asked * trust).ravel())
    left = asked - np.tensordot(found, basis, axes=1)
    return Head(found, space.shape(found), float(np.sqrt((left[:, :2] ** 2).sum(axis=1).mean())))
