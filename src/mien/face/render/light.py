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

from mien.core.compiled import njit, prange

__all__ = [
    "KEY_CELLS",
    "KEY_EDGE_MM",
    "SOFT_CELLS",
    "SOFT_CELLS_OFF",
    "depth_maps",
    "light_axes",
    "spread_below_skin",
    "vertex_light",
]

KEY_CELLS, SOFT_CELLS = 512, 160
_NOTHING = np.float32(-1e9)
KEY_EDGE_MM = 0.6  # between the nine points over which the key light's shadow is softened
DOME_REACH = -0.35  # a dome light at a lower cosine than this says nothing of how open a place is
SLACK = 0.06  # beyond the cosine at which a light's effect ends, its share is still found, for highlights nearby
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


@njit(cache=True, error_model="numpy", parallel=True, nogil=True)
def depth_maps(vertices, casters, listed, coarse, coarse_listed, axes, centre, radius, key_map, soft_maps):
    """Fill ``key_map`` (cells, cells) from light 0 and ``soft_maps`` (lights - 1, cells, cells) from the others.

    The key light sees the triangles ``casters``, with the vertices ``listed``; the others see fewer, ``coarse``.
    """
    for light in prange(axes.shape[0]):
        if light == 0:
            _depth_map(vertices, casters, listed, axes[0], centre, radius, key_map)
        else:
            _depth_map(vertices, coarse, coarse_listed, axes[light], centre, radius, soft_maps[light - 1])


