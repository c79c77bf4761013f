"""The renderer again in plain numpy: slow, for small pictures, the referee of the compiled kernels in the tests.

It follows the description in `mien.face.render.light` and `mien.face.render.rasteriser` and shares with them only the
constants.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.posing import PosedFace
from mien.face.render import light
from mien.face.render import rasteriser as raster
from mien.face.render.colour import linear_from_srgb, tone
from mien.face.render.relief import PIT_SHADE, SLOPE_SHADE, tile
from mien.face.render.renderer import SPREAD_STEPS, Renderer
from mien.face.render.scene import Scene
from mien.face.render.shading import MOST_SHINE

__all__ = ["render_reference"]

Array = NDArray[Any]


def render_reference(renderer: Renderer, posed: PosedFace) -> NDArray[np.uint8]:
    """The same picture as ``renderer.render(posed)``, up to rounding."""
    texels = renderer.folded(posed)
    vertices, normals = (each.astype(np.float64) for each in renderer.joined(posed))
    place = _project(renderer, vertices)
    drawn = _drawn(renderer, place)
    nearest, owner = _cover(renderer, place, drawn)
    needed = np.zeros(len(vertices), dtype=bool)
    needed[renderer.scene.triangles[_surfaces(renderer, nearest, owner)]] = True
    lit, openness = _light(renderer, vertices, normals, needed)
    return _resolve(renderer, texels, place, normals, lit, openness, nearest, owner)


def _project(renderer: Renderer, vertices: Array) -> Array:
    """Place in the picture (pixels, snapped) and 1 / depth."""
    camera = renderer.camera
    view = (vertices - camera.place()) @ camera.axes().T
    depth, focal = -view[:, 2], camera.focal_pixels(renderer.height)
    x, y = 0.5 * renderer.width + focal * view[:, 0] / depth, 0.5 * renderer.height - focal * view[:, 1] / depth
    return np.stack([np.rint(x * 256) / 256, np.rint(y * 256) / 256, 1 / depth], axis=1)


def _drawn(renderer: Renderer, place: Array) -> Array:
    """Numbers of the triangles that face the camera, or are of a sheet, and touch the picture."""
    scene, corner = renderer.scene, place[renderer.scene.triangles]
    area = _doubled_area(corner)
    sheet = scene.sheet[scene.triangle_part]
    low, high = corner.min(axis=1), corner.max(axis=1)
    inside = (high[:, 0] >= 0) & (high[:, 1] >= 0) & (low[:, 0] < renderer.width) & (low[:, 1] < renderer.height)
    return np.flatnonzero(inside & ((area < 0) | (sheet & (area > 0))))


def _doubled_area(corner: Array) -> Array:
    a, b, c = corner[..., 0, :2], corner[..., 1, :2], corner[..., 2, :2]
    return _edge(b - a, c - a)


def _edge(u: Array, v: Array) -> Array:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _shares(corner: Array, points: Array) -> Array:
    """Shares of the three corners at points in the plane of the picture (not yet perspective)."""
    a, b, c = (corner[..., k, :2] for k in range(3))
    whole = _doubled_area(corner)
    parts = [_edge(b - points, c - points), _edge(c - points, a - points), _edge(a - points, b - points)]
    return np.stack([part / whole for part in parts], axis=-1)


def _depth_map(renderer: Renderer, vertices: Array, axes: Array, cells: int) -> Array:
    scene = renderer.scene
    coarse = scene.coarse_casters, scene.coarse_vertices
    casters, listed = renderer.key_casters if cells == renderer.key_cells else coarse
    seen = (vertices - scene.head_centre) @ axes.T
    seen[:, :2] = seen[:, :2] * (0.5 * cells / scene.head_radius) + 0.5 * cells
    depth = np.full((cells, cells), -1e9)
    for corner in seen[listed][casters]:
        if _doubled_area(corner) <= 0:
            continue
        (left, low), (right, high) = (
            np.clip(np.ceil(corner.min(0)[:2] - 0.5), 0, cells).astype(int),
            np.clip(np.floor(corner.max(0)[:2] - 0.5), -1, cells - 1).astype(int),
        )
        if left > right or low > high:
            continue
        j, i = np.mgrid[low : high + 1, left : right + 1]
        shares = _shares(corner, np.stack([i + 0.5, j + 0.5], axis=-1))
        near = np.where((shares >= 0).all(axis=-1), shares @ corner[:, 2], -1e9)
        depth[j, i] = np.maximum(depth[j, i], near)
    return depth


def _seen(points: Array, axes: Array, radius: float, depth: Array) -> Array:
    cells = len(depth)
    place = points @ axes.T
    at = place[:, :2] * (0.5 * cells / radius) + 0.5 * cells - 0.5
    corner = np.floor(at).astype(int)
    inside = ((corner >= 0) & (corner < cells - 1)).all(axis=1)
    corner = np.clip(corner, 0, cells - 2)
    u, v = (at - corner).T
    total = np.zeros(len(points))
    for i, j, share in ((0, 0, (1 - u) * (1 - v)), (1, 0, u * (1 - v)), (0, 1, (1 - u) * v), (1, 1, u * v)):
        total += share * (place[:, 2] >= depth[corner[:, 1] + j, corner[:, 0] + i])
    return np.where(inside, total, 1.0)


def _light(renderer: Renderer, vertices: Array, normals: Array, needed: Array) -> tuple[Array, Array]:
    scene, lights = renderer.scene, renderer.lighting
    towards = renderer.camera.place() - vertices
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    hair, outwards = scene.lit_side == 2, ((vertices - scene.head_centre) * normals).sum(axis=1)
    turned = np.where(hair, outwards < 0, (scene.lit_side == 1) & ((towards * normals).sum(axis=1) < 0))
    normals = np.where(turned[:, None], -normals, normals)
    shaded = np.where(hair, np.clip(light.LIT_THROUGH + 2 * (towards * normals).sum(axis=1), 0, 1), 1)
    lit, openness = np.zeros_like(vertices), np.zeros((len(vertices), 2))
    dome, dome_seen = np.full(len(vertices), 1e-6), np.full(len(vertices), 1e-6)
    soft_cell = 2 * scene.head_radius / light.SOFT_CELLS
    for number, axes in enumerate(light.light_axes(lights.directions).astype(np.float64)):
        cells = renderer.key_cells if number == 0 else light.SOFT_CELLS
        depth = _depth_map(renderer, vertices, axes, cells)
        facing = normals @ axes[2]
        off = scene.lift + (light.SOFT_CELLS_OFF * soft_cell * (scene.lift > 0.5) if number else 0)
        points = vertices - scene.head_centre + off[:, None] * (normals + axes[2])
        reached = facing > (light.DOME_REACH if number >= 3 else -scene.scatter * lights.wrap[0] - light.SLACK)
        if number == 0:
            seen = _key_seen(renderer, points, normals, facing, axes, depth)
            openness[:, 0] = np.where(reached, seen, 0)
        else:
            seen = _seen(points, axes, scene.head_radius, depth)
        if number >= 3:
            plain = np.where(reached, np.maximum(facing + 0.3, 0), 0)
            dome += plain
            dome_seen += plain * seen
        wrap = scene.scatter[:, None] * lights.wrap
        share = np.maximum(facing[:, None] + wrap, 0) / (1 + wrap)
        lit += np.where(reached[:, None], seen[:, None] * lights.colours[number] * share, 0)
        if number in (0, 2):
            lit += scene.thin[:, None] * _shining_through(renderer, number, points, facing, axes, depth)
    openness[:, 1] = dome_seen / dome
    left = 1 - scene.cavity * (1 - openness[:, 1])
    openness[:, 0] *= left
    left *= light.INNER + (1 - light.INNER) * shaded
    lit = np.where(needed[:, None], left[:, None] * lit + (1 - openness[:, 1:]) * lights.bounce, 0)
    openness *= shaded[:, None]
    for _ in range(SPREAD_STEPS):
        lit = _spread(renderer, lit, needed)
    return lit, openness


def _shining_through(renderer: Renderer, number: int, points: Array, facing: Array, axes: Array, depth: Array) -> Array:
    """What a light sends through the flesh between its own side and these points."""
    scene, lights, cells = renderer.scene, renderer.lighting, len(depth)
    place = points @ axes.T
    at = np.floor(place[:, :2] * (0.5 * cells / scene.head_radius) + 0.5 * cells - 0.5).astype(int)
    inside = np.asarray(((at >= 0) & (at < cells - 1)).all(axis=1))
    at = np.where(inside[:, None], at, 0)
    nearest = np.max([depth[at[:, 1] + j, at[:, 0] + i] for i in (0, 1) for j in (0, 1)], axis=0)
    thick = np.maximum(nearest - place[:, 2] + scene.lift, light.LEAST_THICK_MM)[:, None] / (
        lights.reach_mm * light.THROUGH_MM
    )
    behind = np.clip(light.THROUGH_RISE * (light.THROUGH - facing), 0, 1)[:, None]
    return np.asarray(lights.colours[number] * behind / (1 + thick + thick**2 / 2 + thick**3 / 6))


def _key_seen(renderer: Renderer, points: Array, normals: Array, facing: Array, axes: Array, depth: Array) -> Array:
    step = np.maximum(light.KEY_EDGE_MM, 0.8 * renderer.scene.spacing)[:, None]
    total = np.zeros(len(points))
    for p in (-1, 0, 1):
        for q in (-1, 0, 1):
            aside = step * (p * axes[0] + q * axes[1])
            back = -(normals * aside).sum(axis=1) / np.maximum(facing, 0.25)
            total += _seen(points + aside + back[:, None] * axes[2], axes, renderer.scene.head_radius, depth)
    return total / 9


def _spread(renderer: Renderer, lit: Array, needed: Array) -> Array:
    scene = renderer.scene
    first = np.repeat(np.arange(len(lit)), np.diff(scene.neighbour_start))
    weight = scene.neighbour_weight * needed[scene.neighbour][:, None]
    total, share = np.zeros_like(lit), np.ones_like(lit)
    np.add.at(total, first, weight * lit[scene.neighbour])
    np.add.at(share, first, weight)
    return np.asarray(np.where(needed[:, None], (lit + total[scene.welded]) / share[scene.welded], lit))


def _cover(renderer: Renderer, place: Array, drawn: Array) -> tuple[Array, Array]:
    """Per sample, shape (height, width, 4): 1 / depth of the nearest triangle, and its number or -1."""
    height, width = renderer.height, renderer.width
    nearest, owner = np.zeros((height, width, 4), np.float32), np.full((height, width, 4), -1)
    for triangle in drawn:
        corner = place[renderer.scene.triangles[triangle]]
        left, low = np.maximum(np.floor(corner.min(axis=0)[:2]), 0).astype(int)
        right, high = np.floor(corner.max(axis=0)[:2]).astype(int) + 1
        y, x = np.mgrid[low : min(high, height), left : min(right, width)]
        points = np.stack([x, y], axis=-1)[:, :, None, :] + raster.SAMPLES
        shares = _shares(corner, points)
        near = (shares @ corner[:, 2]).astype(np.float32)
        wins = (shares >= 0).all(axis=-1) & (near > nearest[y, x])
        if renderer.scene.clear[renderer.scene.triangle_part[triangle]]:
            wins &= _kept(renderer, triangle, corner, x, y)
        nearest[y, x] = np.where(wins, near, nearest[y, x])
        owner[y, x] = np.where(wins, triangle, owner[y, x])
    return nearest, owner


def _kept(renderer: Renderer, triangle: int, corner: Array, x: Array, y: Array) -> Array:
    """Which samples of a triangle that is seen through are kept, for its opacity, shape (..., 4)."""
    scene = renderer.scene
    part, corners = scene.triangle_part[triangle], scene.triangles[triangle]
    kept = np.full(x.shape, float(scene.opacity[part]))
    if scene.texture_level[part, 0, 1] > 0:
        shares = np.maximum(_shares(corner, np.stack([x + 0.5, y + 0.5], axis=-1)), 0) * corner[:, 2]
        uv = shares @ scene.uv[corners] / shares.sum(axis=-1, keepdims=True)
        first, wide, tall = _fitting_level(scene, corners, corner, part)
        at = np.clip(np.floor(uv * (wide, tall)).astype(int), 0, (wide - 1, tall - 1))
        kept = kept * scene.alphas[first + at[..., 1] * wide + at[..., 0]] / 255
    threshold = (np.arange(4) + part & 3) + renderer.noise[y & 7, x & 7][..., None]
    return np.asarray(4 * kept[..., None] > threshold)


def _fitting_level(scene: Scene, corners: Array, corner: Array, part: int) -> list[int]:
    """First texel, width and height of the level of a texture that fits a triangle's size."""
    levels = scene.texture_level[part]
    spread = _doubled_area(scene.uv[corners].astype(np.float64)) / _doubled_area(corner)
    ratio = abs(spread) * levels[0, 1] * levels[0, 2]
    chosen = int(np.clip(np.ceil(np.log2(max(ratio, 1e-9) / 2) / 2), 0, len(levels) - 1))
    return [int(each) for each in levels[chosen]]


