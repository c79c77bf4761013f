# mypy: disable-error-code="no-untyped-def"
"""What colour each fragment has, and the pixels: compiled kernels.

Diffuse light comes from the vertices; textures are read bilinearly from the level that fits the triangle's size;
highlights are GGX (Walter et al. 2007) with Schlick's Fresnel for key, fill and rim, and the dome is mirrored by the
height of the mirrored way.

A band's fragments are shaded in chunks: what is looked up (corners, texels) one fragment after the other, what is only
computed in loops over the chunk that the compiler turns into vector instructions. All numbers of a chunk lie in one
array, `CHUNK` for each quantity, so that the compiler sees that they do not overlap.
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit
from mien.face.render.colour import KNEE, SRGB_STEPS
from mien.face.render.rasteriser import (
    ALPHA,
    BAND,
    COLUMNS,
    DOME,
    HEAD_ON,
    KEY,
    NX,
    NY,
    NZ,
    RED,
    SAMPLES,
    SOLID,
    U,
    V,
)
from mien.face.render.relief import roughen

__all__ = ["CHUNK", "MOST_SHINE", "draw"]

CHUNK = 256
_VX, _VY, _VZ, _STRAIGHT, _SEEN, _ROWS = range(COLUMNS, COLUMNS + 6)
_ZERO, _HALF, _ONE, _TWO = (np.float32(each) for each in (0, 0.5, 1, 2))
MOST_SHINE = 0.15  # times 1 / alpha: hand-made
_TINY, _GRAZING, _FULL_SHINE, _MOST_SHINE, _KNEE = (np.float32(each) for each in (1e-9, 0.05, 12.5, MOST_SHINE, KNEE))
# For the 16 sets of samples: the middle of those in it, and their share of a pixel.
_BITS = (np.arange(16)[:, None] >> np.arange(4)) & 1
_SHARE = (_BITS.sum(axis=1) / 4).astype(np.float32)
_MIDDLE = ((_BITS @ SAMPLES) / np.maximum(_BITS.sum(axis=1, keepdims=True), 1)).astype(np.float32)


@njit(cache=True, error_model="numpy", nogil=True)
def draw(
    points, triangles, triangle_part, planes, level, reach, order, begin, end, fragments, counts, texels,
    texture_level, axes, focal, directions, colours, sky, behind, backdrop, exposure, linear, srgb, noise,
    tiles, relief_share, relief, out,
):  # fmt: skip
    """Draw the bands from ``begin`` to ``end`` of ``order`` into ``out``.

    It is (height, width, 3) uint8 before a background, or (height, width, 4) before none. ``behind`` (height, width, 3)
    is the background in linear light, ``backdrop`` the same as pixels; ``tiles`` (parts,) and what follows it is the
    relief of skin (`mien.face.render.relief`).
    """
    height, width = out.shape[:2]
    for number in range(begin, end):
        band = order[number]
        top, left, wide = band * BAND, reach[band, 0], reach[band, 1] - reach[band, 0]
        rows, count = min(BAND, height - top), counts[band]
        if out.shape[2] == 4:
            out[top : top + rows] = 0
        elif count == 0:
            out[top : top + rows] = backdrop[top : top + rows]
        if count == 0:
            continue
        total = np.zeros((rows * wide, 4), np.float32)
        chunk, mixed = np.empty(_ROWS * CHUNK, np.float32), np.empty(COLUMNS, np.float32)
        rough = np.empty(CHUNK, np.float32)
        for first in range(0, count, CHUNK):
            n = min(CHUNK, count - first)
            _look_up(
                fragments[band, first : first + n], n, top, left, np.float32(0.5 * width), np.float32(0.5 * height),
                np.float32(1.0 / focal), points, triangles, triangle_part, planes, level, texels, texture_level, linear,
                axes[0], axes[1], axes[2], mixed, chunk,
            )  # fmt: skip
            if relief_share > _ZERO:
                for i in range(n):
                    rough[i] = tiles[triangle_part[fragments[band, first + i, 0]]]
                roughen(n, rough, relief_share, relief, directions[0], CHUNK, chunk)
            _shine(n, directions, colours, sky, exposure, chunk)
            for i in range(n):
                place = fragments[band, first + i, 1]
                pixel, same = ((place >> 4) & 15) * wide + (place >> 8), place & 15
                weight = _SHARE[same] * chunk[SOLID * CHUNK + i]
                for k in range(3):
                    total[pixel, k] += weight * chunk[(RED + k) * CHUNK + i]
                total[pixel, 3] += weight
        _encode(total, top, left, rows, wide, behind, backdrop, srgb, noise, out)


@njit(cache=True, error_model="numpy", nogil=True)
def _encode(total, top, left, rows, wide, behind, backdrop, srgb, noise, out):
    clear = out.shape[2] == 4
    for row in range(rows):
        y = top + row
        if not clear:
            out[y, :left] = backdrop[y, :left]
            out[y, left + wide :] = backdrop[y, left + wide :]
        for i in range(wide):
            x, at = left + i, row * wide + i
            solid = total[at, 3]
            dither = noise[y & 7, x & 7]
            if clear:
                if solid > _ZERO:
                    share = _ONE / solid
                    for k in range(3):
                        out[y, x, k] = _byte(total[at, k] * share, srgb, dither)
                    out[y, x, 3] = np.uint8(min(solid, _ONE) * np.float32(255) + _HALF)
            elif solid == _ZERO:
                for k in range(3):
                    out[y, x, k] = backdrop[y, x, k]
            else:
                for k in range(3):
                    out[y, x, k] = _byte(total[at, k] + (_ONE - solid) * behind[y, x, k], srgb, dither)


@njit(cache=True, error_model="numpy", nogil=True)
def _byte(value, srgb, dither):
    step = np.int64(np.sqrt(max(min(value, _ONE), _ZERO)) * np.float32(SRGB_STEPS - 1) + _HALF)
    return np.uint8(min(np.float32(255), srgb[step] + dither))


@njit(cache=True, error_model="numpy", nogil=True)
def _look_up(
    fragments, n, top, left, middle_x, middle_y, per_pixel, points, triangles, triangle_part, planes, level, texels,
    texture_level, linear, across, up, back, mixed, chunk,
):  # fmt: skip
    """Fill a chunk: what the corners say at each fragment, times the texture's colour, and the way to the camera."""
    last = np.uint64(1 << 40)
    first, wide, tall, columns = -1, 1, 1, points.shape[1]
    for i in range(n):
        t, place = np.uint64(fragments[i, 0]), fragments[i, 1]
        px = np.float32(left + (place >> 8)) + _MIDDLE[place & 15, 0]
        py = np.float32(top + ((place >> 4) & 15)) + _MIDDLE[place & 15, 1]
        if t != last:
            last = t
            a, b, c = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1]), np.uint64(triangles[t, 2])
            ax, ay, bx, by = planes[t, 0], planes[t, 1], planes[t, 2], planes[t, 3]
            cx, cy, bn, cn = planes[t, 4], planes[t, 5], planes[t, 6], planes[t, 7]
            side = _ONE if bn > _ZERO else -_ONE
            bn, cn = abs(bn), abs(cn)
            first = -1
            if level[t] >= 0:
                size = texture_level[triangle_part[t], level[t]]
                first, wide, tall = size[0], size[1], size[2]
        # Shares of the corners; the point may lie a little outside, so they are kept at 0 or more.
        dx, dy = px - ax, py - ay
        fb, fc = dx * bx + dy * by, dx * cx + dy * cy
        fa, fb, fc = max(_ONE - fb - fc, _ZERO), max(fb, _ZERO) * bn, max(fc, _ZERO) * cn
        share = _ONE / (fa + fb + fc)
        fa, fb, fc = fa * share, fb * share, fc * share
        for k in range(columns):  # a number that the compiler does not know: it would unroll, and not use vectors
            mixed[k] = fa * points[a, k] + fb * points[b, k] + fc * points[c, k]
        if first >= 0:
            _texture(first, wide, tall, texels, linear, mixed)
        for k in range(COLUMNS):
            chunk[k * CHUNK + i] = mixed[k]
        for k in range(NX, NZ + 1):  # turned to the camera where seen from behind
            chunk[k * CHUNK + i] *= side
        ex, ey = (middle_x - px) * per_pixel, (py - middle_y) * per_pixel
        for k in range(3):
            chunk[(_VX + k) * CHUNK + i] = across[k] * ex + up[k] * ey + back[k]


