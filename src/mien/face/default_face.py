"""The face that comes with mien, baked by ``tools/bake_face``."""

from __future__ import annotations

from functools import cache

from mien.core.assets import asset
from mien.face.model import Face
from mien.face.storage import read_face

__all__ = ["default_face"]


@cache
def default_face() -> Face:
    """The default face.

    Examples
    --------
    >>> default_face().name
    'default'
    """
    return read_face(asset("faces/default.npz"))
