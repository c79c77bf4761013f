"""`Renderer`: posed faces to pictures, on the processor alone."""

from __future__ import annotations

from dataclasses import replace
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.folds import folds_of
from mien.face.model import Face
from mien.face.posing import PosedFace
from mien.face.render import light
from mien.face.render import rasteriser as raster
from mien.face.render.camera import Camera, head_extent
from mien.face.render.colour import SRGB_BYTES, SRGB_STEPS, linear_from_srgb
from mien.face.render.cores import cores, shared
from mien.face.render.detail import Detail
from mien.face.render.lighting import Lighting
from mien.face.render.relief import relief_share, tile
from mien.face.render.scene import LEVELS, Scene
from mien.face.render.shading import draw

__all__ = ["LINEAR_OF_BYTE", "MAX_SIDE", "SPREAD_STEPS", "Picture", "Renderer", "Room"]

Picture = NDArray[np.uint8]
MAX_SIDE = 8192
LINEAR_OF_BYTE = linear_from_srgb(np.arange(256) / 255)
SPREAD_STEPS = 2
_FINE_MM = 0.6  # a pixel
_CROWN_MM = 119.0  # over the eyes, of an adult


class Room:
    """Room for what one picture needs on its way."""

    def __init__(self, scene: Scene, height: int, width: int, folded: bool) -> None:
        bands, triangles = -(-height // raster.BAND), len(scene.triangles)
        self.fragments = np.empty((bands, 4 * raster.BAND * width, 2), dtype=np.int32)
        self.counts = np.zeros(bands, dtype=np.int64)
        self.planes = np.zeros((triangles, 8), dtype=np.float32)
        self.level = np.zeros(triangles, dtype=np.int8)
        self.points = _in_lines(len(scene.uv))
        self.points[:, [raster.U, raster.V]] = scene.uv
        self.points[:, raster.SOLID] = scene.solid
        self.texels = scene.texels.copy() if folded else scene.texels


class Renderer:
    """Renders one face, always from the same place and in the same light.

    The picture is the same to the bit for the same input, whatever the number of threads. Several threads may draw at
    once; a picture that is drawn alone is shared among the cores.

    Parameters
    ----------
    face : Face
        Of any size: one much smaller or larger than a head is drawn as if it were a head.
    width, height : int
        Of the picture in pixels, 16 to `MAX_SIDE`.
    camera : Camera, optional
        Default: `Camera.portrait`.
    lighting : Lighting, optional
        Default: `Lighting.portrait`.
    backdrop : ndarray of uint8, shape (height, width, 3), optional
        The picture behind the face, instead of the lighting's background.
    transparent : bool
        Whether there is nothing behind the face, and pictures have an opacity.

    Raises
    ------
    InputError
        If the size is out of range.
    """

    def __init__(
        self,
        face: Face,
        width: int = 1280,
        height: int = 720,
        camera: Camera | None = None,
        lighting: Lighting | None = None,
        backdrop: Picture | None = None,
        transparent: bool = False,
    ) -> None:
        if not (16 <= width <= MAX_SIDE and 16 <= height <= MAX_SIDE):
            raise InputError(f"a picture's sides lie between 16 and {MAX_SIDE} pixels, not {width} x {height}")
        self.face, self.width, self.height, self.transparent = face, width, height, transparent
        self.scale = _scale(face)
        self.camera = (camera or Camera.portrait(face, width / height)).scaled(self.scale)
        self.lighting = lighting or Lighting.portrait()
        whole = face if self.scale == 1 else _scaled(face, self.scale)
        self.detail = Detail.of(whole, self.camera.field_mm / height)
        self.scene = Scene.of(self.detail.face if self.detail else whole, self.lighting.reach_mm)
        self.folds = [
            (folds, self.scene.texels[folds.texels], number)
            for number, (part, levels) in enumerate(zip(face.parts, self.scene.texture_level, strict=True))
            if (folds := folds_of(part, levels[levels[:, 1] > 0])) is not None
        ]
        # Where a pixel is as large as what the coarse casters leave out, they cast the key light's shadows too.
        fine = self.camera.field_mm / height < _FINE_MM
        self.key_cells = light.KEY_CELLS if fine else light.KEY_CELLS * 5 // 8
        scene = self.scene
        self.key_casters = (
            (scene.casters, scene.caster_vertices) if fine else (scene.coarse_casters, scene.coarse_vertices)
        )
        self.relief_share = np.float32(relief_share(self.camera.field_mm / height))
        self._light_axes = light.light_axes(self.lighting.directions)
        self.noise = _dither()
        if backdrop is None:
            self.behind, self.backdrop = _background(self.lighting, width, height, self.noise)
        else:
            self.behind, self.backdrop = LINEAR_OF_BYTE[backdrop], np.ascontiguousarray(backdrop)
        # Threads take stretches of this list; busy and empty bands should be spread over them.
        bands = -(-height // raster.BAND)
        self._order = np.argsort(np.arange(bands) % 8, kind="stable")
        self._threads, self._lock, self._drawing = cores(), Lock(), 0
        self._rooms: list[Room] = []

    def render(self, posed: PosedFace) -> Picture:
        """Draw a posed face.

        Parameters
        ----------
        posed : PosedFace
            A pose of this renderer's face.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3), or (height, width, 4) where transparent
            sRGB, and opacity (colours are not multiplied by it).

        Raises
        ------
        InputError
            If the parts are not those of this face.
        """
        vertices, normals = self.joined(posed)
        with self._lock:
            self._drawing += 1
            threads = self._threads if self._drawing == 1 else 1
            room = self._rooms.pop() if self._rooms else self._room()
        try:
            return self._drawn(posed, vertices, normals, room, threads)
        finally:
            with self._lock:
                self._drawing -= 1
                self._rooms.append(room)

    def _room(self) -> Room:
        return Room(self.scene, self.height, self.width, bool(self.folds))

    def _drawn(
        self,
        posed: PosedFace,
        vertices: NDArray[np.float32],
        normals: NDArray[np.float32],
        room: Room,
        threads: int,
    ) -> Picture:
        scene, camera, lights = self.scene, self.camera, self.lighting
        axes, focal, bands = camera.axes(), camera.focal_pixels(self.height), len(self._order)
        points, needed = room.points, np.zeros(len(vertices), dtype=np.bool_)
        seen = np.zeros(len(scene.triangles), dtype=np.bool_)
        picture = np.empty((self.height, self.width, 4 if self.transparent else 3), dtype=np.uint8)
        raster.project(vertices, camera.place(), axes, focal, self.width, self.height, points)
        start, listed, reach = raster.sort_into_bands(
            points, scene.triangles, scene.triangle_part, scene.sheet, self.width, self.height
        )

        def cover(begin: int, end: int) -> None:
            raster.cover(
                points, scene.triangles, scene.triangle_part, scene.clear, scene.opacity, scene.texture_level,
                scene.alphas, self.noise, start, listed, reach, self._order, begin, end, self.height, room.fragments,
                room.counts, seen,
            )  # fmt: skip

        shared(cover, bands, threads)
        raster.set_up(
            points, scene.triangles, scene.triangle_part, scene.texture_level, seen, needed, room.planes, room.level
        )
        lit, openness = self._light(vertices, normals, needed, threads)
        raster.pack(normals, lit, openness, scene.albedo, scene.gloss, np.flatnonzero(needed), points)
        texels, view = self._folded(posed, room, seen), axes.astype(np.float32)

        def shade(begin: int, end: int) -> None:
            draw(
                points, scene.triangles, scene.triangle_part, room.planes, room.level, reach, self._order, begin, end,
                room.fragments, room.counts, texels, scene.texture_level, view, focal, lights.directions,
                lights.colours, lights.sky, self.behind, self.backdrop, lights.exposure, LINEAR_OF_BYTE, SRGB_BYTES,
                self.noise, scene.tiles, self.relief_share, tile(), picture,
            )  # fmt: skip

        shared(shade, bands, threads)
        return picture

    def folded(self, posed: PosedFace) -> NDArray[np.uint8]:
        """The texels of all parts with the folds that a pose has, shape (n, 3)."""
        return self._folded(posed, Room(self.scene, self.height, self.width, bool(self.folds)), None)

    def _folded(self, posed: PosedFace, room: Room, seen: NDArray[np.bool_] | None) -> NDArray[np.uint8]:
        """Of textures on triangles that are ``seen`` only the levels that are read are right."""
        finest = np.full(len(self.scene.sheet), 0 if seen is None else LEVELS - 1, dtype=np.int8)
        if seen is not None and self.folds:
            raster.finest_levels(seen, self.scene.triangle_part, room.level, finest)
        for folds, smooth, number in self.folds:
            first = int(self.scene.texture_level[number, finest[number], 0])
            folds.lay(folds.weights(posed.channels), smooth, room.texels, first)
        return room.texels

    def empty(self) -> Picture:
        """The background alone, of the same shape as a picture."""
        if self.transparent:
            return np.zeros((self.height, self.width, 4), dtype=np.uint8)
        return self.backdrop.copy()

    def joined(self, posed: PosedFace) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Vertices (scaled) and normals of a pose as they are drawn; InputError if it is of another face."""
        given, expected = [len(p.vertices) for p in posed.parts], [len(p.vertices) for p in self.face.parts]
        if given != expected:
            raise InputError(f"the pose has parts of {given} vertices, face {self.face.name!r} of {expected}")
        vertices = np.concatenate([part.vertices for part in posed.parts])
        normals = np.concatenate([part.normals for part in posed.parts])
        if self.scale != 1:
            vertices = vertices * np.float32(self.scale)
        if self.detail is not None:
            return self.detail.posed(vertices, normals)
        return vertices.astype(np.float32), normals.astype(np.float32)

    def _light(
        self, vertices: NDArray[np.float32], normals: NDArray[np.float32], needed: NDArray[np.bool_], threads: int
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        scene, lights = self.scene, self.lighting
        key_map = np.empty((self.key_cells, self.key_cells), dtype=np.float32)
        soft_maps = np.empty((len(lights.directions) - 1, light.SOFT_CELLS, light.SOFT_CELLS), dtype=np.float32)
        shown, lit = np.flatnonzero(needed), np.zeros_like(vertices)
        openness = np.zeros((len(vertices), 2), dtype=np.float32)

        def cast(begin: int, end: int) -> None:
            light.depth_maps(
                vertices, *self.key_casters, scene.coarse_casters, scene.coarse_vertices, self._light_axes,
                scene.head_centre, scene.head_radius, begin, end, key_map, soft_maps,
            )  # fmt: skip

        def gather(begin: int, end: int) -> None:
            light.vertex_light(
                vertices, normals, shown, scene.lit_side, self.camera.place(), scene.scatter, scene.thin, scene.lift,
                scene.cavity, scene.spacing, self._light_axes, lights.colours, lights.wrap, lights.bounce,
                lights.reach_mm * np.float32(light.THROUGH_MM), scene.head_centre, scene.head_radius, key_map,
                soft_maps, begin, end, lit, openness,
            )  # fmt: skip

        shared(cast, len(self._light_axes), threads)
        shared(gather, len(shown), threads)
        for _ in range(SPREAD_STEPS):
            spread = lit.copy()
            around = scene.neighbour_start, scene.neighbour, scene.neighbour_weight
            light.spread_below_skin(lit, shown, needed, scene.welded, *around, spread)
            lit = spread
        return lit, openness


def _in_lines(vertices: int) -> NDArray[np.float32]:
    """Room for ``points``, each row in one line of the processor's cache."""
    room = np.zeros(vertices * raster.COLUMNS + 16, dtype=np.float32)
    skipped = -room.ctypes.data % 64 // room.itemsize
    return room[skipped : skipped + vertices * raster.COLUMNS].reshape(vertices, raster.COLUMNS)


def _dither() -> NDArray[np.float32]:
    """An 8 x 8 Bayer pattern in (0, 1): added before rounding down, it hides the steps of the background's gradient."""
    pattern = np.zeros((1, 1))
    for _ in range(3):
        pattern = np.block([[4 * pattern, 4 * pattern + 2], [4 * pattern + 3, 4 * pattern + 1]])
    return ((pattern + 0.5) / 64).astype(np.float32)


def _background(
    lighting: Lighting, width: int, height: int, noise: NDArray[np.float32]
) -> tuple[NDArray[np.float32], Picture]:
    """The gradient as linear light and as pixels, both (height, width, 3)."""
    down = (np.arange(height)[:, None] + 0.5) / height
    top, bottom = lighting.background.astype(np.float64)
    linear = (top + down * (bottom - top)).astype(np.float32)
    steps = (np.sqrt(np.minimum(linear, 1.0)) * (SRGB_STEPS - 1) + 0.5).astype(int)
    # One colour has no steps to hide, and comes out as it was asked for.
    rows = np.full_like(noise, 0.5) if np.array_equal(top, bottom) else noise
    dither = rows[np.arange(height) & 7][:, :, None]
    pixels = np.minimum(SRGB_BYTES[steps][:, None, :] + dither, 255).astype(np.uint8)
    shape = height, width, 3
    behind = np.ascontiguousarray(np.broadcast_to(linear[:, None, :], shape))
    return behind, np.ascontiguousarray(np.tile(pixels, (1, -(-width // 8), 1))[:, :width])


def _scale(face: Face) -> float:
    """1 for what is about as large as a head; else what makes it so, since shadows and skin are made for that size."""
    crown = head_extent(face).crown
    return 1.0 if 30 <= crown <= 600 else _CROWN_MM / crown


def _scaled(face: Face, scale: float) -> Face:
    return replace(face, parts=tuple(replace(p, vertices=p.vertices * np.float32(scale)) for p in face.parts))
