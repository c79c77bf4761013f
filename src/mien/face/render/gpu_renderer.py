"""`GpuRenderer`: the pictures of `mien.face.render.renderer.Renderer`, their pixels drawn by a graphics card.

The processor poses the face and chooses the triangles that face the camera; the card lights the vertices
(`mien.face.render.gpu_light`), folds the skin, finds what each pixel shows (four samples, nearest triangle) and shades
it (`mien.face.render.gpu_shaders`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.folds import TINT, Folds
from mien.face.posing import PosedFace
from mien.face.render import rasteriser as raster
from mien.face.render.colour import SRGB_BYTES
from mien.face.render.gpu_light import LightOnCard
from mien.face.render.gpu_shaders import BUFFERS, ENCODED, FOLDED, PLACED, SHADED, WHOLE_PICTURE
from mien.face.render.graphics_card import graphics_card
from mien.face.render.relief import tile
from mien.face.render.renderer import LINEAR_OF_BYTE, Picture, Renderer, Room
from mien.face.render.scene import LEVELS

__all__ = ["GpuRenderer"]


class GpuRenderer(Renderer):
    """Renders as `Renderer` does, with the same parameters; pictures may differ by a little from card to card.

    Raises
    ------
    InputError
        If the size is out of range, or the card has no room for it.
    mien.core.errors.MissingPartError
        If there is no card that can draw (`mien.face.render.graphics_card`).
    """

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self._card = graphics_card()
        self._clear = self.scene.clear[self.scene.triangle_part]
        self._canvas = self._card.do(lambda: _Canvas(self._card.context, self))

    def _drawn(
        self,
        posed: PosedFace,
        vertices: NDArray[np.float32],
        normals: NDArray[np.float32],
        room: Room,
        threads: int,
    ) -> Picture:
        scene, camera, points = self.scene, self.camera, room.points
        seen, needed = np.zeros(len(scene.triangles), np.bool_), np.zeros(len(vertices), np.bool_)
        focal = camera.focal_pixels(self.height)
        raster.project(vertices, camera.place(), camera.axes(), focal, self.width, self.height, points)
        _, listed, _ = raster.sort_into_bands(
            points, scene.triangles, scene.triangle_part, scene.sheet, self.width, self.height
        )
        seen[listed] = True  # what others hide among them, too
        raster.set_up(
            points, scene.triangles, scene.triangle_part, scene.texture_level, seen, needed, room.planes, room.level
        )
        finest = np.full(len(scene.sheet), LEVELS - 1, dtype=np.int8)
        raster.finest_levels(seen, scene.triangle_part, room.level, finest)
        solid, clear = np.flatnonzero(seen & ~self._clear), np.flatnonzero(seen & self._clear)
        drawn = np.concatenate([solid, clear])
        levels = LEVELS * scene.triangle_part[drawn] + np.maximum(room.level[drawn], 0)
        corners = scene.triangles[drawn]

        def paint() -> Picture:
            for folds, number in zip(canvas.folds, folded, strict=True):
                folds.lay(posed.channels, int(scene.texture_level[number, finest[number], 0]))
            return canvas.draw(vertices, normals, corners, levels, len(solid))

        canvas, folded = self._canvas, [number for _, _, number in self.folds]
        return self._card.do(paint)

    def _room(self) -> Room:
        return Room(self.scene, self.height, self.width, False)  # its texels are those without folds


def _uniforms(renderer: Renderer) -> dict[str, Any]:
    """What the shader of surfaces is told once: camera, lights and relief."""
    lights, camera = renderer.lighting, renderer.camera
    return {
        "size": (renderer.width, renderer.height),
        "nearest": raster.NEAREST_MM,
        "focal": camera.focal_pixels(renderer.height),
        "place": camera.place(),
        "view": camera.axes(),  # its rows are the columns of OpenGL's matrix
        "directions": lights.directions[:3],
        "colours": lights.colours[:3],
        "sky": lights.sky,
        "exposure": lights.exposure,
        "relief_share": renderer.relief_share,
    }


class _Canvas:
    """What a renderer keeps on the card; made and used in the card's thread."""

    def __init__(self, context: Any, renderer: Renderer) -> None:
        import moderngl

        self._gl, self._context = moderngl, context
        scene = renderer.scene
        self._shape = renderer.height, renderer.width, 4 if renderer.transparent else 3
        size, count = (renderer.width, renderer.height), len(scene.triangles)
        context.gc()
        try:
            self._samples = context.framebuffer(
                [context.renderbuffer(size, 4, samples=4, dtype="f2")], context.depth_renderbuffer(size, samples=4)
            )
            self._total = context.texture(size, 4, dtype="f2")
            self._resolved = context.framebuffer([self._total])
            self._picture = context.framebuffer([context.renderbuffer(size, 4)])
            self._behind = context.texture(size, 3, renderer.behind.tobytes(), dtype="f4", alignment=4)
            self._backdrop = context.texture(size, 3, renderer.backdrop.tobytes(), alignment=1)
        except moderngl.Error as problem:
            raise InputError(f"the graphics card cannot draw {size[0]} x {size[1]} pixels: {problem}") from problem
        tables = np.concatenate([LINEAR_OF_BYTE, SRGB_BYTES, renderer.noise.reshape(-1)]).astype(np.float32)
        parts = np.stack([scene.tiles, scene.opacity], axis=1)
        part = np.arange(len(parts))[:, None, None]
        levels = np.concatenate([scene.texture_level, np.broadcast_to(part, (len(parts), LEVELS, 1))], axis=2)
        self._buffers = {
            "triangles": context.buffer(reserve=4 * count, dynamic=True),
            "parts": context.buffer(parts.tobytes()),
            "levels": context.buffer(np.ascontiguousarray(levels, np.int32).tobytes()),
            "texels": context.buffer(_in_words(scene.texels, scene.alphas)),
            "tables": context.buffer(tables.tobytes()),
        }
        self.folds = [
            _FoldsOnCard(context, folds, scene.alphas, smooth, self._buffers["texels"])
            for folds, smooth, _ in renderer.folds
        ]
        self._light = LightOnCard(context, renderer)
        fixed = context.buffer(np.hstack([scene.albedo, scene.gloss, scene.uv, scene.solid[:, None]]).tobytes())
        inputs = [
            (self._light.vertices, "3f", "in_vertex"), (self._light.normals, "3f", "in_normal"),
            (self._light.lit, "4f", "in_lit"), (self._light.dome, "1f", "in_dome"),
            (fixed, "3f 2f 2f 1f", "in_albedo", "in_gloss", "in_uv", "in_solid"),
        ]  # fmt: skip
        self._corners = context.buffer(reserve=12 * count, dynamic=True)
        self._relief = context.texture(tile().shape[:2], 3, tile().tobytes(), dtype="f4")
        self._painters = []
        for clear in (0, 1):
            shaded = SHADED.replace("#define CLEAR 0", f"#define CLEAR {clear}")
            program = context.program(vertex_shader=PLACED, fragment_shader=shaded)
            for name, value in _uniforms(renderer).items():
                program[name].write(np.array(value, np.float32).tobytes())
            painter = context.vertex_array(program, inputs, index_buffer=self._corners)
            self._painters.append((program, painter))
        self._encoding = context.program(vertex_shader=WHOLE_PICTURE, fragment_shader=ENCODED)
        self._encoding["transparent"].value = renderer.transparent
        for number, name in enumerate(("total", "behind", "backdrop")):
            self._encoding[name].value = number
        self._encoder = context.vertex_array(self._encoding, [])

    def draw(
        self,
        vertices: NDArray[np.float32],
        normals: NDArray[np.float32],
        corners: NDArray[np.int32],
        levels: NDArray[np.int32],
        solid: int,
    ) -> Picture:
        """The picture of triangles ``corners`` (t, 3), of which the first ``solid`` ones hide what is behind.

        ``levels`` (t,): which row of the table of levels tells its texture.
        """
        context, gl = self._context, self._gl
        self._light.light(vertices, normals)
        self._corners.write(corners)
        self._buffers["triangles"].write(levels)
        for name, number in BUFFERS.items():
            self._buffers[name].bind_to_storage_buffer(number)
        self._samples.use()
        self._samples.clear(depth=0.0)
        context.enable_only(gl.DEPTH_TEST)
        context.depth_func = ">="
        self._relief.use(0)
        for (program, painter), begin, count in zip(
            self._painters, (0, solid), (solid, len(corners) - solid), strict=True
        ):
            if count:
                program["first_triangle"].value = begin
                painter.render(gl.TRIANGLES, vertices=3 * count, first=3 * begin)
        context.copy_framebuffer(self._resolved, self._samples)
        self._picture.use()
        context.enable_only(gl.NOTHING)
        for number, texture in enumerate((self._total, self._behind, self._backdrop)):
            texture.use(number)
        self._encoder.render(gl.TRIANGLES, vertices=3)
        picture = np.empty(self._shape, np.uint8)
        self._picture.read_into(picture, components=self._shape[2], alignment=1)
        if (error := context.error) != "GL_NO_ERROR":
            raise InputError(f"the graphics card could not draw: {error}; --painter processor can")
        return picture


