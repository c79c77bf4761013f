# mypy: disable-error-code="no-untyped-def"
"""Pores and the fine lines between them, as a relief in the skin that highlights and shade follow (bump mapping, Blinn
1978): hand-made, one tile that repeats, drawn only where a pixel is small enough to show it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit
from mien.face.render.rasteriser import KEY, NX, NY, NZ, RED, U, V

__all__ = ["PIT_SHADE", "SLOPE_SHADE", "TILE_MM", "relief_share", "roughen", "tile"]

TILE_MM, _TEXELS = 28.0, 256
_PORES, _PORE_MM, _LINE_MM = 900, 0.20, 0.34
_DEEP, _LINES = 0.10, 0.030  # mm: a pore, and how the skin between rises and falls
_SHOWN_MM, _FULL_MM = 0.26, 0.13  # of skin in a pixel: where the relief begins to show, and where all of it does
SLOPE_SHADE, PIT_SHADE = np.float32(0.55), np.float32(0.16)
_ONE, _HALF, _TINY = np.float32(1), np.float32(0.5), np.float32(1e-6)


def relief_share(mm_per_pixel: float) -> float:
    """How much of the relief is drawn, 0..1.

    Examples
    --------
    >>> relief_share(0.45), relief_share(0.1)
    (0.0, 1.0)
    """
    return float(np.clip((_SHOWN_MM - mm_per_pixel) / (_SHOWN_MM - _FULL_MM), 0.0, 1.0))


@cache
def tile() -> NDArray[np.float32]:
    """One tile, shape (texels, texels, 3): slopes across and down, and how deep in a pore, 0..1."""
    from scipy.ndimage import gaussian_filter

    rng = np.random.default_rng(5)
    step = TILE_MM / _TEXELS
    pits = np.zeros((_TEXELS, _TEXELS))
    grid = np.stack(np.meshgrid(np.arange(30), np.arange(30)), axis=-1).reshape(-1, 2)[:_PORES]
    places = ((grid + rng.uniform(0.1, 0.9, grid.shape)) * _TEXELS / 30).astype(int) % _TEXELS
    pits[places[:, 1], places[:, 0]] = rng.uniform(0.2, 1.0, len(places))
    pits = gaussian_filter(pits, _PORE_MM / step, mode="wrap")
    pits /= pits.max()
    lines = gaussian_filter(rng.normal(size=pits.shape), _LINE_MM / step, mode="wrap")
    height = _LINES * lines / lines.std() - _DEEP * pits
    slopes = [(np.roll(height, -1, axis) - np.roll(height, 1, axis)) / (2 * step) for axis in (1, 0)]
    return np.ascontiguousarray(np.stack([*slopes, pits], axis=-1), dtype=np.float32)


@njit(cache=True, error_model="numpy", nogil=True)
def roughen(n, tiles, share, relief, towards, size, chunk):
    """Bend the normals of a chunk's ``n`` fragments, and shade its diffuse light, by the relief.

    ``tiles`` (n,) is how many tiles a unit of texture coordinates holds, 0 where there is no relief; ``towards`` the
    direction of the key light; ``size`` the chunk's length (`mien.face.render.shading`).
    """
    texels = relief.shape[0]
    for i in range(n):
        if tiles[i] == 0.0:
            continue
        x, y = chunk[U * size + i] * tiles[i] * texels - _HALF, chunk[V * size + i] * tiles[i] * texels - _HALF
        left, low = np.floor(x), np.floor(y)
        fx, fy = np.float32(x - left), np.float32(y - low)
        i0, j0 = int(left) % texels, int(low) % texels
        i1, j1 = (i0 + 1) % texels, (j0 + 1) % texels
        w00, w10, w01, w11 = (_ONE - fx) * (_ONE - fy), fx * (_ONE - fy), (_ONE - fx) * fy, fx * fy
        across = w00 * relief[j0, i0, 0] + w10 * relief[j0, i1, 0] + w01 * relief[j1, i0, 0] + w11 * relief[j1, i1, 0]
        down = w00 * relief[j0, i0, 1] + w10 * relief[j0, i1, 1] + w01 * relief[j1, i0, 1] + w11 * relief[j1, i1, 1]
        pit = w00 * relief[j0, i0, 2] + w10 * relief[j0, i1, 2] + w01 * relief[j1, i0, 2] + w11 * relief[j1, i1, 2]
        nx, ny, nz = chunk[NX * size + i], chunk[NY * size + i], chunk[NZ * size + i]
        # Across and down the surface, level with the head: the pattern looks alike whichever way it lies.
        level = _ONE / np.sqrt(nx * nx + nz * nz + _TINY)
        tx, tz = nz * level, -nx * level
        bx, by, bz = ny * tz, nz * tx - nx * tz, -ny * tx
        dx, dy = share * across, share * down
        mx, my, mz = dx * tx + dy * bx, dy * by, dx * tz + dy * bz
        chunk[NX * size + i], chunk[NY * size + i], chunk[NZ * size + i] = nx - mx, ny - my, nz - mz
        turned = -(mx * towards[0] + my * towards[1] + mz * towards[2])
        shade = _ONE + SLOPE_SHADE * chunk[KEY * size + i] * turned - share * PIT_SHADE * pit
        for k in range(RED, RED + 3):
            chunk[k * size + i] *= shade
