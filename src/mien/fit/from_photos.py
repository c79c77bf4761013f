"""A person's face out of photographs: shape, paint, colours of hair and eyes; it moves as the default face does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.core.errors import Note
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import SKIN, HeadSpace, head_space
from mien.face.model import Face, Material, Part
from mien.face.surface import vertex_normals
from mien.fit.photo_camera import PhotoCamera
from mien.fit.photo_marks import Photo
from mien.fit.photo_obstacles import obstacles
from mien.fit.photo_paint import Painted, PaintSettings, paint_from_photos
from mien.fit.photo_white import balanced, colour_of_light, lamp_note, light_note
from mien.fit.shape_from_photos import PhotoFit, PhotoFitSettings, shape_from_photos

__all__ = ["PhotoFace", "face_from_photos"]

Floats = NDArray[np.float64]

_HAIR_PARTS = ("hair", "hair_clumps")
_IRIS_RADIUS, _PUPIL_RADIUS = 0.144, 0.078  # of the eye's texture, as tools/bake_face/eyes.py paints it


_LEAST_IRIS = 10  # pixels across below which its colour cannot be told


@dataclass(frozen=True, eq=False)
class PhotoFace:
    """The result of `face_from_photos`."""

    face: Face
    fit: PhotoFit
    painted: Painted
    notes: tuple[Note, ...]


def face_from_photos(
    photos: Sequence[Photo],
    name: str = "me",
    eye_distance: float | None = None,
    hair: bool = True,
    shape: PhotoFitSettings | None = None,
    paint: PaintSettings | None = None,
) -> PhotoFace:
    """Make a face after photographs.

    Parameters
    ----------
    photos : sequence of Photo
        The first from the front.
    name : str
        Of the face.
    eye_distance : float, optional
        Between the eyeballs' centres, mm.
    hair : bool
        Keep the default's short hair, in the hair's colour; without, what the photographs show is on the skin alone.
    shape, paint
        Settings of the two steps.

    Raises
    ------
    InputError
        As `mien.fit.shape_from_photos.shape_from_photos` does.
    """
    space = head_space()
    fit = shape_from_photos(space, photos, eye_distance, shape)
    reshaped = reshaped_face(space, fit.vertices, name)
    pictures = [photo.picture for photo in photos]
    centred, cameras = _about_the_eyes(reshaped.face, fit)
    skin = centred.part(SKIN).vertices.astype(np.float64)
    posed = skin + fit.posed - fit.vertices
    pictures, told = _in_neutral_light(space, centred, posed, pictures, cameras, photos[0].name)
    painted = paint_from_photos(space, posed, pictures, cameras, paint)
    parts = [_repainted(space, part, painted, pictures, cameras, centred) for part in centred.parts]
    kept = tuple(part for part in parts if part.name != "brows" and (hair or part.name not in _HAIR_PARTS))
    face = replace(centred, parts=kept, licence="")
    before = obstacles(space, fit.posed, pictures[0], fit.cameras[0], photos[0].name)
    return PhotoFace(face, fit, painted, (*fit.notes, *before, *told))


def _in_neutral_light(
    space: HeadSpace,
    face: Face,
    skin: Floats,
    pictures: list[NDArray[np.uint8]],
    cameras: Sequence[PhotoCamera],
    name: str,
) -> tuple[list[NDArray[np.uint8]], list[Note]]:
    """The first picture without the cast of its light (the others are matched to it), and what is said of the light."""
    irises = []
    for eye in face.eyes:
        radius = float(np.median(np.linalg.norm(face.part(eye.part).vertices - np.array(eye.centre), axis=1)))
        irises.append(np.array([*np.add(eye.centre, (0.0, 0.0, 0.9 * radius)), 0.42 * radius]))
    notes = [lamp_note(space, skin, pictures[0], cameras[0], name)]
    light = colour_of_light(space, skin, pictures[0], cameras[0], tuple(irises))
    if light is not None:
        notes.append(light_note(name, light))
        pictures = [balanced(pictures[0], light), *pictures[1:]]
    return pictures, [note for note in notes if note is not None]


def _about_the_eyes(face: Face, fit: PhotoFit) -> tuple[Face, list[PhotoCamera]]:
    """Put the origin midway between the eyes, as every face has it."""
    middle = np.mean([eye.centre for eye in face.eyes], axis=0)

    def shifted(point: Sequence[float]) -> tuple[float, float, float]:
        x, y, z = (float(c) for c in np.subtract(point, middle))
        return x, y, z

    parts = tuple(replace(part, vertices=(part.vertices - middle).astype(np.float32)) for part in face.parts)
    eyes = tuple(replace(eye, centre=shifted(eye.centre)) for eye in face.eyes)
    cameras = [replace(camera, shift=camera.shift + camera.matrix() @ middle) for camera in fit.cameras]
    return replace(face, parts=parts, eyes=eyes, head_pivot=shifted(face.head_pivot)), cameras


def _repainted(
    space: HeadSpace,
    part: Part,
    painted: Painted,
    pictures: Sequence[NDArray[np.uint8]],
    cameras: Sequence[PhotoCamera],
    face: Face,
) -> Part:
    if part.name == SKIN:
        return replace(part, material=replace(part.material, texture=painted.texture))
    if part.name in _HAIR_PARTS:
        colour = _hair_colour(space, painted, pictures, cameras, face)
        return part if colour is None else _coloured(part, colour)
    if part.name in {eye.part for eye in face.eyes}:
        eye = next(eye for eye in face.eyes if eye.part == part.name)
        iris = _iris_colour(part, np.array(eye.centre), pictures[0], cameras[0])
        return part if iris is None else replace(part, material=_eye_material(part.material, iris))
    return part


def _hair_colour(
    space: HeadSpace,
    painted: Painted,
    pictures: Sequence[NDArray[np.uint8]],
    cameras: Sequence[PhotoCamera],
    face: Face,
) -> Floats | None:
    """Median colour (sRGB 0..1) of the scalp under the default's hair, as photographs show it."""
    skin = face.part(SKIN)
    away = cKDTree(face.part("hair").vertices).query(skin.vertices)[0]
    size = painted.texture.shape[0]
    place = np.clip((skin.uv * size).astype(int), 0, size - 1)
    seen = painted.seen[place[:, 1], place[:, 0]] > 0.3
    scalp = np.flatnonzero((away < 8.0) & seen & (skin.vertices[:, 1] > 25.0))
    normals = vertex_normals(skin.vertices.astype(np.float64), skin.triangles)
    found = []
    for picture, camera in zip(pictures, cameras, strict=True):
        points = skin.vertices[scalp].astype(np.float64)
        square = np.einsum("nc,nc->n", normals[scalp], camera.place() - points) > 0
        column, row = camera.seen(points[square])[0].astype(int).T
        within = (column >= 0) & (row >= 0) & (column < picture.shape[1]) & (row < picture.shape[0])
        found.append(picture[row[within], column[within]] / 255)
    colours = np.concatenate(found)
    return np.asarray(np.median(colours, axis=0), dtype=np.float64) if len(colours) >= 60 else None


