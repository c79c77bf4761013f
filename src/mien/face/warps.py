"""Maps of space from a few points: a similarity, and a smooth warp through or near landmarks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

__all__ = ["Similarity", "SmoothWarp", "similarity_between", "spread_points"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Similarity:
    """``x -> scale * turn @ x + shift``; the residual is the RMS distance left, in the target's unit."""

    scale: float
    turn: Floats  # (3, 3)
    shift: Floats  # (3,)
    residual: float = 0.0

    def __call__(self, points: Floats) -> Floats:
        """Map points (n, 3)."""
        return np.asarray(self.scale * points @ self.turn.T + self.shift)


def similarity_between(source: Floats, target: Floats, mirrored: bool = False, scaled: bool = True) -> Similarity:
    """The similarity that brings source points (n, 3) closest to target points (Umeyama 1991).

    ``mirrored`` asks for the best one that turns left into right, to tell swapped sides by.

    Examples
    --------
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> float(round(similarity_between(points, 2 * points + 1).scale, 6))
    2.0
    """
    a, b = source.mean(0), target.mean(0)
    u, sizes, vt = np.linalg.svd((target - b).T @ (source - a))
    sign = np.sign(np.linalg.det(u @ vt)) * (-1 if mirrored else 1)
    flip = np.array([1.0, 1.0, sign])
    spread = float(((source - a) ** 2).sum())
    scale = float((sizes * flip).sum() / spread) if scaled and spread > 0 else 1.0
    turn = np.asarray((u * flip) @ vt)
    shift = b - scale * turn @ a
    left = target - (scale * source @ turn.T + shift)
    return Similarity(scale, turn, np.asarray(shift), float(np.sqrt((left**2).sum(1).mean())))


def spread_points(points: Floats, count: int) -> NDArray[np.int64]:
    """Numbers of ``count`` points that lie far from each other (farthest first, from the one nearest the middle)."""
    count = min(count, len(points))
    chosen = [int(np.argmin(((points - points.mean(0)) ** 2).sum(1)))]
    away = ((points - points[chosen[0]]) ** 2).sum(1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, ((points - points[chosen[-1]]) ** 2).sum(1))
    return np.array(chosen)


class SmoothWarp:
    """A thin-plate warp in space (kernel ``r``, affine part; Bookstein 1989) near given displacements.

    Parameters
    ----------
    points, moved : ndarray, shape (m, 3)
        Where points are, and where they go, mm.
    smoothness : float
        0 goes through every point; larger values bend less. In the kernel's own unit, mm.
    affine_weight : float
        How freely space may stretch as a whole: the affine part is held to the identity by a spring of
        this strength, so that places far from all points do not fly away.
    """

    def __init__(self, points: Floats, moved: Floats, smoothness: float = 0.0, affine_weight: float = 1.0) -> None:
        self._points = np.asarray(points, dtype=np.float64)
        count = len(self._points)
        kernel = -cdist(self._points, self._points) - smoothness * np.eye(count)
        self._middle = self._points.mean(0)
        flat = np.hstack([np.ones((count, 1)), (self._points - self._middle) / 100.0])
        system = np.zeros((count + 4, count + 4))
        system[:count, :count] = kernel
        system[:count, count:], system[count:, :count] = flat, flat.T
        system[count + 1 :, count + 1 :] = affine_weight * 1e-3 * np.eye(3)
        right = np.vstack([moved - self._points, np.zeros((4, 3))])
        solution = np.linalg.lstsq(system, right, rcond=1e-12)[0]
        self._bend, self._flat = solution[:count], solution[count:]

    def __call__(self, points: Floats) -> Floats:
        """Map points (n, 3)."""
        points = np.asarray(points, dtype=np.float64)
        out = np.empty_like(points)
        for first in range(0, len(points), 8192):
            some = points[first : first + 8192]
            flat = np.hstack([np.ones((len(some), 1)), (some - self._middle) / 100.0])
            out[first : first + 8192] = some - cdist(some, self._points) @ self._bend + flat @ self._flat
        return out
