"""Where the picture is taken from.

A pinhole camera in the face's own axes (`mien.face.model`): it looks along -z unless turned. ``field_mm`` is the height
of the picture in the plane of the target, so that moving the camera away changes the perspective and not the framing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.model import Face
from mien.face.render.tables import fields_of, known_tables, numbers, table_of

__all__ = ["Camera", "HeadExtent", "camera_table", "head_extent", "known_cameras"]

_FIELDS = ("centre", "depth", "height", "width", "distance", "yaw", "pitch")
_OVER_HAIR = 0.05  # of the crown, at least, is left free over hair that stands up
_HAIR = 1.12  # crown of the head with hair, of the crown of the skin


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Attributes
    ----------
    target : tuple of 3 float
        The point in the middle of the picture, mm.
    distance : float
        From the camera to the target, mm.
    field_mm : float
        Height of what is seen at the target, mm.
    yaw, pitch : float
        Degrees by which the camera goes round the target: yaw > 0 to the speaker's left, pitch > 0 upwards.
    """

    target: tuple[float, float, float]
    distance: float
    field_mm: float
    yaw: float = 0.0
    pitch: float = 0.0

    def __post_init__(self) -> None:
        if not (self.distance > 0 and self.field_mm > 0):
            raise InputError(
                f"a camera needs a distance and a field above 0 mm, got {self.distance:g} and {self.field_mm:g}"
            )
        if not -90 < self.pitch < 90:
            raise InputError(f"a camera's pitch lies between -90 and 90 degrees, not {self.pitch:g}")

    @classmethod
    def named(cls, name: str | Path, face: Face, aspect: float = 16 / 9) -> Camera:
        """A camera of ``assets/render/cameras``, or of a table of the user's, set up before a face.

        Parameters
        ----------
        name : str or Path
            One of `known_cameras`, or a ``.toml`` file with the same fields.
        face : Face
        aspect : float
            Width / height of the picture.

        Raises
        ------
        InputError
            If there is no such camera, or its table cannot be used.
        """
        table = camera_table(name)
        extent = head_extent(face)
        (across, up), crown = table["centre"], extent.crown
        field, middle = crown * max(table["height"][0], table["width"][0] / aspect), up * crown
        missing = extent.top + _OVER_HAIR * crown - (middle + field / 2)
        if (
            extent.top > crown <= middle + field / 2 and missing > 0
        ):  # a camera that shows the whole head shows its hair, too
            field, middle = field + missing, middle + missing / 2
        target = (
            extent.middle + across * crown,
            extent.eyes + middle,
            extent.back + table["depth"][0] * (extent.front - extent.back),
        )
        return cls(target, table["distance"][0] * crown, field, table["yaw"][0], table["pitch"][0])

    @classmethod
    def portrait(cls, face: Face, aspect: float = 16 / 9) -> Camera:
        """Head and shoulders, centred, for a picture of ``aspect`` = width / height."""
        return cls.named("portrait", face, aspect)

    @classmethod
    def head_shot(cls, face: Face, aspect: float = 1.0) -> Camera:
        """The head alone, as large as it goes with room to turn."""
        return cls.named("head", face, aspect)

    @classmethod
    def close_up(cls, face: Face, aspect: float = 16 / 9) -> Camera:
        """The mouth and what moves with it, from just below the eyes to the chin."""
        return cls.named("mouth", face, aspect)

    def turned(self, yaw: float, pitch: float = 0.0) -> Camera:
        """The same camera gone round its target by further degrees."""
        return replace(self, yaw=self.yaw + yaw, pitch=self.pitch + pitch)

    def scaled(self, scale: float) -> Camera:
        """The same view of a face that is so many times as large."""
        if scale == 1:
            return self
        x, y, z = self.target
        target = scale * x, scale * y, scale * z
        return replace(self, target=target, distance=scale * self.distance, field_mm=scale * self.field_mm)

    def axes(self) -> NDArray[np.float64]:
        """Rows: the picture's right, its up, and the way from the target to the camera; shape (3, 3)."""
        yaw, pitch = np.deg2rad(self.yaw), np.deg2rad(self.pitch)
        back = np.array([np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)])
        right = np.array([np.cos(yaw), 0.0, -np.sin(yaw)])
        return np.stack([right, np.cross(back, right), back])

    def place(self) -> NDArray[np.float64]:
        """Where the camera stands, mm, shape (3,)."""
        return np.asarray(np.asarray(self.target) + self.distance * self.axes()[2], dtype=np.float64)

    def focal_pixels(self, height: int) -> float:
        """Pixels per (mm across / mm away) for a picture of ``height`` pixels."""
        return height * self.distance / self.field_mm


@dataclass(frozen=True)
class HeadExtent:
    """Where a head lies and how large it is, mm.

    Attributes
    ----------
    crown : float
        Height of its top over the eyes; of a face without eyes, about half of its size.
    middle, eyes : float
        Its middle across, and the height of its eyes (or of its middle).
    back, front : float
        Of what turns with the head.
    top : float
        Height of its hair over the eyes, where that stands up; else ``crown``.
    """

    crown: float
    middle: float
    eyes: float
    back: float
    front: float
    top: float


def head_extent(face: Face) -> HeadExtent:
    """Measure what turns with the head; all of the face where nothing does.

    Raises
    ------
    InputError
        If the face is a point or empty.
    """
    moved = [part.vertices[part.head_weight > 0.5] for part in face.parts]
    pieces = [piece for piece in moved if len(piece)] or [part.vertices for part in face.parts if len(part.vertices)]
    points = np.concatenate([*pieces, np.zeros((0, 3), np.float32)])
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points) or not np.ptp(points, axis=0).any():
        raise InputError(f"face {face.name!r} has nothing to frame: no two vertices lie apart")
    (left, low, back), (right, high, front) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    if face.eyes and high > 0:
        skin = max((float(part.vertices[:, 1].max()) for part in face.parts if part.name == "skin"), default=0.0)
        crown = min(high, _HAIR * skin) if skin > 0 else high  # hair that stands up does not make a face smaller
        return HeadExtent(crown, (left + right) / 2, 0.0, back, front, high)
    sides = np.array([right - left, high - low, front - back])
    half = float(sides.max() + np.linalg.norm(sides)) / 4  # between half a side and half the diagonal: it may be turned
    return HeadExtent(half, (left + right) / 2, (low + high) / 2, back, front, half)


def known_cameras() -> tuple[str, ...]:
    """Names of the cameras that come with mien, the usual one first.

    Examples
    --------
    >>> known_cameras()
    ('portrait', 'below', 'eyes', 'head', 'mouth', 'oval', 'side', 'three-quarter')
    """
    return known_tables("cameras")


def camera_table(name: str | Path) -> dict[str, list[float]]:
    """The fields of a camera as lists of numbers, checked.

    Raises
    ------
    InputError
        If there is no such camera, or a field is missing, not known, or out of range.
    """
    table = fields_of(table_of("cameras", name), _FIELDS, name)
    read = {field: numbers(table[field], 2 if field == "centre" else 1, field, name) for field in _FIELDS}
    for field in ("height", "width", "distance"):
        if not 0.01 <= read[field][0] <= 1000:
            raise InputError(f"{name}: {field} lies between 0.01 and 1000 crowns, not {read[field][0]:g}")
    if not -90 < read["pitch"][0] < 90:
        raise InputError(f"{name}: pitch lies between -90 and 90 degrees, not {read['pitch'][0]:g}")
    return read
