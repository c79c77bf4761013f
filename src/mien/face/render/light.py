# mypy: disable-error-code="no-untyped-def"
"""How much light reaches every vertex: compiled kernels.

Each distant light looks at the head once and keeps, per cell of a square map, how near to it the nearest surface is
(`depth_maps`). A vertex that lies deeper than its cell is in shadow. The key light has a fine map; the fill, the rim
and the dome have coarse ones, and together they darken what lies deep: the mouth, the nostrils, the sockets of the
eyes (`vertex_light`). In skin, light then spreads to neighbours, red farthest (`spread_below_skin`).
Every kernel writes each number from one thread only, so results do not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = [
    "INNER",
    "KEY_CELLS",
    "KEY_EDGE_MM",
    "LEAST_THICK_MM",
    "LIT_THROUGH",
    "SOFT_CELLS",
    "SOFT_CELLS_OFF",
    "THROUGH",
    "THROUGH_MM",
    "THROUGH_RISE",
    "depth_maps",
    "light_axes",
    "spread_below_skin",
    "vertex_light",
]

KEY_CELLS, SOFT_CELLS = 512, 120
_NOTHING = np.float32(-1e9)
KEY_EDGE_MM = 0.6  # between the nine points over which the key light's shadow is softened
DOME_REACH = -0.35  # a dome light at a lower cosine than this says nothing of how open a place is
SLACK = 0.06  # beyond the cosine at which a light's effect ends, its share is still found, for highlights nearby
THROUGH, THROUGH_RISE = 0.1, 2.0  # the cosine below which light comes through from the other side, and how soon all
THROUGH_MM = 2.2  # how many times farther than along the skin light is followed through it
LEAST_THICK_MM = 4.0  # as thick flesh is at least: what comes through is red
CHUNK = 256  # vertices that are lit together
_NX, _NY, _NZ, _PX, _PY, _PZ, _QX, _QY, _QZ, _RED, _GREEN, _BLUE, _KEY, _DOME, _DOME_SEEN, _SCATTER = range(16)
_OFF, _OFF_SOFT, _STEP, _FACING, _TOTAL, _SEEN, _NEAR, _NEAREST, _THICK, _FU, _FV, _OUT, _THIN, _CELLS = range(16, 30)
_SHADED = _CELLS + 4
_ROWS = _SHADED + 1
_ZERO, _HALF, _ONE, _SIXTH, _NINTH = (np.float32(each) for each in (0, 0.5, 1, 1 / 6, 1 / 9))
_LEAST_THICK = np.float32(LEAST_THICK_MM)
_BLOCK = 8  # cells of a map that are filled together
_STEEP, _DOME_WRAP, _THROUGH, _RISE = (np.float32(each) for each in (0.25, 0.3, THROUGH, THROUGH_RISE))
LIT_THROUGH, INNER = 0.8, 0.4  # hair seen edge-on has so much of its light, and from within so much (hand-made)
_LIT_THROUGH, _INNER, _TWICE = np.float32(LIT_THROUGH), np.float32(INNER), np.float32(2)
SOFT_CELLS_OFF = 0.5  # further lift against the coarse maps, in their cells, where there is any


def light_axes(directions: NDArray[np.float32]) -> NDArray[np.float32]:
    """Two axes across each light and the one towards it: float32, shape (lights, 3, 3)."""
    axes = np.empty((len(directions), 3, 3), dtype=np.float32)
    for number, towards in enumerate(directions.astype(np.float64)):
        helper = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
        across = np.cross(helper, towards)
        across /= np.linalg.norm(across)
        axes[number] = across, np.cross(towards, across), towards
    return axes


@njit(cache=True, error_model="numpy", nogil=True)
def depth_maps(vertices, casters, listed, coarse, coarse_listed, axes, centre, radius, begin, end, key_map, soft_maps):
    """Fill the maps of the lights from ``begin`` to ``end``.

    Of light 0 ``key_map`` (cells, cells), which sees triangles ``casters`` between the vertices ``listed`` (numbered as
    they stand there); of the others ``soft_maps`` (lights - 1, cells, cells), which see fewer, ``coarse``.
    """
    for light in range(begin, end):
        if light == 0:
            _depth_map(vertices, casters, listed, axes[0], centre, radius, key_map.shape[0], key_map.reshape(-1))
        else:
            cells = soft_maps.shape[1]
            one = soft_maps[light - 1].reshape(-1)
            _depth_map(vertices, coarse, coarse_listed, axes[light], centre, radius, cells, one)


@njit(cache=True, error_model="numpy", nogil=True)
def _depth_map(vertices, triangles, listed, axes, centre, radius, cells, depth):
    scale, half = np.float32(0.5 * cells / radius), np.float32(0.5 * cells)
    ax, ay, az = axes[0, 0] * scale, axes[0, 1] * scale, axes[0, 2] * scale
    bx, by, bz = axes[1, 0] * scale, axes[1, 1] * scale, axes[1, 2] * scale
    depth[:] = _NOTHING
    seen = np.empty((listed.shape[0], 3), np.float32)
    for i in range(listed.shape[0]):
        v = listed[i]
        x, y, z = vertices[v, 0] - centre[0], vertices[v, 1] - centre[1], vertices[v, 2] - centre[2]
        seen[i, 0] = ax * x + ay * y + az * z + half
        seen[i, 1] = bx * x + by * y + bz * z + half
        seen[i, 2] = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
    last = np.float32(cells - 1)
    for t in range(triangles.shape[0]):
        a, b, c = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1]), np.uint64(triangles[t, 2])
        ax, ay, bx, by, cx, cy = seen[a, 0], seen[a, 1], seen[b, 0], seen[b, 1], seen[c, 0], seen[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area <= _ZERO:
            continue
        # Cells whose centre (i + 0.5) may lie inside.
        left, right = max(_ZERO, min(ax, bx, cx) - _HALF), min(last, max(ax, bx, cx) - _HALF)
        low, high = max(_ZERO, min(ay, by, cy) - _HALF), min(last, max(ay, by, cy) - _HALF)
        first, end = np.int64(np.ceil(left)), np.int64(np.floor(right))
        bottom, top = np.int64(np.ceil(low)), np.int64(np.floor(high))
        if first > end or bottom > top:
            continue
        # Shares of the corners and the nearness are planes over the map.
        share = _ONE / area
        za, zb, zc = seen[a, 2], seen[b, 2], seen[c, 2]
        wax, wbx, wcx = (by - cy) * share, (cy - ay) * share, (ay - by) * share
        way, wby, wcy = (cx - bx) * share, (ax - cx) * share, (bx - ax) * share
        for block in range(first, end + 1, _BLOCK):
            begin = min(block, cells - _BLOCK)
            x = np.float32(begin) + _HALF
            for j in range(bottom, top + 1):
                y, row = np.float32(j) + _HALF, np.uint64(j * cells + begin)
                wa, wb = wax * (x - bx) + way * (y - by), wbx * (x - cx) + wby * (y - cy)
                wc = wcx * (x - ax) + wcy * (y - ay)
                for s in range(_BLOCK):
                    to = np.float32(s)
                    sa, sb, sc = wa + to * wax, wb + to * wbx, wc + to * wcx
                    near, old = sa * za + sb * zb + sc * zc, depth[row + np.uint64(s)]
                    inside = (sa >= _ZERO) & (sb >= _ZERO) & (sc >= _ZERO) & (near > old)
                    depth[row + np.uint64(s)] = near if inside else old


@njit(cache=True, error_model="numpy", nogil=True)
def vertex_light(
    vertices, normals, listed, lit_side, place, scatter, thin, lift, cavity, spacing, axes, colours, wrap, bounce,
    depth_mm, centre, radius, key_map, soft_maps, begin, end, light, openness,
):  # fmt: skip
    """Light at the ``listed`` vertices from ``begin`` to ``end``.

    ``lit_side`` (vertices,): 0 the side of the normal; 1 the side that ``place`` sees; 2 the side away from the head,
    which is less bright from within, as hair.

    ``light`` (vertices, 3) receives what a white matt surface would send back, ``openness`` (vertices, 2) the share of
    the key light, and of the dome, that reaches it. ``depth_mm`` (3,) is how deep each colour goes through flesh.
    """
    number, c = np.empty(CHUNK, np.int32), np.empty(_ROWS * CHUNK, np.float32)
    soft_cell = np.float32(SOFT_CELLS_OFF * 2.0 * radius / soft_maps.shape[1])
    flat_key, flat_soft = key_map.reshape(-1), soft_maps.reshape(soft_maps.shape[0], -1)
    for first in range(begin, end, CHUNK):
        n = min(CHUNK, end - first)
        _take(
            listed[first : first + n], n, vertices, normals, lit_side, place, scatter, thin, lift, spacing, centre,
            soft_cell, c,
        )  # fmt: skip
        for k in range(axes.shape[0]):
            lx, ly, lz = axes[k, 2, 0], axes[k, 2, 1], axes[k, 2, 2]
            for i in range(n):
                c[_FACING * CHUNK + i] = c[_NX * CHUNK + i] * lx + c[_NY * CHUNK + i] * ly + c[_NZ * CHUNK + i] * lz
            if k == 0:
                _key_share(n, axes[0], radius, flat_key, key_map.shape[0], number, c)
            else:
                # Off the surface and a little towards the light, so that a surface does not shade itself.
                for i in range(n):
                    off = c[_OFF_SOFT * CHUNK + i]
                    c[_QX * CHUNK + i] = c[_PX * CHUNK + i] + off * (c[_NX * CHUNK + i] + lx)
                    c[_QY * CHUNK + i] = c[_PY * CHUNK + i] + off * (c[_NY * CHUNK + i] + ly)
                    c[_QZ * CHUNK + i] = c[_PZ * CHUNK + i] + off * (c[_NZ * CHUNK + i] + lz)
                _share_seen(n, axes[k], radius, flat_soft[k - 1], soft_maps.shape[1], number, c)
                for i in range(n):
                    c[_TOTAL * CHUNK + i] = c[_SEEN * CHUNK + i]
            _gather(k, n, colours[k], wrap, c)
            if k == 0 or k == 2:
                _shine_through(n, colours[k], depth_mm, c)
        for i in range(n):
            v = listed[first + i]
            # What does not see the dome sees flesh instead, and gets a little red light back from it.
            closed = _ONE - c[_DOME_SEEN * CHUNK + i] / c[_DOME * CHUNK + i]
            left = _ONE - cavity[v] * closed
            shaded = c[_SHADED * CHUNK + i]
            openness[v, 0], openness[v, 1] = shaded * left * c[_KEY * CHUNK + i], shaded * (_ONE - closed)
            left *= _INNER + (_ONE - _INNER) * shaded
            for k in range(3):
                light[v, k] = left * c[(_RED + k) * CHUNK + i] + closed * bounce[k]


@njit(cache=True, error_model="numpy", nogil=True)
def _take(listed, n, vertices, normals, lit_side, place, scatter, thin, lift, spacing, centre, soft_cell, c):
    """Fill a chunk with what is known of the vertices."""
    for i in range(n):
        v = listed[i]
        side, shaded = _ONE, _ONE
        if lit_side[v]:
            away, out, far = _ZERO, _ZERO, np.float32(1e-9)
            for k in range(3):
                from_place = vertices[v, k] - np.float32(place[k])
                away += normals[v, k] * from_place
                out += normals[v, k] * (vertices[v, k] - centre[k])
                far += from_place * from_place
            if (away > _ZERO) if lit_side[v] == 1 else (out < _ZERO):
                side = -_ONE
            if lit_side[v] == 2:
                shaded = min(max(_LIT_THROUGH - _TWICE * side * away / np.sqrt(far), _ZERO), _ONE)
        for k in range(3):
            c[(_PX + k) * CHUNK + i] = vertices[v, k] - centre[k]
            c[(_NX + k) * CHUNK + i] = side * normals[v, k]
            c[(_RED + k) * CHUNK + i] = _ZERO
        c[_SCATTER * CHUNK + i], c[_THIN * CHUNK + i], c[_OFF * CHUNK + i] = scatter[v], thin[v], lift[v]
        c[_OFF_SOFT * CHUNK + i] = lift[v] + (soft_cell if lift[v] > _HALF else _ZERO)
        c[_STEP * CHUNK + i] = max(np.float32(KEY_EDGE_MM), np.float32(0.8) * spacing[v])  # finer would be jagged
        c[_SHADED * CHUNK + i] = shaded
        c[_DOME * CHUNK + i] = c[_DOME_SEEN * CHUNK + i] = np.float32(1e-6)


@njit(cache=True, error_model="numpy", nogil=True)
def _key_share(n, axes, radius, depth, cells, number, c):
    """The key light is large: the mean over nine points of its map, a step apart, for a soft edge.

    The points lie in the plane of the surface, so that a slanting surface does not shade itself.
    """
    lx, ly, lz = axes[2, 0], axes[2, 1], axes[2, 2]
    for i in range(n):
        c[_TOTAL * CHUNK + i] = _ZERO
    for p in range(-1, 2):
        for q in range(-1, 2):
            ax, ay, az = (
                p * axes[0, 0] + q * axes[1, 0],
                p * axes[0, 1] + q * axes[1, 1],
                p * axes[0, 2] + q * axes[1, 2],
            )
            ax, ay, az = np.float32(ax), np.float32(ay), np.float32(az)
            for i in range(n):
                nx, ny, nz = c[_NX * CHUNK + i], c[_NY * CHUNK + i], c[_NZ * CHUNK + i]
                step, off = c[_STEP * CHUNK + i], c[_OFF * CHUNK + i]
                back = -(nx * ax + ny * ay + nz * az) / max(c[_FACING * CHUNK + i], _STEEP)
                c[_QX * CHUNK + i] = c[_PX * CHUNK + i] + off * (nx + lx) + step * (ax + back * lx)
                c[_QY * CHUNK + i] = c[_PY * CHUNK + i] + off * (ny + ly) + step * (ay + back * ly)
                c[_QZ * CHUNK + i] = c[_PZ * CHUNK + i] + off * (nz + lz) + step * (az + back * lz)
            _share_seen(n, axes, radius, depth, cells, number, c)
            for i in range(n):
                c[_TOTAL * CHUNK + i] += c[_SEEN * CHUNK + i] * _NINTH
            if p == 0 and q == 0:
                for i in range(n):
                    c[_THICK * CHUNK + i] = c[_NEAREST * CHUNK + i] - c[_NEAR * CHUNK + i]


@njit(cache=True, error_model="numpy", nogil=True)
def _share_seen(n, axes, radius, depth, cells, number, c):
    """Share of the light that reaches each point: the four nearest cells, each seen or not, mixed by nearness.

    Computed in vectors but for reading the map; also the surface nearest to the light in the four cells.
    """
    scale, half, most = np.float32(0.5 * cells / radius), np.float32(0.5 * cells - 0.5), np.float32(cells - 1)
    ax, ay, az = axes[0, 0] * scale, axes[0, 1] * scale, axes[0, 2] * scale
    bx, by, bz = axes[1, 0] * scale, axes[1, 1] * scale, axes[1, 2] * scale
    lx, ly, lz = axes[2, 0], axes[2, 1], axes[2, 2]
    for i in range(n):
        x, y, z = c[_QX * CHUNK + i], c[_QY * CHUNK + i], c[_QZ * CHUNK + i]
        u, v = ax * x + ay * y + az * z + half, bx * x + by * y + bz * z + half
        c[_NEAR * CHUNK + i] = lx * x + ly * y + lz * z
        inside = (u >= _ZERO) & (v >= _ZERO) & (u < most) & (v < most)
        u, v = u if inside else _ZERO, v if inside else _ZERO
        left, low = np.int32(u), np.int32(v)
        c[_FU * CHUNK + i], c[_FV * CHUNK + i] = u - np.float32(left), v - np.float32(low)
        c[_OUT * CHUNK + i] = _ZERO if inside else _ONE
        number[i] = low * np.int32(cells) + left
    wide = np.uint64(cells)
    for i in range(n):
        at = np.uint64(number[i])
        c[_CELLS * CHUNK + i], c[(_CELLS + 1) * CHUNK + i] = depth[at], depth[at + np.uint64(1)]
        c[(_CELLS + 2) * CHUNK + i] = depth[at + wide]
        c[(_CELLS + 3) * CHUNK + i] = depth[at + wide + np.uint64(1)]
    for i in range(n):
        near, fu, fv = c[_NEAR * CHUNK + i], c[_FU * CHUNK + i], c[_FV * CHUNK + i]
        d00, d10 = c[_CELLS * CHUNK + i], c[(_CELLS + 1) * CHUNK + i]
        d01, d11 = c[(_CELLS + 2) * CHUNK + i], c[(_CELLS + 3) * CHUNK + i]
        below = (_ONE - fu if near >= d00 else _ZERO) + (fu if near >= d10 else _ZERO)
        above = (_ONE - fu if near >= d01 else _ZERO) + (fu if near >= d11 else _ZERO)
        seen = (_ONE - fv) * below + fv * above
        c[_SEEN * CHUNK + i] = max(seen, c[_OUT * CHUNK + i])
        one, two = d00 if d00 > d10 else d10, d01 if d01 > d11 else d11
        c[_NEAREST * CHUNK + i] = one if one > two else two


@njit(cache=True, error_model="numpy", nogil=True)
def _gather(k, n, colour, wrap, c):
    """Add what arrives of light ``k``."""
    wr, wg, wb = wrap[0], wrap[1], wrap[2]
    cr, cg, cb = colour[0], colour[1], colour[2]
    share = _ONE if k >= 3 else _ZERO
    for i in range(n):
        facing, s = c[_FACING * CHUNK + i], c[_SCATTER * CHUNK + i]
        limit = np.float32(DOME_REACH) if k >= 3 else -s * wr - np.float32(SLACK)
        seen = c[_TOTAL * CHUNK + i] if facing > limit else _ZERO
        plain = share * (max(facing + _DOME_WRAP, _ZERO) if facing > limit else _ZERO)
        c[_DOME * CHUNK + i] += plain
        c[_DOME_SEEN * CHUNK + i] += plain * seen
        if k == 0:
            c[_KEY * CHUNK + i] = seen
        c[_RED * CHUNK + i] += seen * cr * max(facing + s * wr, _ZERO) / (_ONE + s * wr)
        c[(_RED + 1) * CHUNK + i] += seen * cg * max(facing + s * wg, _ZERO) / (_ONE + s * wg)
        c[(_RED + 2) * CHUNK + i] += seen * cb * max(facing + s * wb, _ZERO) / (_ONE + s * wb)
    if k == 1 or k == 2:
        for i in range(n):
            c[_THICK * CHUNK + i] = c[_NEAREST * CHUNK + i] - c[_NEAR * CHUNK + i]


@njit(cache=True, error_model="numpy", nogil=True)
def _shine_through(n, colour, depth_mm, c):
    """Light that falls on the other side of ears and nose comes through, the less the thicker they are there.

    The thickness is what the light's map says (Dachsbacher & Stamminger 2003, Translucent Shadow Maps); exp(-x) as
    1 / (1 + x + x^2 / 2 + x^3 / 6).
    """
    for k in range(3):
        bright, deep = colour[k], _ONE / depth_mm[k]
        for i in range(n):
            behind = max(min(_RISE * (_THROUGH - c[_FACING * CHUNK + i]), _ONE), _ZERO)
            x = max(c[_THICK * CHUNK + i] + c[_OFF * CHUNK + i], _LEAST_THICK) * deep
            passed = _ONE / (_ONE + x * (_ONE + x * (_HALF + x * _SIXTH)))
            c[(_RED + k) * CHUNK + i] += c[_THIN * CHUNK + i] * bright * behind * passed


@njit(cache=True, error_model="numpy", nogil=True)
def spread_below_skin(light, listed, needed, welded, start, neighbour, weight, out):
    """One step of light spreading to neighbouring vertices: each takes the weighted mean around it."""
    for v in listed:
        w = welded[v]
        red, green, blue = light[v, 0], light[v, 1], light[v, 2]
        share_red = share_green = share_blue = 1.0
        for e in range(start[w], start[w + 1]):
            n = neighbour[e]
            if needed[n]:
                red += weight[e, 0] * light[n, 0]
                green += weight[e, 1] * light[n, 1]
                blue += weight[e, 2] * light[n, 2]
                share_red += weight[e, 0]
                share_green += weight[e, 1]
                share_blue += weight[e, 2]
        out[v, 0], out[v, 1], out[v, 2] = red / share_red, green / share_green, blue / share_blue
