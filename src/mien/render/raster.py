# mypy: disable-error-code="no-untyped-def"
"""From lit vertices to pixels: compiled kernels.

1. `project`: vertices to the picture, in pixels (snapped to 1/256 so that shared edges leave no gap) and 1/depth.
2. `sort_into_bands`: which triangles touch which band of rows; those turned away are dropped, unless a sheet.
3. `draw`: each band in its own thread. Four samples per pixel keep the nearest triangle; then every surface seen in a
   pixel (samples of one part at about one depth) is shaded once, perspective-correct, at the middle of its samples.

Shading: diffuse light comes from the vertices; textures are read bilinearly from the level that fits the triangle's
size; highlights are GGX (Walter et al. 2007) with Schlick's Fresnel for key, fill and rim, and the dome is mirrored by
the height of the mirrored way.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from mien.render.colour import KNEE, SRGB_STEPS

__all__ = ["BAND", "SAMPLES", "draw", "project", "sort_into_bands"]

BAND = 16
SAMPLES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
_SAME_SURFACE_MM = 1.2
_NEAREST_MM = 10.0  # nothing nearer to the camera is drawn
_REACH = 0.375  # from a pixel's middle to its outermost sample, along either axis


@njit(cache=True, error_model="numpy", parallel=True, nogil=True)
def project(vertices, place, axes, focal, width, height, seen):
    """Fill ``seen`` (vertices, 3): x and y in pixels, and 1 / distance along the view (0 where too near)."""
    for v in prange(vertices.shape[0]):
        x, y, z = vertices[v, 0] - place[0], vertices[v, 1] - place[1], vertices[v, 2] - place[2]
        depth = -(axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z)
        if depth < _NEAREST_MM:
            seen[v, 2] = 0.0
            continue
        across = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
        up = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
        seen[v, 0] = np.rint((0.5 * width + focal * across / depth) * 256) / 256
        seen[v, 1] = np.rint((0.5 * height - focal * up / depth) * 256) / 256
        seen[v, 2] = 1.0 / depth


@njit(cache=True, error_model="numpy", nogil=True)
def sort_into_bands(seen, triangles, triangle_part, sheet, width, height, needed):
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
        if seen[a, 2] == 0.0 or seen[b, 2] == 0.0 or seen[c, 2] == 0.0:
            continue
        ax, ay, bx, by, cx, cy = seen[a, 0], seen[a, 1], seen[b, 0], seen[b, 1], seen[c, 0], seen[c, 1]
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


@njit(cache=True, error_model="numpy", parallel=True, nogil=True)
def draw(
    seen, normals, light, openness, albedo, gloss, uv, triangles, triangle_part, start, listed,
    texels, texture_level, place_axes, focal, directions, colours, sky, background, exposure, linear, srgb, noise, out,
):  # fmt: skip
    """Draw all bands into ``out`` (height, width, 3) uint8."""
    height, width = out.shape[:2]
    for band in prange(start.shape[0] - 1):
        top = band * BAND
        rows = min(BAND, height - top)
        nearest = np.zeros((rows, width, 4), np.float32)
        owner = np.full((rows, width, 4), -1, np.int32)
        for k in range(start[band], start[band + 1]):
            _cover(listed[k], seen, triangles, top, rows, width, nearest, owner)
        pixel = np.empty(3)
        mean = np.empty(3)
        for row in range(rows):
            down = (top + row + 0.5) / height
            behind = background[0] + down * (background[1] - background[0])
            for x in range(width):
                covered = 0
                mean[:] = 0.0
                for s in range(4):
                    t = owner[row, x, s]
                    if t < 0:
                        continue
                    same, sx, sy = _gather(owner, nearest, triangle_part, row, x, s)
                    covered += same
                    _shade(
                        t, x + sx, top + row + sy, width, height, seen, normals, light, openness, albedo, gloss, uv,
                        triangles, triangle_part, texels, texture_level, place_axes, focal, directions, colours, sky,
                        exposure, linear, pixel,
                    )  # fmt: skip
                    for c in range(3):
                        mean[c] += 0.25 * same * pixel[c]
                for c in range(3):
                    value = mean[c]
                    if covered < 4:
                        value += 0.25 * (4 - covered) * behind[c]
                    step = int(np.sqrt(min(value, 1.0)) * (SRGB_STEPS - 1) + 0.5)
                    out[top + row, x, c] = int(min(255.0, srgb[step] + noise[(top + row) & 7, x & 7]))


@njit(cache=True, error_model="numpy", nogil=True)
def _cover(t, seen, triangles, top, rows, width, nearest, owner):
    """Keep triangle ``t`` in every sample of the band where it is the nearest so far."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ax, ay = float(seen[a, 0]), float(seen[a, 1]) - top
    bx, by = float(seen[b, 0]), float(seen[b, 1]) - top
    cx, cy = float(seen[c, 0]), float(seen[c, 1]) - top
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    side = 1.0 if area > 0 else -1.0
    left, right = max(0, int(np.floor(min(ax, bx, cx)))), min(width - 1, int(np.floor(max(ax, bx, cx))))
    low, high = max(0, int(np.floor(min(ay, by, cy)))), min(rows - 1, int(np.floor(max(ay, by, cy))))
    # Edge functions w = wx * x + wy * y + w0, all >= 0 inside; their sum is the (positive) doubled area.
    wax, way = side * (by - cy), side * (cx - bx)
    wbx, wby = side * (cy - ay), side * (ax - cx)
    wcx, wcy = side * (ay - by), side * (bx - ax)
    wa0, wb0, wc0 = -wax * bx - way * by, -wbx * cx - wby * cy, -wcx * ax - wcy * ay
    slack_a, slack_b, slack_c = (
        -_REACH * (abs(wax) + abs(way)), -_REACH * (abs(wbx) + abs(wby)), -_REACH * (abs(wcx) + abs(wcy)),
    )  # fmt: skip
    da, db, dc = seen[a, 2] / abs(area), seen[b, 2] / abs(area), seen[c, 2] / abs(area)
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
def _gather(owner, nearest, triangle_part, row, x, s):
    """Take out of the pixel the samples that show the surface of sample ``s``: how many, and their middle."""
    part, depth = triangle_part[owner[row, x, s]], 1.0 / nearest[row, x, s]
    same, sx, sy = 1, SAMPLES[s, 0], SAMPLES[s, 1]
    for other in range(s + 1, 4):
        u = owner[row, x, other]
        if u < 0 or triangle_part[u] != part:
            continue
        if abs(1.0 / nearest[row, x, other] - depth) < _SAME_SURFACE_MM:
            same += 1
            sx += SAMPLES[other, 0]
            sy += SAMPLES[other, 1]
            owner[row, x, other] = -1
    return same, sx / same, sy / same


