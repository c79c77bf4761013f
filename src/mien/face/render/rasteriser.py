# mypy: disable-error-code="no-untyped-def"
"""Which surface each pixel shows: compiled kernels.

1. `project`: vertices to the picture, in pixels (snapped to 1/256 so that shared edges leave no gap) and 1/depth.
2. `sort_into_bands`: which triangles touch which band of rows; those turned away are dropped, unless a sheet.
3. `cover`: bands by several threads. Four samples a pixel, one on each quarter row, keep the nearest triangle;
   samples are tried sixteen at once, in one vector instruction each step. Then each surface seen in a pixel (samples
   of one part at about one depth) becomes a fragment: its triangle, and which samples.

Only what is seen is lit and shaded (`mien.face.render.light`, `mien.face.render.shading`).
"""

from __future__ import annotations

import numpy as np

from mien.core.compiled import njit

__all__ = [
    "BAND",
    "BLOCK",
    "COLUMNS",
    "NEAREST_MM",
    "SAME_SURFACE_MM",
    "SAMPLES",
    "SOLID",
    "U",
    "V",
    "cover",
    "finest_levels",
    "pack",
    "project",
    "set_up",
    "sort_into_bands",
]

# Columns of ``points``, one line of the cache for each vertex: place in the picture and 1/depth; normal; diffuse light
# sent back; GGX alpha and reflectance head-on; share of the key light and of the dome that arrives; texture
# coordinates; opacity.
X, Y, NEAR, NX, NY, NZ, RED, GREEN, BLUE, ALPHA, HEAD_ON, KEY, DOME, U, V, SOLID = range(16)
COLUMNS = 16
BAND, BLOCK = 16, 16  # rows and columns
_MEASURED = 500  # after so many triangles of a part it is looked again what they hide
SAMPLES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
SAME_SURFACE_MM = 1.2
NEAREST_MM = 10.0  # nothing nearer to the camera is drawn
# A sample is one number: 1/depth in steps so fine that a metre away they are 0.05 micrometres, then the triangle.
_STEPS = 2.0**31 * NEAREST_MM
_SHIFT = np.int64(1) << 32
_TRIANGLE = _SHIFT - 1
# Of the samples of four pixels in a row, from the corner of the first, in 1/256 pixels.
_OFFSET_X = 256.0 * (SAMPLES[:, 0] + np.arange(4)[:, None]).reshape(-1)
_OFFSET_Y = 256.0 * np.tile(SAMPLES[:, 1], 4)


@njit(cache=True, error_model="numpy", nogil=True)
def project(vertices, place, axes, focal, width, height, points):
    """Fill X and Y in pixels, and NEAR = 1 / distance along the view (0 where too near to be drawn)."""
    for v in range(vertices.shape[0]):
        x, y, z = vertices[v, 0] - place[0], vertices[v, 1] - place[1], vertices[v, 2] - place[2]
        depth = -(axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z)
        if depth < NEAREST_MM:
            points[v, NEAR] = 0.0
            continue
        share = 1.0 / depth
        across = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
        up = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
        points[v, X] = np.rint((0.5 * width + focal * across * share) * 256) / 256
        points[v, Y] = np.rint((0.5 * height - focal * up * share) * 256) / 256
        points[v, NEAR] = share


@njit(cache=True, error_model="numpy", nogil=True)
def sort_into_bands(points, triangles, triangle_part, sheet, width, height):
    """Start of each band's list, the list of triangles, and the columns that each band reaches, (bands, 2)."""
    bands = (height + BAND - 1) // BAND
    count = triangles.shape[0]
    first = np.empty(count, np.int32)
    last = np.empty(count, np.int32)
    start = np.zeros(bands + 1, np.int32)
    reach = np.zeros((bands, 2), np.int32)
    reach[:, 0] = width
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
        left, right = min(ax, bx, cx), max(ax, bx, cx)
        if high < 0 or low >= height or right < 0 or left >= width:
            continue
        first[t] = max(0, int(low)) // BAND
        last[t] = min(height - 1, int(high)) // BAND
        for band in range(first[t], last[t] + 1):
            start[band + 1] += 1
            reach[band, 0] = min(reach[band, 0], max(0, int(left)))
            reach[band, 1] = max(reach[band, 1], min(width, int(right) + 1))
    for band in range(bands):
        start[band + 1] += start[band]
    fill = start[:-1].copy()
    listed = np.empty(start[bands], np.int32)
    for t in range(count):
        for band in range(first[t], last[t] + 1):
            listed[fill[band]] = t
            fill[band] += 1
    return start, listed, reach


