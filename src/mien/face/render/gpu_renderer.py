"""`GpuRenderer`: the pictures of `mien.face.render.renderer.Renderer`, their pixels drawn by a graphics card.

The processor poses, places and lights the vertices with the same kernels; the card finds what each pixel shows (four
samples, nearest triangle) and shades it (`mien.face.render.gpu_shaders`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.posing import PosedFace
from mien.face.render import rasteriser as raster
from mien.face.render.colour import SRGB_BYTES
from mien.face.render.gpu_shaders import BUFFERS, ENCODED, PLACED, SHADED, WHOLE_PICTURE
from mien.face.render.graphics_card import graphics_card
from mien.face.render.relief import tile
from mien.face.render.renderer import LINEAR_OF_BYTE, Picture, Renderer, Room

__all__ = ["GpuRenderer"]

_COLUMNS = "3f 3f 3f 2f 2f 2f 1f", "in_place", "in_normal", "in_diffuse", "in_gloss", "in_open", "in_uv", "in_solid"


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
        lit, openness = self._light(vertices, normals, needed, threads)
        raster.pack(normals, lit, openness, scene.albedo, scene.gloss, np.flatnonzero(needed), points)
        self._folded(posed, room, seen)
        solid, clear = np.flatnonzero(seen & ~self._clear), np.flatnonzero(seen & self._clear)
        drawn = np.concatenate([solid, clear])
        part = scene.triangle_part[drawn]
        about = np.empty((len(drawn), 4), np.int32)
        about[:, :3], about[:, 3] = scene.texture_level[part, np.maximum(room.level[drawn], 0)], part
        return self._card.do(lambda: self._canvas.draw(points, scene.triangles[drawn], about, len(solid), room))


class _Canvas:
    """What a renderer keeps on the card; made and used in the card's thread."""

    def __init__(self, context: Any, renderer: Renderer) -> None:
        import moderngl

        self._gl, self._context = moderngl, context
        scene, lights, camera = renderer.scene, renderer.lighting, renderer.camera
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
        self._buffers = {
            "triangles": context.buffer(reserve=16 * count, dynamic=True),
            "parts": context.buffer(parts.tobytes()),
            "texels": context.buffer(_in_words(scene.texels)),
            "alphas": context.buffer(_in_words(scene.alphas)),
            "tables": context.buffer(tables.tobytes()),
        }
        self._points = context.buffer(reserve=4 * raster.COLUMNS * len(scene.uv), dynamic=True)
        self._corners = context.buffer(reserve=12 * count, dynamic=True)
        self._relief = context.texture(tile().shape[:2], 3, tile().tobytes(), dtype="f4")
        uniforms: dict[str, Any] = {
            "size": size,
            "nearest": raster.NEAREST_MM,
            "per_pixel": 1 / camera.focal_pixels(renderer.height),
            "view": camera.axes(),  # its rows are the columns of OpenGL's matrix
            "directions": lights.directions[:3],
            "colours": lights.colours[:3],
            "sky": lights.sky,
            "exposure": lights.exposure,
            "relief_share": renderer.relief_share,
        }
        self._painters = []
        for clear in (0, 1):
            shaded = SHADED.replace("#define CLEAR 0", f"#define CLEAR {clear}")
            program = context.program(vertex_shader=PLACED, fragment_shader=shaded)
            for name, value in uniforms.items():
                program[name].write(np.array(value, np.float32).tobytes())
            painter = context.vertex_array(program, [(self._points, *_COLUMNS)], index_buffer=self._corners)
            self._painters.append((program, painter))
        self._encoding = context.program(vertex_shader=WHOLE_PICTURE, fragment_shader=ENCODED)
        self._encoding["transparent"].value = renderer.transparent
        for number, name in enumerate(("total", "behind", "backdrop")):
            self._encoding[name].value = number
        self._encoder = context.vertex_array(self._encoding, [])

    def draw(
        self,
        points: NDArray[np.float32],
        corners: NDArray[np.int32],
        about: NDArray[np.int32],
        solid: int,
        room: Room,
    ) -> Picture:
        """The picture of triangles ``corners`` (t, 3), of which the first ``solid`` ones hide what is behind.

        ``about`` (t, 4): of the level of the texture the first texel, width (0: none) and height; and the part.
        """
        context, gl = self._context, self._gl
        self._points.write(points)
        self._corners.write(corners)
        self._buffers["triangles"].write(about)
        for change in room.changed:
            begin, end = 12 * (change.start // 4), min(room.texels.size, 12 * -(-change.stop // 4))  # in whole words
            self._buffers["texels"].write(room.texels.reshape(-1)[begin:end], offset=begin)
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
        return picture


def _in_words(numbers: NDArray[np.uint8]) -> bytes:
    """The bytes, filled up to whole words, and one word more: a texel may begin in the last."""
    return numbers.tobytes() + bytes(4 + -numbers.size % 4)