@njit(cache=True, error_model="numpy", nogil=True)
def _shade(
    t, px, py, width, height, seen, normals, light, openness, albedo, gloss, uv, triangles, triangle_part,
    texels, texture_level, axes, focal, directions, colours, sky, exposure, linear, pixel,
):  # fmt: skip
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ax, ay = float(seen[a, 0]), float(seen[a, 1])
    bx, by = float(seen[b, 0]), float(seen[b, 1])
    cx, cy = float(seen[c, 0]), float(seen[c, 1])
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    # Shares of the corners; the point may lie a little outside, so they are kept at 0 or more.
    wa = max(0.0, ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area) * seen[a, 2]
    wb = max(0.0, ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area) * seen[b, 2]
    wc = max(0.0, ((ax - px) * (by - py) - (ay - py) * (bx - px)) / area) * seen[c, 2]
    total = wa + wb + wc
    wa, wb, wc = wa / total, wb / total, wc / total
    # The way to the camera, and the normal turned to its side.
    ex, ey = -(px - 0.5 * width) / focal, (py - 0.5 * height) / focal
    vx, vy, vz = (
        axes[0, 0] * ex + axes[1, 0] * ey + axes[2, 0],
        axes[0, 1] * ex + axes[1, 1] * ey + axes[2, 1],
        axes[0, 2] * ex + axes[1, 2] * ey + axes[2, 2],
    )
    length = np.sqrt(vx * vx + vy * vy + vz * vz)
    vx, vy, vz = vx / length, vy / length, vz / length
    nx = wa * normals[a, 0] + wb * normals[b, 0] + wc * normals[c, 0]
    ny = wa * normals[a, 1] + wb * normals[b, 1] + wc * normals[c, 1]
    nz = wa * normals[a, 2] + wb * normals[b, 2] + wc * normals[c, 2]
    length = np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-9
    if area > 0.0:
        length = -length
    nx, ny, nz = nx / length, ny / length, nz / length
    facing = max(nx * vx + ny * vy + nz * vz, 0.05)
    for k in range(3):
        pixel[k] = wa * light[a, k] * albedo[a, k] + wb * light[b, k] * albedo[b, k] + wc * light[c, k] * albedo[c, k]
    part = triangle_part[t]
    if texture_level[part, 0, 1] > 0:
        _texture(part, abs(area), a, b, c, wa, wb, wc, uv, texels, texture_level, linear, pixel)
    alpha = wa * gloss[a, 0] + wb * gloss[b, 0] + wc * gloss[c, 0]
    head_on = wa * gloss[a, 1] + wb * gloss[b, 1] + wc * gloss[c, 1]
    key_open = wa * openness[a, 0] + wb * openness[b, 0] + wc * openness[c, 0]
    dome_open = wa * openness[a, 1] + wb * openness[b, 1] + wc * openness[c, 1]
    for k in range(3):
        shine = _highlight(nx, ny, nz, vx, vy, vz, facing, directions[k], alpha, head_on)
        shine *= key_open if k == 0 else dome_open
        if shine > 0.0:
            for ch in range(3):
                pixel[ch] += shine * colours[k, ch]
    # The dome mirrored: by the height of the mirrored way, less on rough surfaces, more at a grazing angle.
    up = 2 * (nx * vx + ny * vy + nz * vz) * ny - vy
    fresnel = head_on + (max(1.0 - alpha, head_on) - head_on) * (1 - facing) ** 5 * min(1.0, 12.5 * head_on)
    for ch in range(3):
        low = sky[1, ch]
        mirrored = low + up * (sky[0, ch] - low) if up > 0.0 else low - up * (sky[2, ch] - low)
        lit = exposure * (pixel[ch] + fresnel * dome_open * dome_open * mirrored)
        if lit > KNEE:
            s = (lit - KNEE) / (1 - KNEE)
            lit = KNEE + (1 - KNEE) * s / (1 + s)
        pixel[ch] = lit