@njit(cache=True, error_model="numpy", nogil=True)
def cover(
    points, triangles, triangle_part, clear, opacity, texture_level, alphas, noise, start, listed, reach, order, begin,
    end, height, fragments, counts, seen,
):  # fmt: skip
    """Find the fragments of the bands from ``begin`` to ``end`` in ``order``, in order of rows and columns.

    ``fragments`` (bands, most, 2) int32 receives the triangle, and in one number the column in the band's reach, the
    row and the samples (four bits each); ``counts`` (bands,) how many there are; ``seen`` (triangles,) becomes true
    where one is. Of parts that are ``clear`` as many samples are kept as their opacity says: that of the part, times
    that of the texture (``alphas``), with the ``noise`` (8, 8) of the pixel for what is less than a sample.
    """
    for number in range(begin, end):
        band = order[number]
        top, left, wide = band * BAND, reach[band, 0], reach[band, 1] - reach[band, 0]
        counts[band] = 0
        if wide <= 0:
            continue
        rows = min(BAND, height - top)
        stride = wide + 4  # pixels are drawn four at a time
        nearest = np.zeros(rows * stride * 4, np.int64)
        farthest = np.zeros((wide + BLOCK - 1) // BLOCK, np.int64)
        part, drawn = -1, 0
        for k in range(start[band], start[band + 1]):
            t = listed[k]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            if triangle_part[t] != part or drawn == _MEASURED:
                part, drawn = triangle_part[t], 0
                _measure(nearest, rows, wide, stride, farthest)
            near = np.int64(_STEPS * max(points[a, NEAR], points[b, NEAR], points[c, NEAR])) + 1
            low = min(points[a, X], points[b, X], points[c, X]) - left
            high = max(points[a, X], points[b, X], points[c, X]) - left
            hidden = True
            for block in range(max(0, int(low)) // BLOCK, min(wide - 1, int(high)) // BLOCK + 1):
                hidden &= near < farthest[block]
            if hidden:
                continue
            drawn += 1
            if clear[part]:
                _fill_clear(
                    t, points, a, b, c, top, rows, left, wide, stride, part, opacity[part], texture_level[part], alphas,
                    noise, nearest,
                )  # fmt: skip
            else:
                _fill(t, points, a, b, c, top, rows, left, wide, stride, nearest)
        counts[band] = _collect(nearest, triangle_part, rows, wide, stride, fragments[band], seen)


@njit(cache=True, error_model="numpy", nogil=True)
def _measure(nearest, rows, wide, stride, farthest):
    """For blocks of columns over all rows: the 1/depth, in steps, behind which nothing is seen."""
    for block in range(farthest.shape[0]):
        first, last = 4 * BLOCK * block, min(4 * BLOCK * (block + 1), 4 * wide)
        least = nearest[first]
        for row in range(rows):
            for i in range(4 * stride * row + first, 4 * stride * row + last):
                least = min(least, nearest[np.uint64(i)])
            if least == 0:
                break
        farthest[block] = least >> 32


@njit(cache=True, error_model="numpy", nogil=True)
def _fill(t, points, a, b, c, top, rows, left, wide, stride, nearest):
    """Keep triangle ``t`` in every sample of the band where it is the nearest so far.

    Sixteen samples at once, those of four pixels: places are whole numbers of 1/256 pixels, so that the edge functions
    (Pineda 1988) are exact, and a sample on an edge belongs to the triangle to its right or, on a level edge, below.
    """
    ax, ay = 256.0 * (float(points[a, X]) - left), 256.0 * (float(points[a, Y]) - top)
    bx, by = 256.0 * (float(points[b, X]) - left), 256.0 * (float(points[b, Y]) - top)
    cx, cy = 256.0 * (float(points[c, X]) - left), 256.0 * (float(points[c, Y]) - top)
    an, bn, cn = float(points[a, NEAR]), float(points[b, NEAR]), float(points[c, NEAR])
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if area < 0.0:
        bx, by, bn, cx, cy, cn, area = cx, cy, cn, bx, by, bn, -area
    share = _STEPS / area
    nx = ((bn - an) * (cy - ay) - (cn - an) * (by - ay)) * share
    ny = ((cn - an) * (bx - ax) - (bn - an) * (cx - ax)) * share
    low, high = min(ax, bx, cx) / 256.0, max(ax, bx, cx) / 256.0
    begin, end = max(0, int(low)), min(wide, int(high) + 1)
    low, high = min(ay, by, cy) / 256.0, max(ay, by, cy) / 256.0
    first, last = max(0, int(low)), min(rows, int(high) + 1)
    # Of each edge, u from a to b, v from b to c, w from c to a: growth to the right and down, and the value (0 or more
    # inside) at the first pixel.
    ux, uy, vx, vy, wx, wy = ay - by, bx - ax, by - cy, cx - bx, cy - ay, ax - cx
    x, y = 256.0 * begin, 256.0 * first
    u = ux * (x - ax) + uy * (y - ay) - _beside(ux, uy)
    v = vx * (x - bx) + vy * (y - by) - _beside(vx, vy)
    w = wx * (x - cx) + wy * (y - cy) - _beside(wx, wy)
    n = _STEPS * an + nx * (x - ax) + ny * (y - ay)
    for row in range(first, last):
        at = np.uint64(4 * (row * stride + begin))  # without a sign: what may be below 0 is looked at twice
        ru, rv, rw, rn = u, v, w, n
        for _ in range(begin, end, 4):
            for s in range(16):
                dx, dy = _OFFSET_X[s], _OFFSET_Y[s]
                inside = (ru + ux * dx + uy * dy >= 0.0) & (rv + vx * dx + vy * dy >= 0.0)
                inside &= rw + wx * dx + wy * dy >= 0.0
                key = (np.int64(rn + nx * dx + ny * dy) << 32) | t
                old = nearest[at + np.uint64(s)]
                nearest[at + np.uint64(s)] = key if inside & (key > old) else old
            at += np.uint64(16)
            ru, rv, rw, rn = ru + 1024.0 * ux, rv + 1024.0 * vx, rw + 1024.0 * wx, rn + 1024.0 * nx
        u, v, w, n = u + 256.0 * uy, v + 256.0 * vy, w + 256.0 * wy, n + 256.0 * ny


@njit(cache=True, error_model="numpy", nogil=True)
def _fill_clear(
    t, points, a, b, c, top, rows, left, wide, stride, part, opacity, texture_level, alphas, noise, nearest
):
    """As `_fill`, pixel by pixel, of a triangle that is seen through."""
    ax, ay, an = float(points[a, X]) - left, float(points[a, Y]) - top, float(points[a, NEAR])
    bx, by, bn = float(points[b, X]) - left, float(points[b, Y]) - top, float(points[b, NEAR])
    cx, cy, cn = float(points[c, X]) - left, float(points[c, Y]) - top, float(points[c, NEAR])
    share = 1.0 / ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
    level = _level(points, a, b, c, 1.0 / share, texture_level)
    first, across, down = texture_level[level, 0], texture_level[level, 1], texture_level[level, 2]
    for row in range(max(0, int(min(ay, by, cy))), min(rows, int(max(ay, by, cy)) + 1)):
        for i in range(max(0, int(min(ax, bx, cx))), min(wide, int(max(ax, bx, cx)) + 1)):
            x, y = i + 0.5, row + 0.5
            wb = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) * share
            wc = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) * share
            wa, wb, wc = max(1.0 - wb - wc, 0.0) * an, max(wb, 0.0) * bn, max(wc, 0.0) * cn
            kept = float(opacity)
            if across > 0:
                u = (wa * points[a, U] + wb * points[b, U] + wc * points[c, U]) / (wa + wb + wc)
                v = (wa * points[a, V] + wb * points[b, V] + wc * points[c, V]) / (wa + wb + wc)
                texel = min(max(int(v * down), 0), down - 1) * across + min(max(int(u * across), 0), across - 1)
                kept *= alphas[first + texel] / 255.0
            for s in range(4):
                if 4.0 * kept <= ((s + part) & 3) + noise[(top + row) & 7, (left + i) & 7]:
                    continue
                x, y = i + SAMPLES[s, 0], row + SAMPLES[s, 1]
                wb = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) * share
                wc = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) * share
                if wb >= 0.0 and wc >= 0.0 and wb + wc <= 1.0:
                    near = _STEPS * (an + wb * (bn - an) + wc * (cn - an))
                    at = np.uint64(4 * (row * stride + i) + s)
                    nearest[at] = max(nearest[at], (np.int64(near) << 32) | t)