@njit(cache=True, error_model="numpy", nogil=True)
def _texture(first, wide, tall, texels, linear, mixed):
    """Multiply the colour of a fragment by the texture."""
    u = mixed[U] * np.float32(wide) - _HALF
    v = mixed[V] * np.float32(tall) - _HALF
    left, low = int(np.floor(u)), int(np.floor(v))
    fu, fv = u - np.float32(left), v - np.float32(low)
    i0, i1 = min(max(left, 0), wide - 1), min(max(left + 1, 0), wide - 1)
    j0, j1 = first + min(max(low, 0), tall - 1) * wide, first + min(max(low + 1, 0), tall - 1) * wide
    w00, w10, w01, w11 = (_ONE - fu) * (_ONE - fv), fu * (_ONE - fv), (_ONE - fu) * fv, fu * fv
    p00, p10, p01, p11 = np.uint64(j0 + i0), np.uint64(j0 + i1), np.uint64(j1 + i0), np.uint64(j1 + i1)
    for k in range(3):
        mixed[RED + k] *= (
            linear[texels[p00, k]] * w00 + linear[texels[p10, k]] * w10
            + linear[texels[p01, k]] * w01 + linear[texels[p11, k]] * w11
        )  # fmt: skip


@njit(cache=True, error_model="numpy", nogil=True)
def _shine(n, directions, colours, sky, exposure, chunk):
    """Add what is mirrored to the diffuse light, and bend it by the tone curve."""
    for i in range(n):
        vx, vy, vz = chunk[_VX * CHUNK + i], chunk[_VY * CHUNK + i], chunk[_VZ * CHUNK + i]
        share = _ONE / np.sqrt(vx * vx + vy * vy + vz * vz)
        vx, vy, vz = vx * share, vy * share, vz * share
        nx, ny, nz = chunk[NX * CHUNK + i], chunk[NY * CHUNK + i], chunk[NZ * CHUNK + i]
        share = _ONE / (np.sqrt(nx * nx + ny * ny + nz * nz) + _TINY)
        nx, ny, nz = nx * share, ny * share, nz * share
        chunk[_VX * CHUNK + i], chunk[_VY * CHUNK + i], chunk[_VZ * CHUNK + i] = vx, vy, vz
        chunk[NX * CHUNK + i], chunk[NY * CHUNK + i], chunk[NZ * CHUNK + i] = nx, ny, nz
        chunk[_STRAIGHT * CHUNK + i] = nx * vx + ny * vy + nz * vz
        chunk[_SEEN * CHUNK + i] = chunk[KEY * CHUNK + i]
    _highlight(n, directions[0], colours[0], chunk)
    for i in range(n):  # whose shadows are coarse: in a crease, as between the lips, nothing is to glint
        dome = chunk[DOME * CHUNK + i]
        chunk[_SEEN * CHUNK + i] = dome * dome * dome * dome
    _highlight(n, directions[1], colours[1], chunk)
    _highlight(n, directions[2], colours[2], chunk)
    zr, zg, zb = sky[0, 0], sky[0, 1], sky[0, 2]
    hr, hg, hb = sky[1, 0], sky[1, 1], sky[1, 2]
    gr, gg, gb = sky[2, 0], sky[2, 1], sky[2, 2]
    amount = np.float32(exposure)
    for i in range(n):
        # The dome mirrored: by the height of the mirrored way, less on rough surfaces, more at a grazing angle.
        straight, head_on = chunk[_STRAIGHT * CHUNK + i], chunk[HEAD_ON * CHUNK + i]
        dome, away = chunk[DOME * CHUNK + i], _ONE - max(straight, _GRAZING)
        rise = max(_ONE - chunk[ALPHA * CHUNK + i], head_on) - head_on
        fifth = away * away * away * away * away
        mirrored = (head_on + rise * fifth * min(_ONE, _FULL_SHINE * head_on)) * dome * dome
        up = _TWO * straight * chunk[NY * CHUNK + i] - chunk[_VY * CHUNK + i]
        above, below = max(up, _ZERO), max(-up, _ZERO)
        red = amount * (chunk[RED * CHUNK + i] + mirrored * (hr + above * (zr - hr) + below * (gr - hr)))
        green = amount * (chunk[(RED + 1) * CHUNK + i] + mirrored * (hg + above * (zg - hg) + below * (gg - hg)))
        blue = amount * (chunk[(RED + 2) * CHUNK + i] + mirrored * (hb + above * (zb - hb) + below * (gb - hb)))
        chunk[RED * CHUNK + i] = _tone(red)
        chunk[(RED + 1) * CHUNK + i] = _tone(green)
        chunk[(RED + 2) * CHUNK + i] = _tone(blue)


