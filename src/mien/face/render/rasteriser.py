# mypy: disable-error-code="no-untyped-def"
"""From lit vertices to pixels: compiled kernels.

1. `project`: vertices to the picture, in pixels (snapped to 1/256 so that shared edges leave no gap) and 1/depth.
2. `sort_into_bands`: which triangles touch which band of rows; those turned away are dropped, unless a sheet.
3. `draw`: each band in its own thread. Four samples per pixel keep the nearest triangle; then every surface seen in a
   pixel (samples of one part at about one depth) is shaded once, perspective-correct, at the middle of its samples.

All that a pixel needs of a vertex lies in one row of ``points``, 64 bytes, one line of the cache: the columns are named
below.

Shading: diffuse light comes from the vertices; textures are read bilinearly from the level that fits the triangle's
size; highlights are GGX (Walter et al. 2007) with Schlick's Fresnel for key, fill and rim, and the dome is mirrored by
the height of the mirrored way.
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit, prange
from mien.face.render.colour import KNEE, SRGB_STEPS

__all__ = [
    "BAND",
    "COLUMNS",
    "SAME_SURFACE_MM",
    "SAMPLES",
    "SOLID",
    "U",
    "V",
    "draw",
    "pack",
    "project",
    "sort_into_bands",
]

# Columns of ``points``: place in the picture and 1/depth; normal; diffuse light sent back; GGX alpha and reflectance
# head-on; share of the key light and of the dome that arrives; texture coordinates; opacity.
X, Y, NEAR, NX, NY, NZ, RED, GREEN, BLUE, ALPHA, HEAD_ON, KEY, DOME, U, V, SOLID = range(16)
COLUMNS = 16
BAND = 16
SAMPLES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
SAME_SURFACE_MM = 1.2
_NEAREST_MM = 10.0  # nothing nearer to the camera is drawn
_REACH = 0.375  # from a pixel's middle to its outermost sample, along either axis


@njit(cache=True, error_model="numpy", nogil=True)
def project(vertices, place, axes, focal, width, height, points):
    """Fill X and Y in pixels, and NEAR = 1 / distance along the view (0 where too near to be drawn)."""
    for v in range(vertices.shape[0]):
        x, y, z = vertices[v, 0] - place[0], vertices[v, 1] - place[1], vertices[v, 2] - place[2]
        depth = -(axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z)
        if depth < _NEAREST_MM:
            points[v, NEAR] = 0.0
            continue
        across = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
        up = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
        points[v, X] = np.rint((0.5 * width + focal * across / depth) * 256) / 256
        points[v, Y] = np.rint((0.5 * height - focal * up / depth) * 256) / 256
        points[v, NEAR] = 1.0 / depth


@njit(cache=True, error_model="numpy", nogil=True)
def sort_into_bands(points, triangles, triangle_part, sheet, width, height, needed):
    """Start of each band's list, the list of triangles; sets ``needed`` for the vertices that are seen."""
    bands = (height + BAND - 1) // BAND
    count = triangles.shape[0]
    first = np.empty(count, np.int32)
    last = np.empty(count, np.int32)
    start = np.zeros(bands + 1, np.int32)
    needed[:] = False
    for t in range(count):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        last[t], first[t] = -1, 0
        if points[a, NEAR] == 0.0 or points[b, NEAR] == 0.0 or points[c, NEAR] == 0.0:
            continue
        ax, ay, bx, by, cx, cy = points[a, X], points[a, Y], points[b, X], points[b, Y], points[c, X], points[c, Y]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0 or (area > 0.0 and not sheet[triangle_part[t]]):  # y runs down: front faces are negative
            continue
        low, high = min(ay, by, cy), max(ay, by, cy)
        if high < 0 or low >= height or max(ax, bx, cx) < 0 or min(ax, bx, cx) >= width:
            continue
        first[t] = max(0, int(low)) // BAND
        last[t] = min(height - 1, int(high)) // BAND
        needed[a] = needed[b] = needed[c] = True
        for band in range(first[t], last[t] + 1):
            start[band + 1] += 1
    for band in range(bands):
        start[band + 1] += start[band]
    fill = start[:-1].copy()
    listed = np.empty(start[bands], np.int32)
    for t in range(count):
        for band in range(first[t], last[t] + 1):
            listed[fill[band]] = t
            fill[band] += 1
    return start, listed


