"""`View`: what of a face a picture shows, how large, in what light, before what; the same for every command."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, unknown_name
from mien.face.model import Face
from mien.face.posing import PosedFace
from mien.face.render.camera import Camera, camera_table, head_extent
from mien.face.render.lighting import Lighting
from mien.face.render.renderer import MAX_SIDE, Picture, Renderer

__all__ = [
    "PAINTERS",
    "QUALITIES",
    "TRANSPARENT",
    "Pictures",
    "View",
    "background_colour",
    "parse_size",
    "with_options",
]

TRANSPARENT = "transparent"
QUALITIES = {"draft": 0.5, "full": 1.0, "best": 2.0}
"""Names of qualities, and how many times the picture's width is drawn to make it."""
PAINTERS = ("processor", "gpu")
"""What draws: the processor, with the same bits from run to run, or a graphics card (an extra)."""
_LEAST_SIDE, _USUAL = 16, (1280, 720)
# Half the height and half the width of the oval, as shares of the head's height over the eyes: hair, ears and neck go.
_OVAL_HALF_HEIGHT, _OVAL_HALF_WIDTH = 0.76, 0.53


class Pictures(Protocol):
    """What draws a posed face."""

    def render(self, posed: PosedFace) -> Picture:
        """The picture, shape (height, width, 3 or 4) uint8, sRGB; a fourth number is opacity."""


