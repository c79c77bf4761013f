"""What is known of the default face when it is fitted to another head: its openings, and the space that heads lie in.

The file is baked by ``tools/bake_face/head_space.py`` from MakeHuman's CC0 data: principal components of made-up
characters, on the vertices of the default face's skin. A head is ``rest + mean + sum_k c_k component_k`` with ``c`` of
unit variance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.assets import asset
from mien.face.default_face import default_face
from mien.face.model import Face, Part

__all__ = ["SKIN", "HeadSpace", "head_space"]

SKIN = "skin"
_STEP = 0.01  # mm

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class HeadSpace:
    """The default face and the space of heads about it.

    Attributes
    ----------
    face : Face
        The default face.
    rest : ndarray, shape (n, 3)
        Its skin at rest, mm.
    mean : ndarray, shape (n, 3)
        From the default head to the mean of all heads, mm.
    components : ndarray of float32, shape (k, n, 3)
        Each one standard deviation, largest first, mm.
    inside_mouth, lips, ears, socket : ndarray, shape (n,)
        0..1: the mouth's inside, the red of the lips, the ears, and what of the lids is turned to the eyeball.
    lip_loop, lid_loop_left, lid_loop_right : ndarray of int32
        Vertices around each opening, in order: where the lips turn inwards, and the margins of the lids.
    """

    face: Face
    rest: Floats
    mean: Floats
    components: NDArray[np.float32]
    inside_mouth: Floats
    lips: Floats
    ears: Floats
    socket: Floats
    lip_loop: Indices
    lid_loop_left: Indices
    lid_loop_right: Indices

    @property
    def skin(self) -> Part:
        """The default face's skin."""
        return self.face.part(SKIN)

    @property
    def triangles(self) -> Indices:
        """Triangles of the skin, shape (t, 3)."""
        return self.skin.triangles

    def shape(self, weights: ArrayLike) -> Floats:
        """The skin of the head with these weights (up to k of them, in standard deviations), shape (n, 3), mm.

        Examples
        --------
        >>> space = head_space()
        >>> space.shape([0.0]).shape == space.rest.shape
        True
        """
        weights = np.asarray(weights, dtype=np.float64)
        moved = np.tensordot(weights, self.components[: len(weights)].astype(np.float64), axes=1)
        return np.asarray(self.rest + self.mean + moved)

    def outer(self) -> NDArray[np.bool_]:
        """Vertices that another head's surface can show: not the mouth's inside, not the lids' backs."""
        return np.asarray((self.inside_mouth < 0.5) & (self.socket < 0.5))


@cache
def head_space() -> HeadSpace:
    """The space of heads that comes with mien."""
    face = default_face()
    path = asset("fitting/default.npz")
    with np.load(path, allow_pickle=False) as archive:
        data = {name: archive[name] for name in archive.files}
    shares = {name: data[name].astype(np.float64) / 255 for name in ("inside_mouth", "lips", "ears", "socket")}
    loops = {name: data[name] for name in ("lip_loop", "lid_loop_left", "lid_loop_right")}
    return HeadSpace(
        face,
        face.part(SKIN).vertices.astype(np.float64),
        data["mean"].astype(np.float64) * _STEP,
        data["components"].astype(np.float32) * data["step"][:, None, None],
        **shares,
        **loops,
    )