@njit(cache=True, error_model="numpy", nogil=True)
def _level(points, a, b, c, area, texture_level):
    """Of a texture, the level on which a texel is about as large as a pixel of a triangle of this doubled area."""
    du, dv = points[b, U] - points[a, U], points[b, V] - points[a, V]
    eu, ev = points[c, U] - points[a, U], points[c, V] - points[a, V]
    ratio = abs((du * ev - dv * eu) * texture_level[0, 1] * texture_level[0, 2] / area)
    level = 0
    while ratio > 2.0 and level < texture_level.shape[0] - 1:
        ratio *= 0.25
        level += 1
    return level


@njit(cache=True, error_model="numpy", nogil=True)
def _beside(grows_right, grows_down):
    """What keeps samples on an edge out: nothing where the triangle lies to its right or below."""
    return 0.0 if grows_right > 0.0 or (grows_right == 0.0 and grows_down > 0.0) else 0.5


@njit(cache=True, error_model="numpy", nogil=True)
def _collect(nearest, triangle_part, rows, wide, stride, fragments, seen):
    count = 0
    for row in range(rows):
        for i in range(wide):
            at = np.uint64(4 * (row * stride + i))
            k0, k1 = nearest[at], nearest[at + np.uint64(1)]
            k2, k3 = nearest[at + np.uint64(2)], nearest[at + np.uint64(3)]
            if k0 | k1 | k2 | k3 == 0:
                continue
            place = 256 * i + 16 * row
            t = k0 & _TRIANGLE
            if k0 != 0 and t == k1 & _TRIANGLE and t == k2 & _TRIANGLE and t == k3 & _TRIANGLE:
                fragments[count, 0], fragments[count, 1] = t, place + 15
                count += 1
                seen[t] = True
                continue
            left = (k0 != 0) | (k1 != 0) << 1 | (k2 != 0) << 2 | (k3 != 0) << 3
            for s in range(4):
                if not (left >> s) & 1:
                    continue
                key = nearest[at + np.uint64(s)]
                t = key & _TRIANGLE
                part, near = triangle_part[t], (key >> 32) / _STEPS
                same = 1 << s
                for other in range(s + 1, 4):
                    if (left >> other) & 1:
                        key = nearest[at + np.uint64(other)]
                        too = (key >> 32) / _STEPS
                        if triangle_part[key & _TRIANGLE] == part and abs(too - near) < SAME_SURFACE_MM * too * near:
                            same |= 1 << other
                left &= ~same
                fragments[count, 0], fragments[count, 1] = t, place + same
                count += 1
                seen[t] = True
    return count