@njit(cache=True, error_model="numpy", nogil=True)
def pack(normals, light, openness, albedo, gloss, listed, points):
    """Fill the columns of ``points`` that change with the pose and that `project` did not fill."""
    for v in listed:
        for k in range(3):
            points[v, NX + k] = normals[v, k]
            points[v, RED + k] = light[v, k] * albedo[v, k]
        points[v, ALPHA], points[v, HEAD_ON] = gloss[v, 0], gloss[v, 1]
        points[v, KEY], points[v, DOME] = openness[v, 0], openness[v, 1]


@njit(cache=True, error_model="numpy", parallel=True, nogil=True)
def draw(
    points, triangles, triangle_part, start, listed, order, texels, texture_level, axes, focal,
    directions, colours, sky, background, backdrop, exposure, linear, srgb, noise, out,
):  # fmt: skip
    """Draw all bands into ``out`` (height, width, 3) uint8.

    ``background`` (height, 3) is linear light, ``backdrop`` (height, 8, 3) the same as pixels;
    ``order`` deals the bands out to the threads.
    """
    height, width = out.shape[:2]
    per_pixel = 1.0 / focal
    for number in prange(order.shape[0]):
        band = order[number]
        top = band * BAND
        rows = min(BAND, height - top)
        nearest = np.zeros((rows, width, 4), np.float32)
        owner = np.full((rows, width, 4), -1, np.int32)
        for k in range(start[band], start[band + 1]):
            _cover(listed[k], points, triangles, top, rows, width, nearest, owner)
        pixel = np.empty(4)
        for row in range(rows):
            y = top + row
            behind_r, behind_g, behind_b = background[y, 0], background[y, 1], background[y, 2]
            for x in range(width):
                red = green = blue = solid = 0.0
                for s in range(4):
                    t = owner[row, x, s]
                    if t < 0:
                        continue
                    same, sx, sy = _gather(owner, nearest, triangle_part, row, x, s)
                    _shade(
                        t, x + sx, y + sy, 0.5 * width, 0.5 * height, points, triangles, triangle_part, texels,
                        texture_level, axes, per_pixel, directions, colours, sky, exposure, linear, pixel,
                    )  # fmt: skip
                    weight = 0.25 * same * pixel[3]
                    red += weight * pixel[0]
                    green += weight * pixel[1]
                    blue += weight * pixel[2]
                    solid += weight
                if solid == 0.0:
                    for c in range(3):
                        out[y, x, c] = backdrop[y, x & 7, c]
                    continue
                dither = noise[y & 7, x & 7]
                out[y, x, 0] = _byte(red + (1 - solid) * behind_r, srgb, dither)
                out[y, x, 1] = _byte(green + (1 - solid) * behind_g, srgb, dither)
                out[y, x, 2] = _byte(blue + (1 - solid) * behind_b, srgb, dither)


@njit(cache=True, error_model="numpy", nogil=True)
def _byte(value, srgb, dither):
    return np.uint8(min(255.0, srgb[int(np.sqrt(min(value, 1.0)) * (SRGB_STEPS - 1) + 0.5)] + dither))