@njit(cache=True, error_model="numpy", nogil=True)
def _depth_map(vertices, triangles, listed, axes, centre, radius, depth):
    cells = depth.shape[0]
    scale = np.float32(0.5 * cells / radius)
    half = np.float32(0.5 * cells)
    depth[:] = _NOTHING
    count = vertices.shape[0]
    seen = np.empty((count, 3), np.float32)
    for v in listed:
        x, y, z = vertices[v, 0] - centre[0], vertices[v, 1] - centre[1], vertices[v, 2] - centre[2]
        seen[v, 0] = (axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z) * scale + half
        seen[v, 1] = (axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z) * scale + half
        seen[v, 2] = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay, bx, by, cx, cy = seen[a, 0], seen[a, 1], seen[b, 0], seen[b, 1], seen[c, 0], seen[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area <= 0.0:
            continue
        # Cells whose centre (i + 0.5) may lie inside.
        left = max(0, int(np.ceil(min(ax, bx, cx) - 0.5)))
        right = min(cells - 1, int(np.floor(max(ax, bx, cx) - 0.5)))
        low = max(0, int(np.ceil(min(ay, by, cy) - 0.5)))
        high = min(cells - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        if left > right or low > high:
            continue
        # Shares of the corners and the nearness are planes over the map; they are stepped along each row.
        share = 1.0 / area
        wax, wbx, wcx = (by - cy) * share, (cy - ay) * share, (ay - by) * share
        way, wby, wcy = (cx - bx) * share, (ax - cx) * share, (bx - ax) * share
        x = left + 0.5
        za, zb, zc = seen[a, 2], seen[b, 2], seen[c, 2]
        rise = wax * za + wbx * zb + wcx * zc
        for j in range(low, high + 1):
            y = j + 0.5
            wa = wax * (x - bx) + way * (y - by)
            wb = wbx * (x - cx) + wby * (y - cy)
            wc = wcx * (x - ax) + wcy * (y - ay)
            near = wa * za + wb * zb + wc * zc
            for i in range(left, right + 1):
                if wa >= 0.0 and wb >= 0.0 and wc >= 0.0 and near > depth[j, i]:
                    depth[j, i] = near
                wa += wax
                wb += wbx
                wc += wcx
                near += rise


@njit(cache=True, error_model="numpy", nogil=True)
def _share_seen(x, y, z, axes, scale, depth):
    """Share of the light that reaches a point: the four nearest cells, each seen or not, mixed by nearness."""
    cells = depth.shape[0]
    u = (axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z) * scale + 0.5 * cells - 0.5
    v = (axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z) * scale + 0.5 * cells - 0.5
    near = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
    i, j = int(np.floor(u)), int(np.floor(v))
    if i < 0 or j < 0 or i >= cells - 1 or j >= cells - 1:
        return 1.0
    fu, fv = u - i, v - j
    share = 0.0
    if near >= depth[j, i]:
        share += (1 - fu) * (1 - fv)
    if near >= depth[j, i + 1]:
        share += fu * (1 - fv)
    if near >= depth[j + 1, i]:
        share += (1 - fu) * fv
    if near >= depth[j + 1, i + 1]:
        share += fu * fv
    return share


@njit(cache=True, error_model="numpy", nogil=True)
def _key_share(x, y, z, nx, ny, nz, facing, step, axes, scale, depth):
    """The key light is large: the mean over nine points of its map, ``step`` mm apart, for a soft edge.

    The points lie in the plane of the surface, so that a slanting surface does not shade itself.
    """
    share = 0.0
    steep = 1.0 / max(facing, 0.25)
    for p in range(-1, 2):
        for q in range(-1, 2):
            dx = step * (p * axes[0, 0] + q * axes[1, 0])
            dy = step * (p * axes[0, 1] + q * axes[1, 1])
            dz = step * (p * axes[0, 2] + q * axes[1, 2])
            back = -(nx * dx + ny * dy + nz * dz) * steep
            dx, dy, dz = dx + back * axes[2, 0], dy + back * axes[2, 1], dz + back * axes[2, 2]
            share += _share_seen(x + dx, y + dy, z + dz, axes, scale, depth)
    return share / 9.0


@njit(cache=True, error_model="numpy", parallel=True, nogil=True)
def vertex_light(
    vertices, normals, listed, both_sides, place, scatter, lift, cavity, spacing, axes, colours, wrap, bounce, centre,
    radius, key_map, soft_maps, light, openness,
):  # fmt: skip
    """Light at the listed vertices; sheets are lit on the side that the camera at ``place`` sees.

    ``light`` (vertices, 3) receives what a white matt surface would send back, ``openness`` (vertices, 2) the share of
    the key light, and of the dome, that reaches it.
    """
    key_scale, soft_scale = 0.5 * key_map.shape[0] / radius, 0.5 * soft_maps.shape[1] / radius
    for number in prange(listed.shape[0]):
        v = listed[number]
        nx, ny, nz = normals[v, 0], normals[v, 1], normals[v, 2]
        px, py, pz = vertices[v, 0] - centre[0], vertices[v, 1] - centre[1], vertices[v, 2] - centre[2]
        if both_sides[v]:
            ex, ey, ez = place[0] - vertices[v, 0], place[1] - vertices[v, 1], place[2] - vertices[v, 2]
            if nx * ex + ny * ey + nz * ez < 0:
                nx, ny, nz = -nx, -ny, -nz
        s, off = scatter[v], lift[v]
        off_soft = off + (SOFT_CELLS_OFF / soft_scale if off > 0.5 else 0.0)
        red = green = blue = 0.0
        dome = dome_seen = 1e-6
        openness[v, 0] = 0.0
        for k in range(axes.shape[0]):
            lx, ly, lz = axes[k, 2, 0], axes[k, 2, 1], axes[k, 2, 2]
            facing = nx * lx + ny * ly + nz * lz
            if facing <= (DOME_REACH if k >= 3 else -s * wrap[0] - SLACK):
                continue
            # Off the surface and a little towards the light, so that a surface does not shade itself.
            if k == 0:
                qx, qy, qz = px + off * (nx + lx), py + off * (ny + ly), pz + off * (nz + lz)
                step = max(KEY_EDGE_MM, 0.8 * spacing[v])  # an edge finer than the mesh would be jagged
                seen = _key_share(qx, qy, qz, nx, ny, nz, facing, step, axes[0], key_scale, key_map)
                openness[v, 0] = seen
            else:
                qx, qy, qz = px + off_soft * (nx + lx), py + off_soft * (ny + ly), pz + off_soft * (nz + lz)
                seen = _share_seen(qx, qy, qz, axes[k], soft_scale, soft_maps[k - 1])
            if k >= 3:
                plain = max(facing + 0.3, 0.0)
                dome += plain
                dome_seen += plain * seen
            wr, wg, wb = s * wrap[0], s * wrap[1], s * wrap[2]
            red += seen * colours[k, 0] * max(facing + wr, 0.0) / (1 + wr)
            green += seen * colours[k, 1] * max(facing + wg, 0.0) / (1 + wg)
            blue += seen * colours[k, 2] * max(facing + wb, 0.0) / (1 + wb)
        # What does not see the dome sees flesh instead, and gets a little red light back from it.
        closed = 1.0 - dome_seen / dome
        openness[v, 1] = 1.0 - closed
        left = 1.0 - cavity[v] * closed
        openness[v, 0] *= left
        light[v, 0] = left * red + closed * bounce[0]
        light[v, 1] = left * green + closed * bounce[1]
        light[v, 2] = left * blue + closed * bounce[2]


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