def _coloured(part: Part, wanted: Floats) -> Part:
    """Hair in another colour: texture and vertex colours keep their pattern, their mean becomes the wanted one."""
    material = part.material
    if material.texture is not None:
        texture = material.texture.astype(np.float64) / 255
        mean = texture.reshape(-1, 3).mean(0)
        texture = np.clip(texture * (wanted / np.maximum(mean, 0.02)), 0, 1)
        return replace(part, material=replace(material, texture=np.rint(texture * 255).astype(np.uint8)))
    mean = part.colours.mean(0) * np.array(material.colour)
    colours = np.clip(part.colours * (wanted / np.maximum(mean, 0.02)), 0, 1)
    return replace(part, colours=colours.astype(np.float32))


def _iris_colour(part: Part, centre: Floats, picture: NDArray[np.uint8], camera: PhotoCamera) -> Floats | None:
    """Median colour of the iris's lower sides in the photograph from the front: no lashes, seldom a highlight."""
    radius = float(np.median(np.linalg.norm(part.vertices - centre, axis=1)))
    turns, rings = np.meshgrid(np.radians([*range(195, 260, 8), *range(281, 346, 8)]), [0.5, 0.6, 0.7])
    reach = 0.385 * radius * rings.ravel()
    points = centre + np.stack(
        [reach * np.cos(turns.ravel()), reach * np.sin(turns.ravel()), np.sqrt(radius**2 - reach**2)], axis=1
    )
    seen, _ = camera.seen(points)
    if np.ptp(seen[:, 0]) < _LEAST_IRIS:
        return None
    column, row = seen[:, 0].astype(int), seen[:, 1].astype(int)
    if not ((column >= 0) & (column < picture.shape[1]) & (row >= 0) & (row < picture.shape[0])).all():
        return None
    colours = picture[row, column] / 255
    order = np.argsort(colours.sum(axis=1))
    return np.asarray(colours[order[len(order) // 5 : len(order) // 2]].mean(axis=0), dtype=np.float64)


def _eye_material(material: Material, wanted: Floats) -> Material:
    """The iris in another colour; pupil, rim and white stay."""
    if material.texture is None:
        return material
    texture = material.texture.astype(np.float64) / 255
    size = texture.shape[0]
    place = (np.arange(size) + 0.5) / size - 0.5
    radius = np.hypot(*np.meshgrid(place, place))
    iris = (radius > _PUPIL_RADIUS * 1.15) & (radius < _IRIS_RADIUS * 0.9)
    mean = texture[iris].mean(0)
    gain = np.clip(wanted / np.maximum(mean, 0.02), 0.3, 3.5)
    inside = np.clip((radius - _PUPIL_RADIUS) / 0.008, 0, 1) * np.clip((_IRIS_RADIUS - radius) / 0.01, 0, 1)
    texture = texture * (1 + inside[:, :, None] * (gain - 1))
    return replace(material, texture=np.rint(np.clip(texture, 0, 1) * 255).astype(np.uint8))