@njit(cache=True, error_model="numpy", nogil=True)
def _cover(t, points, triangles, top, rows, width, nearest, owner):
    """Keep triangle ``t`` in every sample of the band where it is the nearest so far."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ax, ay = float(points[a, X]), float(points[a, Y]) - top
    bx, by = float(points[b, X]), float(points[b, Y]) - top
    cx, cy = float(points[c, X]), float(points[c, Y]) - top
    left, right = max(0, int(np.floor(min(ax, bx, cx)))), min(width - 1, int(np.floor(max(ax, bx, cx))))
    low, high = max(0, int(np.floor(min(ay, by, cy)))), min(rows - 1, int(np.floor(max(ay, by, cy))))
    if _hidden(max(points[a, NEAR], points[b, NEAR], points[c, NEAR]), left, right, low, high, nearest):
        return
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    side = 1.0 if area > 0 else -1.0
    # Edge functions w = wx * x + wy * y + w0, all >= 0 inside; their sum is the (positive) doubled area.
    wax, way = side * (by - cy), side * (cx - bx)
    wbx, wby = side * (cy - ay), side * (ax - cx)
    wcx, wcy = side * (ay - by), side * (bx - ax)
    wa0, wb0, wc0 = -wax * bx - way * by, -wbx * cx - wby * cy, -wcx * ax - wcy * ay
    slack_a, slack_b, slack_c = (
        -_REACH * (abs(wax) + abs(way)), -_REACH * (abs(wbx) + abs(wby)), -_REACH * (abs(wcx) + abs(wcy)),
    )  # fmt: skip
    da, db, dc = points[a, NEAR] / abs(area), points[b, NEAR] / abs(area), points[c, NEAR] / abs(area)
    for j in range(low, high + 1):
        for i in range(left, right + 1):
            wa = wax * (i + 0.5) + way * (j + 0.5) + wa0
            wb = wbx * (i + 0.5) + wby * (j + 0.5) + wb0
            wc = wcx * (i + 0.5) + wcy * (j + 0.5) + wc0
            if wa < slack_a or wb < slack_b or wc < slack_c:
                continue
            for s in range(4):
                x, y = i + SAMPLES[s, 0], j + SAMPLES[s, 1]
                ea, eb, ec = wax * x + way * y + wa0, wbx * x + wby * y + wb0, wcx * x + wcy * y + wc0
                if ea >= 0.0 and eb >= 0.0 and ec >= 0.0:
                    near = np.float32(ea * da + eb * db + ec * dc)
                    if near > nearest[j, i, s]:
                        nearest[j, i, s] = near
                        owner[j, i, s] = t


@njit(cache=True, error_model="numpy", nogil=True)
def _hidden(near, left, right, low, high, nearest):
    """Whether a small triangle lies behind all that its pixels show already (teeth behind lips, eyes behind lids)."""
    if (right - left) * (high - low) > 9:
        return False
    for j in range(low, high + 1):
        for i in range(left, right + 1):
            for s in range(4):
                if nearest[j, i, s] < near:
                    return False
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def _gather(owner, nearest, triangle_part, row, x, s):
    """Take out of the pixel the samples that show the surface of sample ``s``: how many, and their middle."""
    part, near = triangle_part[owner[row, x, s]], nearest[row, x, s]
    same, sx, sy = 1, SAMPLES[s, 0], SAMPLES[s, 1]
    for other in range(s + 1, 4):
        u = owner[row, x, other]
        if u < 0 or triangle_part[u] != part:
            continue
        too = nearest[row, x, other]
        if abs(too - near) < SAME_SURFACE_MM * too * near:  # both are 1 / depth
            same += 1
            sx += SAMPLES[other, 0]
            sy += SAMPLES[other, 1]
            owner[row, x, other] = -1
    return same, sx / same, sy / same


@njit(cache=True, error_model="numpy", nogil=True)
def _mix(points, a, b, c, wa, wb, wc, column):
    return wa * points[a, column] + wb * points[b, column] + wc * points[c, column]


@njit(cache=True, error_model="numpy", nogil=True)
def _shade(
    t, px, py, middle_x, middle_y, points, triangles, triangle_part, texels, texture_level, axes,
    per_pixel, directions, colours, sky, exposure, linear, pixel,
):  # fmt: skip
    """Fill ``pixel`` with red, green, blue (linear, after the tone curve) and opacity of a triangle at one point."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ax, ay, bx, by = float(points[a, X]), float(points[a, Y]), float(points[b, X]), float(points[b, Y])
    cx, cy = float(points[c, X]), float(points[c, Y])
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    # Shares of the corners; the point may lie a little outside, so they are kept at 0 or more.
    side = 1.0 if area > 0.0 else -1.0
    wa = max(0.0, side * ((bx - px) * (cy - py) - (by - py) * (cx - px))) * points[a, NEAR]
    wb = max(0.0, side * ((cx - px) * (ay - py) - (cy - py) * (ax - px))) * points[b, NEAR]
    wc = max(0.0, side * ((ax - px) * (by - py) - (ay - py) * (bx - px))) * points[c, NEAR]
    share = 1.0 / (wa + wb + wc)
    wa, wb, wc = wa * share, wb * share, wc * share
    for k in range(3):
        pixel[k] = _mix(points, a, b, c, wa, wb, wc, RED + k)
    pixel[3] = _mix(points, a, b, c, wa, wb, wc, SOLID)
    part = triangle_part[t]
    if texture_level[part, 0, 1] > 0:
        _texture(part, abs(area), points, a, b, c, wa, wb, wc, texels, texture_level, linear, pixel)
    # The way to the camera, and the normal turned to its side.
    ex, ey = (middle_x - px) * per_pixel, (py - middle_y) * per_pixel
    vx = axes[0, 0] * ex + axes[1, 0] * ey + axes[2, 0]
    vy = axes[0, 1] * ex + axes[1, 1] * ey + axes[2, 1]
    vz = axes[0, 2] * ex + axes[1, 2] * ey + axes[2, 2]
    share = 1.0 / np.sqrt(vx * vx + vy * vy + vz * vz)
    vx, vy, vz = vx * share, vy * share, vz * share
    nx, ny, nz = (
        _mix(points, a, b, c, wa, wb, wc, NX),
        _mix(points, a, b, c, wa, wb, wc, NY),
        _mix(points, a, b, c, wa, wb, wc, NZ),
    )
    share = -side / (np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-9)
    nx, ny, nz = nx * share, ny * share, nz * share
    straight = nx * vx + ny * vy + nz * vz
    facing = max(straight, 0.05)
    alpha, head_on = _mix(points, a, b, c, wa, wb, wc, ALPHA), _mix(points, a, b, c, wa, wb, wc, HEAD_ON)
    dome_open = _mix(points, a, b, c, wa, wb, wc, DOME)
    seen = _mix(points, a, b, c, wa, wb, wc, KEY)
    for k in range(3):
        lx, ly, lz = directions[k, 0], directions[k, 1], directions[k, 2]
        shine = seen * _highlight(nx, ny, nz, vx, vy, vz, facing, lx, ly, lz, alpha, head_on) if seen > 0.0 else 0.0
        seen = dome_open
        for ch in range(3):
            pixel[ch] += shine * colours[k, ch]
    # The dome mirrored: by the height of the mirrored way, less on rough surfaces, more at a grazing angle.
    up = 2 * straight * ny - vy
    rise = max(1.0 - alpha, head_on) - head_on
    mirrored = (head_on + rise * _fifth(1 - facing) * min(1.0, 12.5 * head_on)) * dome_open * dome_open
    for ch in range(3):
        low = sky[1, ch]
        around = low + up * (sky[0, ch] - low) if up > 0.0 else low - up * (sky[2, ch] - low)
        lit = exposure * (pixel[ch] + mirrored * around)
        if lit > KNEE:
            s = (lit - KNEE) / (1 - KNEE)
            lit = KNEE + (1 - KNEE) * s / (1 + s)
        pixel[ch] = lit


