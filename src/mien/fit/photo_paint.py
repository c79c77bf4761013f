"""The skin's texture out of photographs: seen, evened in light, blended around the head, and filled where none looked.

For every texel of the skin's texture the place and the facing on the fitted head are known, so each photograph is
looked up through its camera; a depth map tells what it sees. Steps:

0. Eyes and lashes are left out: lids are filled from the skin around them.
1. Light is divided out of each photograph: nine spherical harmonics of the facing (Ramamoorthi and Hanrahan 2001),
   fitted to the ratio of the photograph to the default face's paint, normalised over what is seen.
2. Colours of the further photographs are matched to the first, channel by channel, where both see the skin.
3. Blending in two bands: what is broad mixes widely, detail comes from the photograph that looks most squarely.
4. What no photograph sees is mirrored from the other side of the face if that was seen, else the default face's
   paint in the colours of its surroundings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt, gaussian_filter, zoom
from scipy.spatial import cKDTree

from mien.face.head_space import HeadSpace
from mien.face.render.raster_maps import Grid, draw_triangles, sample
from mien.face.surface import vertex_normals
from mien.fit.eye_cut import inside_outline
from mien.fit.photo_camera import PhotoCamera

__all__ = ["PaintSettings", "Painted", "paint_from_photos"]

Floats = NDArray[np.float32]

_SEEN_MM = 2.0
_DEPTH_SIDE = 700
_LASHES_MM = (2.0, 3.0, 4.0, 5.0, 6.0)  # beyond the margins of the lids: where paint begins to count
_RIM_SHARE = 0.02  # of the head's size in the picture: what lies nearer its outline may be background


@dataclass(frozen=True)
class PaintSettings:
    """How photographs become paint.

    Attributes
    ----------
    size : int
        Texels on a side of the texture.
    even_light : float
        How much of the light that was found is divided out, 0..1.
    feather : float
        Width over which a photograph fades at the rim of what it sees, share of the texture's side.
    """

    size: int = 1536
    even_light: float = 0.9
    feather: float = 0.02


@dataclass(frozen=True, eq=False)
class Painted:
    """The texture (size, size, 3), sRGB bytes, and how much of each texel came from a photograph, 0..1."""

    texture: NDArray[np.uint8]
    seen: Floats


@dataclass(frozen=True, eq=False)
class _Texels:
    """Where the texels that the skin uses lie: row by row of the texture."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    corners: NDArray[np.int32]  # (m, 3) vertices
    weights: Floats  # (m, 3)

    def spread(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of vertices (n, c) at the texels, (m, c)."""
        return np.asarray(np.einsum("mk,mkc->mc", self.weights, values[self.corners]))


def linear(srgb: NDArray[np.generic]) -> Floats:
    """Linear light of sRGB 0..1."""
    value = np.asarray(srgb, dtype=np.float32)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


def srgb(light: Floats) -> Floats:
    """The sRGB values, 0..1, of linear light."""
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055).astype(np.float32)


def paint_from_photos(
    space: HeadSpace,
    skin: NDArray[np.float64],
    pictures: Sequence[NDArray[np.uint8]],
    cameras: Sequence[PhotoCamera],
    settings: PaintSettings | None = None,
) -> Painted:
    """Paint the default skin, fitted to a head, from photographs of it.

    Parameters
    ----------
    space : HeadSpace
    skin : ndarray, shape (n, 3)
        The fitted skin, mm.
    pictures : sequence of ndarray of uint8, shape (height, width, 3)
        The first sets the colours.
    cameras : sequence of PhotoCamera
    settings : PaintSettings, optional
    """
    settings = settings or PaintSettings()
    size = settings.size
    texels = _texels(space, size)
    tint = texels.spread(space.skin.colours.astype(np.float64))
    default = _default_paint(space, texels, size) * linear(tint)
    normals = vertex_normals(skin, space.triangles)
    keep = _steady(space)
    layers, weights = [], []
    for picture, camera in zip(pictures, cameras, strict=True):
        weight = _weight(space, skin, normals, texels, camera, settings) * texels.spread(keep[:, None])[:, 0]
        weight *= _off_the_eyes(space, skin, texels, camera)
        colours = _looked_up(skin, texels, picture, camera)
        facing = texels.spread(normals)
        layers.append(_evened(colours, default, facing, weight, settings.even_light))
        weights.append(weight.astype(np.float32))
    layers = _matched(layers, weights)
    return _blended(space, texels, layers, weights, default, tint, settings)


# ------------------------------------------------------------------ the texture and the skin


def _texels(space: HeadSpace, size: int) -> _Texels:
    places = space.skin.uv.astype(np.float64) * size
    grid: Grid = draw_triangles(places, np.ones(len(places)), space.triangles, size, size)
    rows, columns = np.nonzero(grid.triangle >= 0)
    weights = grid.weights[rows, columns]
    return _Texels(rows, columns, space.triangles[grid.triangle[rows, columns]], weights)


def _default_paint(space: HeadSpace, texels: _Texels, size: int) -> Floats:
    texture = space.skin.material.texture
    assert texture is not None
    places = (np.stack([texels.columns, texels.rows], axis=1) + 0.5) * (texture.shape[0] / size)
    return linear(sample(texture.astype(np.float32) / np.float32(255), places))


def _steady(space: HeadSpace) -> NDArray[np.float64]:
    """1 on skin that photographs may paint; 0 in the mouth, behind the lids."""
    return np.asarray(np.clip(1.5 - 2 * space.inside_mouth, 0, 1) * np.clip(1.2 - space.socket, 0, 1))


def _weight(
    space: HeadSpace,
    skin: NDArray[np.float64],
    normals: NDArray[np.float64],
    texels: _Texels,
    camera: PhotoCamera,
    settings: PaintSettings,
) -> NDArray[np.float64]:
    """How squarely and how safely a camera sees each texel, 0..1."""
    share = _DEPTH_SIDE / max(camera.width, camera.height)
    height, width = (max(8, round(side * share)) for side in (camera.height, camera.width))
    seen, away = camera.seen(skin)
    depth = draw_triangles(seen * share, away, space.triangles, height, width).depth
    places = texels.spread(np.column_stack([seen * share, away]))
    column, row = (np.clip(places[:, k].astype(int), 0, side - 1) for k, side in ((0, width), (1, height)))
    around = np.minimum.reduce(
        [
            depth[np.clip(row + r, 0, height - 1), np.clip(column + c, 0, width - 1)]
            for r, c in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
        ]
    )
    way = camera.place() - texels.spread(skin)
    square = np.einsum("mc,mc->m", texels.spread(normals), way) / np.linalg.norm(way, axis=1)
    margin = 0.01 * max(width, height)
    within = (
        (places[:, 0] > margin)
        & (places[:, 0] < width - margin)
        & (places[:, 1] > margin)
        & (places[:, 1] < height - margin)
    )
    clear = within & (square > 0.12) & (places[:, 2] < around + _SEEN_MM + 2.0 / np.maximum(square, 0.1))
    mask = np.ones((settings.size, settings.size), dtype=np.bool_)
    mask[texels.rows, texels.columns] = clear
    head = np.isfinite(depth)
    inside = distance_transform_edt(np.pad(head, 1, mode="edge"))[1:-1, 1:-1][row, column]
    silhouette = np.clip(inside / (_RIM_SHARE * np.sqrt(head.sum())) - 0.3, 0, 1)
    inward = distance_transform_edt(mask)[texels.rows, texels.columns]
    fade = np.clip(inward / (settings.feather * settings.size) - 0.15, 0, 1)
    return np.asarray(clear * np.clip((square - 0.12) / 0.88, 0, 1) ** 1.5 * fade * silhouette)


def _off_the_eyes(
    space: HeadSpace, skin: NDArray[np.float64], texels: _Texels, camera: PhotoCamera
) -> NDArray[np.float64]:
    """0 where a photograph shows the eyeball and the lashes about it, 1 from some millimetres off.

    Lids are filled from the skin around, so that no open eye is painted on shut lids.
    """
    seen, _ = camera.seen(texels.spread(skin))
    off = np.ones(len(seen))
    for loop in (space.lid_loop_left, space.lid_loop_right):
        outline, _ = camera.seen(skin[loop])
        unit = np.ptp(outline, axis=0).max() / max(float(np.ptp(skin[loop], axis=0).max()), 1e-6)  # pixels in a mm
        middle = outline.mean(axis=0)
        arm = outline - middle
        length = np.maximum(np.linalg.norm(arm, axis=1, keepdims=True), 1e-6)
        reach = length.max() + _LASHES_MM[-1] * unit
        near = np.flatnonzero((np.abs(seen - middle) < reach).all(axis=1))
        for margin in _LASHES_MM:
            wider = middle + arm * (1 + margin * unit / length)
            off[near] -= inside_outline(seen[near], wider) / len(_LASHES_MM)
    return np.clip(off, 0, 1)


def _looked_up(skin: NDArray[np.float64], texels: _Texels, picture: NDArray[np.uint8], camera: PhotoCamera) -> Floats:
    seen, _ = camera.seen(texels.spread(skin))
    return linear(sample(picture.astype(np.float32) / np.float32(255), seen))


# ------------------------------------------------------------------ light and colour


def _harmonics(facing: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, z = (facing / np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)).T
    rows = [np.ones_like(x), x, y, z, x * y, y * z, 3 * z**2 - 1, x * z, x**2 - y**2]
    return np.stack(rows, axis=1)


def _evened(
    colours: Floats, default: Floats, facing: NDArray[np.float64], weight: NDArray[np.float64], share: float
) -> Floats:
    """Divide the light out of what a photograph shows, as far as the skin's facing explains it."""
    chosen = np.flatnonzero(weight > 0.15)[::23]
    if len(chosen) < 200 or share <= 0:
        return colours
    basis = _harmonics(facing)
    even = np.empty_like(colours)
    for channel in range(3):
        ratio = np.maximum(colours[chosen, channel], 1e-4) / np.maximum(default[chosen, channel], 0.02)
        light = basis @ _robust_fit(basis[chosen], ratio)
        middle = float(np.average(light[chosen], weights=weight[chosen]))
        light = np.clip(light / max(middle, 1e-4), 0.25, 3.0)
        even[:, channel] = colours[:, channel] / light**share
    return even


def _robust_fit(basis: NDArray[np.float64], wanted: Floats) -> NDArray[np.float64]:
    """Harmonics of a light, little heeding where hair, brows and lips are another than the default's."""
    ridge = 1e-3 * len(basis) * np.diag([0.0, 1, 1, 1, 2, 2, 2, 2, 2])
    trust = np.ones(len(basis))
    found: NDArray[np.float64] = np.zeros(basis.shape[1], dtype=np.float64)
    for _ in range(6):
        rows = basis * trust[:, None]
        found = np.asarray(np.linalg.solve(rows.T @ rows + ridge, rows.T @ (wanted * trust)), np.float64)
        gap = np.abs(basis @ found - wanted)
        trust = 1 / np.sqrt(1 + (gap / (1.5 * np.median(gap) + 1e-6)) ** 2)
    return found


def _matched(layers: list[Floats], weights: list[Floats]) -> list[Floats]:
    """Bring the further photographs to the colours of the first where both see."""
    matched = [layers[0]]
    for layer, weight in zip(layers[1:], weights[1:], strict=True):
        both = (weights[0] > 0.08) & (weight > 0.08)
        gain = np.ones(3, np.float32)
        if both.sum() > 300:
            ratio = np.log(np.maximum(layers[0][both], 1e-3)) - np.log(np.maximum(layer[both], 1e-3))
            gain = np.exp(np.clip(np.median(ratio, axis=0), -1.2, 1.2)).astype(np.float32)
        matched.append(layer * gain)
    return matched


# ------------------------------------------------------------------ blending


def _image(texels: _Texels, values: Floats, size: int) -> Floats:
    image = np.zeros((size, size, values.shape[1]), dtype=np.float32)
    image[texels.rows, texels.columns] = values
    return image


def _broad(image: Floats, weight: Floats, sigma: float) -> Floats:
    """A weighted Gaussian mean, at a quarter of the size, continued where nothing has weight."""
    step = 4
    small_weight = _shrunk(weight[:, :, None], step)
    small = _shrunk(image * weight[:, :, None], step)
    total = np.zeros_like(small)
    total_weight = np.full_like(small_weight, 1e-9)
    for scale, share in ((1, 1.0), (3, 1e-2), (9, 1e-4), (27, 1e-6)):
        blur = (sigma * scale / step, sigma * scale / step, 0)
        total += share * gaussian_filter(small, blur, mode="nearest")
        total_weight += share * gaussian_filter(small_weight, blur, mode="nearest")
    return np.asarray(zoom(total / total_weight, (step, step, 1), order=1, grid_mode=True, mode="nearest"))


def _shrunk(image: Floats, step: int) -> Floats:
    height, width, channels = image.shape
    return np.asarray(image.reshape(height // step, step, width // step, step, channels).mean(axis=(1, 3)))


def _blended(
    space: HeadSpace,
    texels: _Texels,
    layers: Sequence[Floats],
    weights: Sequence[Floats],
    default: Floats,
    tint: NDArray[np.float64],
    settings: PaintSettings,
) -> Painted:
    size = settings.size
    sigma = size / 90
    total = np.zeros((size, size, 3), np.float32)
    total_weight = np.zeros((size, size, 1), np.float32)
    fine = np.zeros_like(total)
    fine_weight = np.zeros_like(total_weight)
    for layer, weight in zip(layers, weights, strict=True):
        image, alpha = _image(texels, layer, size), _image(texels, weight[:, None], size)
        broad = _broad(image, alpha[:, :, 0], sigma)
        total += alpha * broad
        total_weight += alpha
        fine += alpha**4 * (image - broad)
        fine_weight += alpha**4
    seen_by_any = np.clip(total_weight / 0.12, 0, 1).astype(np.float32)
    seen = total / np.maximum(total_weight, 1e-6) + fine / np.maximum(fine_weight, 1e-9)
    seen = np.clip(seen, 0, 1).astype(np.float32)
    mirrored, mirrored_weight = _mirrored(space, texels, np.asarray(seen, np.float32), seen_by_any, size)
    known = seen_by_any * seen + (1 - seen_by_any) * mirrored_weight * mirrored
    known_weight = seen_by_any + (1 - seen_by_any) * mirrored_weight
    fill = _filled(_image(texels, default, size), known / np.maximum(known_weight, 1e-6), known_weight, sigma)
    paint = known + (1 - known_weight) * fill
    flat = paint[texels.rows, texels.columns] / np.maximum(linear(tint), 0.05)
    texture = _padded(_image(texels, srgb(flat), size), texels, size)
    return Painted(np.rint(texture * 255).astype(np.uint8), seen_by_any[:, :, 0])


def _mirrored(space: HeadSpace, texels: _Texels, seen: Floats, weight: Floats, size: int) -> tuple[Floats, Floats]:
    """What the other side of the face shows, and how surely."""
    partner = cKDTree(space.rest).query(space.rest * np.array([-1.0, 1.0, 1.0]))[1]
    places = texels.spread(space.skin.uv[partner].astype(np.float64)) * size
    stretched = np.ptp(space.skin.uv[partner][texels.corners], axis=1).max(axis=1) > 0.05
    both = sample(np.concatenate([seen, weight], axis=2), places)
    sure = np.where(stretched, 0.0, both[:, 3]).astype(np.float32)
    return _image(texels, both[:, :3], size), _image(texels, sure[:, None], size)


def _filled(default: Floats, known: Floats, weight: Floats, sigma: float) -> Floats:
    """The default's paint in the colours of what is known around it."""
    ratio = np.log(np.maximum(known, 2e-3)) - np.log(np.maximum(default, 2e-3))
    there = default.sum(axis=2) > 1e-4
    sure = there & (weight[:, :, 0] > 0.9)
    usual = np.median(ratio[sure], axis=0) if sure.any() else np.zeros(3, np.float32)
    # At the rim of what is seen colours are least sure: the farther from it, the more the usual ones count.
    broad = _broad(ratio, np.where(sure, 1.0, 0.0).astype(np.float32) * there, 3 * sigma)
    broad = usual + np.clip(broad - usual, -0.35, 0.35)
    return np.asarray(np.clip(default * np.exp(broad), 0, 1), dtype=np.float32)


def _padded(image: Floats, texels: _Texels, size: int) -> Floats:
    """Texels beside the skin's own take the nearest one's colour, so that sampling at a seam finds no black."""
    used = np.zeros((size, size), dtype=np.bool_)
    used[texels.rows, texels.columns] = True
    rim = binary_dilation(used, iterations=8) & ~used
    nearest = distance_transform_edt(~used, return_distances=False, return_indices=True)
    out = image.copy()
    out[rim] = image[nearest[0][rim], nearest[1][rim]]
    rest = ~used & ~rim
    out[rest] = image[used].mean(axis=0)
    return out