def _fragments(scene: Scene, nearest: Array, owner: Array) -> Iterator[tuple[Array, Array, int, Array]]:
    """Surfaces seen in pixels: rows, columns, the first sample of each, and which of the four samples show it."""
    part, left = np.where(owner >= 0, scene.triangle_part[owner], -1), owner >= 0
    for s in range(4):
        y, x = np.nonzero(left[:, :, s])
        too, near = nearest[y, x], nearest[y, x, s][:, None]
        same = left[y, x] & (part[y, x] == part[y, x, s][:, None])
        same &= np.abs(too - near) < raster.SAME_SURFACE_MM * too * near
        same &= np.arange(4) >= s
        same[:, s] = True
        left[y, x] &= ~same
        if len(y):
            yield y, x, s, same


def _surfaces(renderer: Renderer, nearest: Array, owner: Array) -> Array:
    """Numbers of the triangles that fragments are shaded by."""
    found = [owner[y, x, s] for y, x, s, _ in _fragments(renderer.scene, nearest, owner)]
    return np.unique(np.concatenate([np.zeros(0, int), *found]))


def _resolve(
    renderer: Renderer,
    texels: Array,
    place: Array,
    normals: Array,
    lit: Array,
    openness: Array,
    nearest: Array,
    owner: Array,
) -> NDArray[np.uint8]:
    """Shade each surface once per pixel, mix over the background, encode."""
    scene = renderer.scene
    total, solid = np.zeros((*owner.shape[:2], 3)), np.zeros((*owner.shape[:2], 1))
    for y, x, s, same in _fragments(scene, nearest, owner):
        count = same.sum(axis=1, keepdims=True)
        points = np.stack([x, y], axis=1) + same @ raster.SAMPLES / count
        colour, opacity = _shade(renderer, texels, owner[y, x, s], points, place, normals, lit, openness)
        total[y, x] += 0.25 * count * opacity * colour
        solid[y, x] += 0.25 * count * opacity
    down = (np.arange(renderer.height)[:, None, None] + 0.5) / renderer.height
    top, bottom = renderer.lighting.background
    value = np.clip(total + (1 - solid) * (top + down * (bottom - top)), 0, 1)
    srgb = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    row, column = np.indices(owner.shape[:2])
    dither = renderer.noise[row & 7, column & 7][..., None]
    return np.asarray(np.minimum(255 * srgb + dither, 255), dtype=np.uint8)


