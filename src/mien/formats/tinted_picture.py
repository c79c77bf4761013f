"""A part's texture with the tint of its vertices painted in, for formats whose materials know one of the two only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.face.model import Part
from mien.face.render.raster_maps import draw_triangles
from mien.formats.face_motion import linear_light

__all__ = ["tinted_picture"]

_RIM = 8  # texels beside the part's own that take its tint too, so that sampling at a seam finds no other colour


def tinted_picture(part: Part) -> NDArray[np.uint8] | None:
    """The texture of a part times the colours of its vertices, as light; sRGB. None if it has no texture.

    Texture coordinates outside 0..1 are not painted: they repeat texels that are inside.
    """
    texture = part.material.texture
    if texture is None or np.all(part.colours == 1.0):
        return texture
    from scipy.ndimage import distance_transform_edt

    height, width = texture.shape[:2]
    places = part.uv.astype(np.float64) * (width, height)
    triangles = np.ascontiguousarray(part.triangles, dtype=np.int32)
    grid = draw_triangles(places, np.ones(len(places)), triangles, height, width)
    inside = grid.triangle >= 0
    rows, columns = np.nonzero(inside)
    corners = linear_light(part.colours)[part.triangles[grid.triangle[rows, columns]]]
    tint = np.einsum("nk,nkc->nc", grid.weights[rows, columns], corners)
    distance, nearest = distance_transform_edt(~inside, return_indices=True)
    painted = np.ones((height, width, 3))
    painted[rows, columns] = tint
    rim = (distance > 0) & (distance <= _RIM)
    painted[rim] = painted[nearest[0][rim], nearest[1][rim]]
    changed = painted.min(axis=2) < 1.0
    result = texture.copy()
    light = linear_light(texture[changed][:, :3] / 255.0) * painted[changed]
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    result[changed, :3] = np.rint(255 * encoded).astype(np.uint8)
    return result
