"""Where the picture is taken from.

A pinhole camera in the face's own axes (`mien.face.model`): it looks along -z unless turned. ``field_mm`` is the height
of the picture in the plane of the target, so that moving the camera away changes the perspective and not the framing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.model import Face

__all__ = ["Camera", "head_extent"]

# The eyes lie about half-way up a head; so the crown's height over the eyes, times these, frames head and shoulders.
_FIELD, _CENTRE, _WIDTH = 2.75, -0.2, 2.0
_HEAD_FIELD, _HEAD_CENTRE, _HEAD_WIDTH = 2.25, -0.03, 2.0
_HAIR = 1.12  # crown of the head with hair, of the crown of the skin
_DISTANCE_MM = 1100.0  # a portrait lens's distance


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
    def portrait(cls, face: Face, aspect: float = 16 / 9) -> Camera:
        """Head and shoulders, centred, for a picture of ``aspect`` = width / height."""
        crown, middle, front = head_extent(face)
        field = _FIELD * crown
        return cls((middle, _CENTRE * crown, front / 2), _DISTANCE_MM, max(field, _WIDTH * crown / aspect))

    @classmethod
    def head_shot(cls, face: Face, aspect: float = 1.0) -> Camera:
        """The head alone, as large as it goes with room to turn."""
        crown, middle, front = head_extent(face)
        field = max(_HEAD_FIELD * crown, _HEAD_WIDTH * crown / aspect)
        return cls((middle, _HEAD_CENTRE * crown, front / 2), _DISTANCE_MM, field)

    @classmethod
    def close_up(cls, face: Face, aspect: float = 16 / 9) -> Camera:
        """The mouth and what moves with it, from just below the eyes to the chin."""
        crown, middle, front = head_extent(face)
        return cls((middle, -0.58 * crown, front), _DISTANCE_MM / 2, max(0.9 * crown, 0.9 * crown / aspect))

    @classmethod
    def eyes(cls, face: Face, aspect: float = 16 / 9) -> Camera:
        """The eyes and brows."""
        crown, middle, front = head_extent(face)
        return cls((middle, 0.06 * crown, front), _DISTANCE_MM / 2, max(0.55 * crown, 1.2 * crown / aspect))

    def turned(self, yaw: float, pitch: float = 0.0) -> Camera:
        """The same camera gone round its target by further degrees."""
        return replace(self, yaw=self.yaw + yaw, pitch=self.pitch + pitch)

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


def head_extent(face: Face) -> tuple[float, float, float]:
    """Height of the crown over the eyes, middle across, and front, of what turns with the head; mm."""
    moved = [part.vertices[part.head_weight > 0.5] for part in face.parts]
    points = np.concatenate([piece for piece in moved if len(piece)] or [np.zeros((1, 3), np.float32)])
    low, high = points.min(axis=0), points.max(axis=0)
    crown = float(high[1]) if high[1] > 0 else float(high[1] - low[1]) / 2
    skin = [part.vertices for part in face.parts if part.name == "skin"]
    if skin and skin[0][:, 1].max() > 0:  # hair that stands up does not make a face smaller
        crown = min(crown, _HAIR * float(skin[0][:, 1].max()))
    if not crown > 0:
        raise InputError(f"face {face.name!r} has no head to frame: no vertex with head_weight above 0.5 and a height")
    return crown, float(low[0] + high[0]) / 2, float(high[2])