@njit(cache=True, error_model="numpy", nogil=True)
def _highlight(nx, ny, nz, vx, vy, vz, facing, towards, alpha, head_on):
    """Cook-Torrance with GGX and the height-correlated Smith term as Hammon's approximation; times pi, times cosine."""
    lit = nx * towards[0] + ny * towards[1] + nz * towards[2]
    if lit <= 0.0:
        return 0.0
    hx, hy, hz = vx + towards[0], vy + towards[1], vz + towards[2]
    length = np.sqrt(hx * hx + hy * hy + hz * hz) + 1e-9
    nh = max(0.0, (nx * hx + ny * hy + nz * hz) / length)
    vh = (vx * hx + vy * hy + vz * hz) / length
    squared = alpha * alpha
    spread = nh * nh * (squared - 1.0) + 1.0
    fresnel = head_on + (1.0 - head_on) * (1.0 - vh) ** 5 * min(1.0, 12.5 * head_on)
    masked = 0.5 / (2.0 * lit * facing * (1.0 - alpha) + (lit + facing) * alpha)
    return squared / (spread * spread) * fresnel * masked * lit


@njit(cache=True, error_model="numpy", nogil=True)
def _texture(part, area, a, b, c, wa, wb, wc, uv, texels, texture_level, linear, pixel):
    """Multiply ``pixel`` by the texture, from the level on which a texel is about as large as a pixel."""
    wide, tall = texture_level[part, 0, 1], texture_level[part, 0, 2]
    du, dv, eu, ev = uv[b, 0] - uv[a, 0], uv[b, 1] - uv[a, 1], uv[c, 0] - uv[a, 0], uv[c, 1] - uv[a, 1]
    ratio = abs(du * ev - dv * eu) * wide * tall / area
    level = 0
    while ratio > 2.0 and level < texture_level.shape[1] - 1:
        ratio *= 0.25
        level += 1
    first, wide, tall = texture_level[part, level, 0], texture_level[part, level, 1], texture_level[part, level, 2]
    u = (wa * uv[a, 0] + wb * uv[b, 0] + wc * uv[c, 0]) * wide - 0.5
    v = (wa * uv[a, 1] + wb * uv[b, 1] + wc * uv[c, 1]) * tall - 0.5
    i, j = int(np.floor(u)), int(np.floor(v))
    fu, fv = u - i, v - j
    i0, i1 = min(max(i, 0), wide - 1), min(max(i + 1, 0), wide - 1)
    j0, j1 = first + min(max(j, 0), tall - 1) * wide, first + min(max(j + 1, 0), tall - 1) * wide
    for k in range(3):
        above = linear[texels[j0 + i0, k]] * (1 - fu) + linear[texels[j0 + i1, k]] * fu
        below = linear[texels[j1 + i0, k]] * (1 - fu) + linear[texels[j1 + i1, k]] * fu
        pixel[k] *= above * (1 - fv) + below * fv