def _shade(
    renderer: Renderer,
    texels: Array,
    triangles: Array,
    points: Array,
    place: Array,
    normals: Array,
    lit: Array,
    openness: Array,
) -> tuple[Array, Array]:
    scene, camera, lights = renderer.scene, renderer.camera, renderer.lighting
    corners = scene.triangles[triangles]
    corner = place[corners]
    shares = np.maximum(_shares(corner, points), 0) * corner[:, :, 2]
    shares /= shares.sum(axis=1, keepdims=True)

    def mix(values: Array) -> Array:
        return np.asarray(np.einsum("pk,pk...->p...", shares, values[corners]))

    colour = mix(lit * scene.albedo) * _texture(renderer.scene, texels, triangles, corner, mix(scene.uv))
    middle = 0.5 * np.array([renderer.width, renderer.height])
    out = (points - middle) * (-1, 1) / camera.focal_pixels(renderer.height)
    view = np.hstack([out, np.ones((len(out), 1))]) @ camera.axes()
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    normal = mix(normals) * np.where(_doubled_area(corner) > 0, -1, 1)[:, None]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    alpha, head_on = mix(scene.gloss).T
    key, dome = mix(openness).T
    if renderer.relief_share > 0:
        normal, shade = _roughened(renderer, triangles, mix(scene.uv), normal, key)
        colour *= shade
    straight = (normal * view).sum(axis=1)
    facing = np.maximum(straight, 0.05)
    gain = np.minimum(1, 12.5 * head_on)
    for number in range(3):
        towards = lights.directions[number].astype(np.float64)
        cosine = normal @ towards
        half = view + towards
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        spread = np.maximum((normal * half).sum(axis=1), 0) ** 2 * (alpha**2 - 1) + 1
        fresnel = head_on + (1 - head_on) * (1 - (view * half).sum(axis=1)) ** 5 * gain
        masked = 2 * cosine * facing * (1 - alpha) + (cosine + facing) * alpha
        shine = np.where(cosine > 0, 0.5 * alpha**2 / spread**2 * fresnel / masked * cosine, 0)
        shine = np.minimum(shine, MOST_SHINE / alpha)
        colour += (shine * (key if number == 0 else dome**4))[:, None] * lights.colours[number]
    up = (2 * straight * normal[:, 1] - view[:, 1])[:, None]
    sky = np.where(up > 0, lights.sky[1] + up * (lights.sky[0] - lights.sky[1]), 0)
    sky = np.where(up > 0, sky, lights.sky[1] - up * (lights.sky[2] - lights.sky[1]))
    grazing = head_on + (np.maximum(1 - alpha, head_on) - head_on) * (1 - facing) ** 5 * gain
    colour += (grazing * dome**2)[:, None] * sky
    return tone(np.asarray(lights.exposure * colour)).astype(np.float64), mix(scene.solid)[:, None]


