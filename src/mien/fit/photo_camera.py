"""The camera behind a photograph: a pinhole whose middle is the picture's, found from points of a known head."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

__all__ = ["PhotoCamera", "find_camera", "refined_camera"]

Floats = NDArray[np.float64]

FOCAL_SHARE = 1.9  # of the larger side: the usual portrait's field; 68 mm on 36 mm film
_FOCAL_SPREAD = 0.45  # of its logarithm
_BEHIND_DEGREES = 115.0  # a camera farther round would look at the face through the head
_YAWS = (0.0, 45.0, -45.0, 90.0, -90.0)


@dataclass(frozen=True, eq=False)
class PhotoCamera:
    """A pinhole camera.

    Attributes
    ----------
    width, height : int
        Of the picture, pixels.
    turn : ndarray, shape (3,)
        Rotation vector from the face's axes to the camera's (x right, y down, z away).
    shift : ndarray, shape (3,)
        Where the face's origin is in the camera's axes, mm.
    focal : float
        Pixels.
    """

    width: int
    height: int
    turn: Floats
    shift: Floats
    focal: float

    def matrix(self) -> Floats:
        """Rotation from the face's axes to the camera's, shape (3, 3)."""
        return np.asarray(Rotation.from_rotvec(self.turn).as_matrix())

    def seen(self, points: Floats) -> tuple[Floats, Floats]:
        """Pixels (n, 2), from the upper left corner, and distances along the view (n,), mm, of points (n, 3)."""
        inside = points @ self.matrix().T + self.shift
        away = np.maximum(inside[:, 2], 1.0)
        middle = np.array([self.width, self.height]) / 2
        return self.focal * inside[:, :2] / away[:, None] + middle, np.asarray(inside[:, 2])

    def slopes(self, points: Floats) -> Floats:
        """How pixels move as points do, shape (n, 2, 3), pixels per mm."""
        seen, away = self.seen(points)
        turn = self.matrix()
        offset = (seen - np.array([self.width, self.height]) / 2)[:, :, None]
        return np.asarray((self.focal * turn[None, :2] - offset * turn[None, 2:]) / away[:, None, None])

    def place(self) -> Floats:
        """Where the camera stands in the face's axes, mm."""
        return np.asarray(-self.matrix().T @ self.shift)

    def yaw(self) -> float:
        """Degrees from straight ahead by which the camera stands to the person's left."""
        x, _, z = self.place()
        return float(np.degrees(np.arctan2(x, z)))

    def numbers(self) -> Floats:
        """What is sought, in comparable units: rotation, shift in 100 mm, logarithm of the focal length."""
        return np.concatenate([self.turn, self.shift / 100, [np.log(self.focal)]])

    def of(self, numbers: Floats) -> PhotoCamera:
        """The same picture's camera with other numbers."""
        return replace(self, turn=numbers[:3], shift=np.asarray(numbers[3:6] * 100), focal=float(np.exp(numbers[6])))

    def gaps(self, numbers: Floats, points: Floats, wanted: Floats, sigma: float) -> Floats:
        """What is minimised: how far off points land, over sigma, and how odd the focal length is."""
        camera = self.of(numbers)
        seen, _ = camera.seen(points)
        return np.append(((seen - wanted) / sigma).ravel(), self.focal_gap(numbers))

    def focal_gap(self, numbers: Floats) -> float:
        """How odd the focal length is, in standard deviations of its logarithm about a portrait lens's."""
        return float((numbers[6] - np.log(FOCAL_SHARE * max(self.width, self.height))) / _FOCAL_SPREAD)


def _start(width: int, height: int, yaw: float, points: Floats, wanted: Floats) -> PhotoCamera:
    """Upright, seen from a side, as large as in the picture."""
    focal = FOCAL_SHARE * max(width, height)
    upside = Rotation.from_euler("x", 180, degrees=True) * Rotation.from_euler("y", -yaw, degrees=True)
    turned = points @ upside.as_matrix().T
    size = np.sqrt(
        ((wanted - wanted.mean(0)) ** 2).sum() / max(((turned[:, :2] - turned[:, :2].mean(0)) ** 2).sum(), 1)
    )
    away = focal / max(size, 1e-6)
    offset = (wanted.mean(0) - np.array([width, height]) / 2) / max(size, 1e-6) - turned[:, :2].mean(0)
    return PhotoCamera(
        width, height, upside.as_rotvec(), np.array([offset[0], offset[1], away - turned[:, 2].mean()]), focal
    )


def find_camera(width: int, height: int, points: Floats, wanted: Floats, sigma: float) -> tuple[PhotoCamera, float]:
    """The camera that sees points (n, 3), mm, at pixels (n, 2), and the RMS distance left in pixels.

    Tried from straight ahead, half sides and sides; ``sigma`` is what landmarks may be off, pixels.
    """
    best: tuple[PhotoCamera, float] | None = None
    for yaw in _YAWS:
        camera = refined_camera(_start(width, height, yaw, points, wanted), points, wanted, sigma)
        seen, away = camera.seen(points)
        left = float(np.sqrt(((seen - wanted) ** 2).sum(1).mean()))
        if away.min() < 50.0 or abs(camera.yaw()) > _BEHIND_DEGREES:
            left = np.inf
        if best is None or left < best[1]:
            best = camera, left
    assert best is not None
    return best


def refined_camera(start: PhotoCamera, points: Floats, wanted: Floats, sigma: float) -> PhotoCamera:
    """The best camera near another one."""
    found = least_squares(
        start.gaps, start.numbers(), args=(points, wanted, sigma), loss="soft_l1", f_scale=3.0, max_nfev=60
    )
    return start.of(found.x)
