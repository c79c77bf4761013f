"""The colour of the light in a photograph, by the whites of the eyes, and how far one side of the face is brighter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from mien.core.errors import Note
from mien.face.head_space import HeadSpace
from mien.fit.photo_camera import PhotoCamera

__all__ = ["balanced", "colour_of_light", "lamp_note", "light_note"]

Floats = NDArray[np.float64]

_USUAL = np.array([1.10, 1.0, 0.92])  # of a white of the eye, lit by skin around it, under neutral light: linear light
_DEAD = 0.05  # natural logarithm of a colour ratio: less than this is no cast
_MOST = 0.8
_LEAST_PIXELS = 24
_LIKE_SKIN = 0.75  # of the cheeks' red to blue: what is nearer to it is no white
_SIDES = 1.5  # times as bright as the other cheek: worth a line


def _linear(picture: NDArray[np.uint8]) -> Floats:
    value = picture.astype(np.float64) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def colour_of_light(
    space: HeadSpace, skin: Floats, picture: NDArray[np.uint8], camera: PhotoCamera, irises: tuple[Floats, ...]
) -> Floats | None:
    """Red, green and blue of the light, linear, green 1; None where the whites of the eyes are too small or too dark.

    Parameters
    ----------
    space : HeadSpace
    skin : ndarray, shape (n, 3)
        The default skin as it stands in the photograph, mm.
    picture : ndarray of uint8, shape (height, width, 3)
    camera : PhotoCamera
    irises : tuple of ndarray of shape (4,)
        Of each eye the middle of the iris and its radius, mm.
    """
    found = []
    for loop, iris in zip((space.lid_loop_left, space.lid_loop_right), irises, strict=True):
        outline = camera.seen(skin[loop])[0]
        outline = outline.mean(0) + (outline - outline.mean(0)) * (0.9, 0.75)
        middle, beside = camera.seen(np.stack([iris[:3], iris[:3] + np.array([0.0, iris[3], 0.0])]))[0]
        mask = Image.new("1", (camera.width, camera.height))
        draw = ImageDraw.Draw(mask)
        draw.polygon([tuple(point) for point in outline], fill=1)
        radius = 1.15 * float(np.linalg.norm(beside - middle))
        draw.ellipse([tuple(middle - radius), tuple(middle + radius)], fill=0)
        found.append(_linear(picture[np.asarray(mask, dtype=np.bool_)]))
    colours = np.concatenate(found)
    if len(colours) < _LEAST_PIXELS:
        return None
    order = np.argsort(colours.sum(axis=1))
    white = np.median(colours[order[len(order) // 2 : int(0.95 * len(order))]], axis=0)  # neither lashes nor glints
    cheek = np.median(np.concatenate(_cheeks(space, skin, picture, camera)), axis=0)
    if white.min() < 0.01 or white.max() > 0.98 or cheek.min() < 0.01:
        return None
    if white[0] / white[2] > _LIKE_SKIN * cheek[0] / cheek[2]:  # lids, lashes or a lens: no whites are seen
        return None
    cast = np.log(white / white[1] / _USUAL)
    cast = np.sign(cast) * np.clip(np.abs(cast) - _DEAD, 0, _MOST)
    return np.asarray(np.exp(cast))


def balanced(picture: NDArray[np.uint8], light: Floats) -> NDArray[np.uint8]:
    """The picture as under neutral light, as bright as before."""
    gain = 1 / light
    gain /= gain @ np.array([0.2126, 0.7152, 0.0722])
    value = np.clip(_linear(picture) * gain, 0, 1)
    value = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(value * 255), dtype=np.uint8)


def light_note(name: str, light: Floats) -> Note | None:
    """A line about a cast that was taken out; None where there is none worth one."""
    red, _, blue = np.log(light)
    if max(abs(red), abs(blue)) < 2 * _DEAD:
        return None
    told = f"{'warm' if red > blue else 'cold'}, red to blue {light[0] / light[2]:.1f} times that of neutral light"
    return Note("note", f"{name}: by the whites of the eyes the light is {told}: balanced")


def lamp_note(
    space: HeadSpace, skin: Floats, picture: NDArray[np.uint8], camera: PhotoCamera, name: str
) -> Note | None:
    """A line about a lamp at one side; None where both cheeks are about as bright."""
    cheeks = _cheeks(space, skin, picture, camera)
    if not all(len(colours) for colours in cheeks):
        return None
    bright = [float(np.median(colours.mean(axis=1))) for colours in cheeks]
    times = max(bright) / max(min(bright), 1e-3)
    if times < _SIDES:
        return None
    told = (
        f"the person's {'left' if bright[0] > bright[1] else 'right'} cheek is {times:.1f} times as bright as the other"
    )
    return Note("note", f"{name}: {told}: evened, but what lies in the shadow has less detail")


def _cheeks(space: HeadSpace, skin: Floats, picture: NDArray[np.uint8], camera: PhotoCamera) -> list[Floats]:
    """Linear colours of the left and the right cheek as the photograph shows them."""
    x, y, z = space.rest.T
    found = []
    for side in (1.0, -1.0):
        cheek = space.outer() & (side * x > 22) & (side * x < 46) & (y > -52) & (y < -20) & (z > -15)
        column, row = np.rint(camera.seen(skin[cheek])[0]).astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < camera.width) & (row < camera.height)
        found.append(_linear(picture[row[inside], column[inside]]))
    return found