def _roughened(renderer: Renderer, triangles: Array, uv: Array, normal: Array, key: Array) -> tuple[Array, Array]:
    """Normals bent by the relief of skin, and what it makes of diffuse light, shape (n, 1)."""
    tiles = renderer.scene.tiles[renderer.scene.triangle_part[triangles]].astype(np.float64)
    found, size = tile(), len(tile())
    at = uv * tiles[:, None] * size - 0.5
    corner = np.floor(at).astype(int)
    u, v = (at - corner).T
    total = np.zeros((len(uv), 3))
    for i, j, share in ((0, 0, (1 - u) * (1 - v)), (1, 0, u * (1 - v)), (0, 1, (1 - u) * v), (1, 1, u * v)):
        total += share[:, None] * found[(corner[:, 1] + j) % size, (corner[:, 0] + i) % size]
    total *= renderer.relief_share * (tiles > 0)[:, None]
    across = np.stack([normal[:, 2], np.zeros(len(uv)), -normal[:, 0]], axis=1)
    across /= np.sqrt((across**2).sum(axis=1, keepdims=True) + 1e-6)
    moved = total[:, :1] * across + total[:, 1:2] * np.cross(normal, across)
    bent = normal - moved
    turned = -moved @ renderer.lighting.directions[0]
    shade = 1 + float(SLOPE_SHADE) * key * turned - float(PIT_SHADE) * total[:, 2]
    return bent / np.linalg.norm(bent, axis=1, keepdims=True), shade[:, None]


def _texture(scene: Scene, texels: Array, triangles: Array, corner: Array, uv: Array) -> Array:
    """The texture's colour, linear, at each point; ones where there is none."""
    parts = scene.triangle_part[triangles]
    colour = np.ones((len(uv), 3))
    for point in np.flatnonzero(scene.texture_level[parts, 0, 1] > 0):
        first, wide, tall = _fitting_level(scene, scene.triangles[triangles[point]], corner[point], parts[point])
        picture = linear_from_srgb(texels[first : first + wide * tall] / 255).reshape(tall, wide, 3)
        at = uv[point] * (wide, tall) - 0.5
        corner_at = np.floor(at).astype(int)
        u, v = at - corner_at
        i = np.clip(corner_at[0] + np.arange(2), 0, wide - 1)
        j = np.clip(corner_at[1] + np.arange(2), 0, tall - 1)
        colour[point] = np.einsum("j,i,jic->c", (1 - v, v), (1 - u, u), picture[np.ix_(j, i)])
    return colour
