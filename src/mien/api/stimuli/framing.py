"""What of a face a stimulus shows, and in front of what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, unknown_name
from mien.face.model import Face
from mien.face.posing import PosedFace
from mien.face.render.camera import Camera, head_extent
from mien.face.render.colour import linear_from_srgb
from mien.face.render.lighting import Lighting
from mien.face.render.renderer import Picture, Renderer

__all__ = ["CROPS", "Framing", "background_colour", "check_crop", "framing"]

# Half the height and half the width of the oval, as shares of the head's height over the eyes: hair, ears and neck go.
_OVAL_HALF_HEIGHT, _OVAL_HALF_WIDTH, _OVAL_CENTRE = 0.76, 0.53, -0.1


def _about_the_oval(face: Face, aspect: float) -> Camera:
    """The face with room for the oval."""
    camera, (crown, _, _) = Camera.head_shot(face, aspect), head_extent(face)
    centre = (camera.target[0], _OVAL_CENTRE * crown, camera.target[2])
    return replace(camera, target=centre, field_mm=2.2 * crown * max(_OVAL_HALF_HEIGHT, _OVAL_HALF_WIDTH / aspect))


CROPS: dict[str, Callable[[Face, float], Camera]] = {
    "portrait": Camera.portrait,
    "head": Camera.head_shot,
    "oval": _about_the_oval,
    "mouth": Camera.close_up,
    "eyes": Camera.eyes,
}
"""Names of crops: head and shoulders; the head; the face in an oval; the mouth; the eyes and brows."""


def check_crop(name: str) -> None:
    """Refuse a crop that is not one of `CROPS`."""
    if name not in CROPS:
        raise unknown_name("crop", name, tuple(CROPS))


def background_colour(name: str) -> tuple[int, int, int] | None:
    """The colour in sRGB bytes; None for an empty name.

    Examples
    --------
    >>> background_colour("#102030"), background_colour("grey")
    ((16, 32, 48), (128, 128, 128))
    """
    from PIL import ImageColor

    if not name:
        return None
    try:
        colour = ImageColor.getrgb(name)
    except ValueError:
        raise InputError(f"background is a colour such as #808080 or black, not {name!r}") from None
    return colour[0], colour[1], colour[2]


@dataclass(frozen=True)
class Framing:
    """A renderer that lays an aperture over its pictures.

    Attributes
    ----------
    renderer : Renderer
    cover : ndarray of float32, shape (height, width, 1), or None
        0 where the face is seen, 1 where the background covers it.
    """

    renderer: Renderer
    cover: NDArray[np.float32] | None

    def render(self, posed: PosedFace) -> Picture:
        """As `Renderer.render`."""
        picture = self.renderer.render(posed)
        if self.cover is None:
            return picture
        mixed = picture * (1 - self.cover) + self.renderer.empty() * self.cover
        return np.asarray(np.rint(mixed), dtype=np.uint8)


def framing(face: Face, crop: str, background: str, width: int, height: int) -> Framing:
    """How a face is pictured.

    Parameters
    ----------
    face : Face
    crop : str
        One of `CROPS`.
    background : str
        As for `background_colour`.
    width, height : int
        Pixels.

    Raises
    ------
    InputError
        If a name is not known or the size is out of range.
    """
    check_crop(crop)
    colour = background_colour(background)
    lighting = Lighting.portrait()
    if colour is not None:
        linear = linear_from_srgb(np.array(colour) / 255)
        lighting = replace(lighting, background=np.tile(linear, (2, 1)).astype(np.float32))
    camera = CROPS[crop](face, width / height)
    cover = _oval(face, camera, width, height) if crop == "oval" else None
    return Framing(Renderer(face, width, height, camera, lighting), cover)


def _oval(face: Face, camera: Camera, width: int, height: int) -> NDArray[np.float32]:
    """1 outside an upright oval about the face, 0 inside, a pixel's step between."""
    crown, _, _ = head_extent(face)
    scale = height / camera.field_mm
    down = (np.arange(height)[:, None] + 0.5 - height / 2) / scale + camera.target[1] - _OVAL_CENTRE * crown
    across = (np.arange(width)[None, :] + 0.5 - width / 2) / scale
    vertical, horizontal = _OVAL_HALF_HEIGHT * crown, _OVAL_HALF_WIDTH * crown
    outside = (np.hypot(across / horizontal, down / vertical) - 1) * horizontal * scale
    cover: NDArray[np.float32] = np.clip(outside + 0.5, 0, 1).astype(np.float32)
    return cover[..., None]