@njit(cache=True, error_model="numpy", nogil=True)
def _fifth(x):
    return x * x * x * x * x


@njit(cache=True, error_model="numpy", nogil=True)
def _highlight(nx, ny, nz, vx, vy, vz, facing, lx, ly, lz, alpha, head_on):
    """Cook-Torrance with GGX and the height-correlated Smith term as Hammon's approximation; times pi, times cosine."""
    lit = nx * lx + ny * ly + nz * lz
    if lit <= 0.0:
        return 0.0
    # The half-way vector's length is known from the angle between view and light, both of length 1.
    half = np.sqrt(2.0 + 2.0 * (vx * lx + vy * ly + vz * lz)) + 1e-9
    nh = max(0.0, (nx * (vx + lx) + ny * (vy + ly) + nz * (vz + lz)) / half)
    vh = 0.5 * half
    squared = alpha * alpha
    spread = nh * nh * (squared - 1.0) + 1.0
    fresnel = head_on + (1.0 - head_on) * _fifth(1.0 - vh) * min(1.0, 12.5 * head_on)
    masked = 2.0 * lit * facing * (1.0 - alpha) + (lit + facing) * alpha
    return 0.5 * squared * fresnel * lit / (spread * spread * masked)


@njit(cache=True, error_model="numpy", nogil=True)
def _texture(part, area, points, a, b, c, wa, wb, wc, texels, texture_level, linear, pixel):
    """Multiply ``pixel`` by the texture, from the level on which a texel is about as large as a pixel."""
    wide, tall = texture_level[part, 0, 1], texture_level[part, 0, 2]
    du, dv = points[b, U] - points[a, U], points[b, V] - points[a, V]
    eu, ev = points[c, U] - points[a, U], points[c, V] - points[a, V]
    ratio = abs(du * ev - dv * eu) * wide * tall / area
    level = 0
    while ratio > 2.0 and level < texture_level.shape[1] - 1:
        ratio *= 0.25
        level += 1
    first, wide, tall = texture_level[part, level, 0], texture_level[part, level, 1], texture_level[part, level, 2]
    u = _mix(points, a, b, c, wa, wb, wc, U) * wide - 0.5
    v = _mix(points, a, b, c, wa, wb, wc, V) * tall - 0.5
    i, j = int(np.floor(u)), int(np.floor(v))
    fu, fv = u - i, v - j
    i0, i1 = min(max(i, 0), wide - 1), min(max(i + 1, 0), wide - 1)
    j0, j1 = first + min(max(j, 0), tall - 1) * wide, first + min(max(j + 1, 0), tall - 1) * wide
    for k in range(3):
        above = linear[texels[j0 + i0, k]] * (1 - fu) + linear[texels[j0 + i1, k]] * fu
        below = linear[texels[j1 + i0, k]] * (1 - fu) + linear[texels[j1 + i1, k]] * fu
        pixel[k] *= above * (1 - fv) + below * fv