@njit(cache=True, error_model="numpy", nogil=True)
def _tone(light):
    s = max(light - _KNEE, _ZERO) / (_ONE - _KNEE)
    return min(light, _KNEE) + (_ONE - _KNEE) * s / (_ONE + s)


@njit(cache=True, error_model="numpy", nogil=True)
def _highlight(n, direction, colour, chunk):
    """Cook-Torrance with GGX and the height-correlated Smith term as Hammon's approximation; times pi, times cosine."""
    lx, ly, lz = direction[0], direction[1], direction[2]
    cr, cg, cb = colour[0], colour[1], colour[2]
    for i in range(n):
        nx, ny, nz = chunk[NX * CHUNK + i], chunk[NY * CHUNK + i], chunk[NZ * CHUNK + i]
        vx, vy, vz = chunk[_VX * CHUNK + i], chunk[_VY * CHUNK + i], chunk[_VZ * CHUNK + i]
        alpha, head_on = chunk[ALPHA * CHUNK + i], chunk[HEAD_ON * CHUNK + i]
        facing = max(chunk[_STRAIGHT * CHUNK + i], _GRAZING)
        lit = max(nx * lx + ny * ly + nz * lz, _ZERO)
        # The half-way vector's length is known from the angle between view and light, both of length 1.
        half = np.sqrt(_TWO + _TWO * (vx * lx + vy * ly + vz * lz)) + _TINY
        nh = max(_ZERO, (nx * (vx + lx) + ny * (vy + ly) + nz * (vz + lz)) / half)
        squared, away = alpha * alpha, _ONE - _HALF * half
        spread = nh * nh * (squared - _ONE) + _ONE
        fifth = away * away * away * away * away
        fresnel = head_on + (_ONE - head_on) * fifth * min(_ONE, _FULL_SHINE * head_on)
        masked = _TWO * lit * facing * (_ONE - alpha) + (lit + facing) * alpha
        # At a grazing angle a rough surface would mirror as much as a wet one: no more than its roughness allows.
        shine = min(_HALF * squared * fresnel * lit / (spread * spread * masked), _MOST_SHINE / alpha)
        shine *= chunk[_SEEN * CHUNK + i]
        chunk[RED * CHUNK + i] += shine * cr
        chunk[(RED + 1) * CHUNK + i] += shine * cg
        chunk[(RED + 2) * CHUNK + i] += shine * cb