@njit(cache=True, error_model="numpy", nogil=True)
def set_up(points, triangles, triangle_part, texture_level, seen, needed, planes, level):
    """What every fragment of a triangle that is seen needs; sets ``needed`` for its vertices.

    ``planes`` (triangles, 8) float32: place of corner a, how the shares of b and c grow across and down, 1/depth of b
    and of c as parts of that of a (below 0 where the triangle is seen from behind). ``level`` (triangles,) int8: of the
    texture, the one on which a texel is about as large as a pixel; -1 without a texture.
    """
    for t in range(triangles.shape[0]):
        if not seen[t]:
            continue
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        needed[a] = needed[b] = needed[c] = True
        ax, ay = float(points[a, X]), float(points[a, Y])
        bx, by, cx, cy = points[b, X] - ax, points[b, Y] - ay, points[c, X] - ax, points[c, Y] - ay
        area = bx * cy - by * cx
        share, side = 1.0 / area, 1.0 if area < 0.0 else -1.0
        planes[t, 0], planes[t, 1] = ax, ay
        planes[t, 2], planes[t, 3], planes[t, 4], planes[t, 5] = cy * share, -cx * share, -by * share, bx * share
        share = side / points[a, NEAR]
        planes[t, 6], planes[t, 7] = share * points[b, NEAR], share * points[c, NEAR]
        part = triangle_part[t]
        level[t] = _level(points, a, b, c, area, texture_level[part]) if texture_level[part, 0, 1] > 0 else -1


@njit(cache=True, error_model="numpy", nogil=True)
def finest_levels(seen, triangle_part, level, finest):
    """Lower ``finest`` (parts,) to the finest level of the texture that any triangle that is seen is read on."""
    for t in range(seen.shape[0]):
        if seen[t]:
            finest[triangle_part[t]] = min(finest[triangle_part[t]], max(level[t], 0))


@njit(cache=True, error_model="numpy", nogil=True)
def pack(normals, light, openness, albedo, gloss, listed, points):
    """Fill the columns of ``points`` that change with the pose and that `project` did not fill."""
    for v in listed:
        for k in range(3):
            points[v, NX + k] = normals[v, k]
            points[v, RED + k] = light[v, k] * albedo[v, k]
        points[v, ALPHA], points[v, HEAD_ON] = gloss[v, 0], gloss[v, 1]
        points[v, KEY], points[v, DOME] = openness[v, 0], openness[v, 1]