class _FoldsOnCard:
    """The folds of one texture (`mien.face.folds`) and what they need on the card."""

    def __init__(
        self, context: Any, folds: Folds, alphas: NDArray[np.uint8], smooth: NDArray[np.uint8], texels: Any
    ) -> None:
        self._folds = folds
        self._program = context.compute_shader(FOLDED)
        self._program["tint"].write(TINT.tobytes())
        entries = np.stack([folds.owners, folds.shades], axis=1).astype(np.float32)
        self._weights = context.buffer(reserve=4 * len(folds.folds))
        given = folds.texels.astype(np.int32).tobytes(), _in_words(smooth, alphas[folds.texels]), folds.starts.tobytes()
        places, unfolded, starts = (context.buffer(each) for each in given)
        self._buffers = places, unfolded, starts, texels, context.buffer(entries.tobytes()), self._weights

    def lay(self, channels: Mapping[str, float], first: int) -> None:
        """Fold all texels from ``first`` on as a pose has it."""
        begin = int(np.searchsorted(self._folds.texels, first))
        self._weights.write(self._folds.weights(channels))
        self._program["begin"].value = begin
        for number, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(number)
        self._program.run(max(1, -(-(len(self._folds.texels) - begin) // 256)))


def _in_words(texels: NDArray[np.uint8], alphas: NDArray[np.uint8]) -> bytes:
    """Red, green, blue and opacity of a texel in one number."""
    return np.column_stack([texels, alphas]).tobytes()