@dataclass(frozen=True)
class View:
    """How a face is pictured; what cannot be is refused when it is made.

    Attributes
    ----------
    width, height : int
        Pixels, before `crop`; 16 to `MAX_SIDE`. Both 0: as is usual, 1280 x 720 (on contact sheets 320 x 360).
    camera : str
        One of `mien.face.render.camera.known_cameras`, or a ``.toml`` file; empty: the portrait, with the oval the
        face.
    light : str
        One of `mien.face.render.lighting.known_lightings`, or a ``.toml`` file.
    background : str
        A colour (``#808080``, ``black``), a picture file, ``transparent``; empty: the light's own.
    crop : str
        Empty; ``oval``: the background covers all but the face; ``LEFT,TOP,WIDTHxHEIGHT``: these pixels only.
    quality : str
        One of `QUALITIES`.
    painter : str
        One of `PAINTERS`.

    Raises
    ------
    InputError
        If one of them cannot be used.
    mien.core.errors.MissingPartError
        If the painter is ``gpu``, and there is none.

    Examples
    --------
    >>> View(720, 1280, camera="three-quarter", background="transparent").transparent
    True
    """

    width: int = 0
    height: int = 0
    camera: str = ""
    light: str = "portrait"
    background: str = ""
    crop: str = ""
    quality: str = "full"
    painter: str = "processor"

    def __post_init__(self) -> None:
        width, height = self._drawn()
        if not (_LEAST_SIDE <= width <= MAX_SIDE and _LEAST_SIDE <= height <= MAX_SIDE):
            raise InputError(
                f"a picture's sides lie between {_LEAST_SIDE} and {MAX_SIDE} pixels, not {width} x {height}"
            )
        if self.quality not in QUALITIES:
            raise unknown_name("quality", self.quality, QUALITIES)
        if QUALITIES[self.quality] * max(width, height) > MAX_SIDE:
            raise InputError(
                f"quality {self.quality} draws at twice the size: sides up to {MAX_SIDE // 2} pixels, "
                f"not {width} x {height}"
            )
        if self.painter not in PAINTERS:
            raise unknown_name("painter", self.painter, PAINTERS)
        camera_table(self.camera or "portrait")
        Lighting.named(self.light)
        self._window()
        if not self.transparent and background_colour(self.background) is None:
            self._backdrop(16, 16)
        if self.painter == "gpu":
            from mien.face.render.graphics_card import graphics_card

            graphics_card()

    @property
    def transparent(self) -> bool:
        """Whether the pictures have an opacity."""
        return self.background == TRANSPARENT

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures that come out, pixels."""
        _, _, width, height = self._window()
        return width, height

    def of_size(self, width: int, height: int) -> View:
        """The same view of this size, unless it has one."""
        return self if self.width or self.height else replace(self, width=width, height=height)

    def renderer(self, face: Face) -> Pictures:
        """What draws a face so."""
        share, size = QUALITIES[self.quality], self._drawn()
        width, height = (max(_LEAST_SIDE, round(share * side)) for side in size)
        camera = Camera.named(self.camera or ("oval" if self.crop == "oval" else "portrait"), face, width / height)
        lighting = Lighting.named(self.light)
        if (colour := background_colour(self.background)) is not None:
            lighting = lighting.before(colour)
        backdrop = None if self.transparent else self._backdrop(width, height)
        renderer = self._painter()(face, width, height, camera, lighting, backdrop, self.transparent)
        cover = _oval(face, camera, width, height) if self.crop == "oval" else None
        if cover is None and share == 1 and self._window() == (0, 0, *size):
            return renderer
        return _Finished(renderer, cover, size, self._window())

    def _painter(self) -> type[Renderer]:
        if self.painter == "processor":
            return Renderer
        from mien.face.render.gpu_renderer import GpuRenderer

        return GpuRenderer

    def _drawn(self) -> tuple[int, int]:
        return (self.width, self.height) if self.width or self.height else _USUAL

    def _window(self) -> tuple[int, int, int, int]:
        """Left, top, width and height of what is kept of a picture."""
        whole = self._drawn()
        if self.crop in ("", "oval"):
            return 0, 0, *whole
        found = re.fullmatch(r"(\d{1,6}),(\d{1,6}),(\d{1,6})x(\d{1,6})", self.crop)
        if found is None:
            raise InputError(
                f"a crop is 'oval', or pixels as LEFT,TOP,WIDTHxHEIGHT such as 320,0,640x720; got {self.crop!r}"
            )
        left, top, width, height = (int(each) for each in found.groups())
        if width < _LEAST_SIDE or height < _LEAST_SIDE or left + width > whole[0] or top + height > whole[1]:
            raise InputError(
                f"the crop {self.crop} does not fit: it is {_LEAST_SIDE} pixels or more each way, within the picture's "
                f"{whole[0]} x {whole[1]}"
            )
        return left, top, width, height

    def _backdrop(self, width: int, height: int) -> Picture | None:
        """The picture behind the face, filling this size; None where there is none."""
        if not self.background or background_colour(self.background) is not None:
            return None
        from PIL import ImageOps

        from mien.core.pictures import opened_picture

        if not Path(self.background).is_file():
            raise InputError(
                f"a background is a colour (#808080, black), a picture file, or transparent, not {self.background!r}: "
                "there is no such colour, and no such file"
            )
        with opened_picture(self.background) as picture:
            upright = ImageOps.exif_transpose(picture).convert("RGB")
            return np.asarray(ImageOps.fit(upright, (width, height)), dtype=np.uint8)


@dataclass(frozen=True)
class _Finished:
    """Pictures of a renderer, brought to a size, covered outside an aperture, and cut."""

    renderer: Renderer
    cover: NDArray[np.float32] | None
    size: tuple[int, int]
    window: tuple[int, int, int, int]

    def render(self, posed: PosedFace) -> Picture:
        picture = self.renderer.render(posed)
        if self.cover is not None:
            mixed = picture * (1 - self.cover) + self.renderer.empty() * self.cover
            picture = np.asarray(np.rint(mixed), dtype=np.uint8)
        width, height = self.size
        if picture.shape[:2] != (height, width):
            from PIL import Image

            way = Image.Resampling.BOX if picture.shape[1] > width else Image.Resampling.BICUBIC
            picture = np.asarray(Image.fromarray(picture).resize((width, height), way))
        left, top, width, height = self.window
        return np.ascontiguousarray(picture[top : top + height, left : left + width])


def _oval(face: Face, camera: Camera, width: int, height: int) -> NDArray[np.float32]:
    """1 outside an upright oval about the camera's target, 0 inside, a pixel's step between; (height, width, 1)."""
    crown, scale = head_extent(face).crown, height / camera.field_mm
    down = (np.arange(height)[:, None] + 0.5 - height / 2) / scale
    across = (np.arange(width)[None, :] + 0.5 - width / 2) / scale
    vertical, horizontal = _OVAL_HALF_HEIGHT * crown, _OVAL_HALF_WIDTH * crown
    outside = (np.hypot(across / horizontal, down / vertical) - 1) * horizontal * scale
    cover: NDArray[np.float32] = np.clip(outside + 0.5, 0, 1).astype(np.float32)
    return cover[..., None]


def background_colour(name: str) -> tuple[int, int, int] | None:
    """The colour in sRGB bytes; None where the name is none of a colour.

    Examples
    --------
    >>> background_colour("#102030"), background_colour("grey"), background_colour("beach.jpg")
    ((16, 32, 48), (128, 128, 128), None)
    """
    from PIL import ImageColor

    try:
        colour = ImageColor.getrgb(name) if name else None
    except ValueError:
        return None
    return None if colour is None else (colour[0], colour[1], colour[2])


def parse_size(text: str) -> tuple[int, int]:
    """Width and height in pixels of a text such as ``1280x720``.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> parse_size("1080x1920")
    (1080, 1920)
    """
    found = re.fullmatch(r"\s*(\d{1,9})\s*[xX×*]\s*(\d{1,9})\s*", text)
    if found is None:
        raise InputError(f"a size is WIDTHxHEIGHT in pixels, such as 1280x720 or 1080x1920, not {text!r}")
    width, height = int(found[1]), int(found[2])
    if not width or not height:
        raise InputError(f"a picture has at least one pixel each way, not {text.strip()}")
    return width, height


def with_options(view: View, given: Mapping[str, str | None]) -> View:
    """A view with some of its fields, and ``size``, given as texts; None leaves a field.

    Raises
    ------
    InputError
        If one cannot be used.
    """
    fields: dict[str, object] = {name: text for name, text in given.items() if text is not None and name != "size"}
    if (size := given.get("size")) is not None:
        fields["width"], fields["height"] = parse_size(size)
    return replace(view, **fields)  # type: ignore[arg-type]
