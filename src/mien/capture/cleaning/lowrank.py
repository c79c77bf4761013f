"""A low-rank picture of how the markers of a face move together, learned from frames with holes in them.

Probabilistic PCA (Tipping & Bishop 1999): the pose of a frame is a mean plus a few components, each with its own
spread, plus noise. Given the markers that are seen, the components of a frame follow by ridge regression, and with
them the markers that are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["LowRank"]

_ROUNDS = 20
_SMALLEST_NOISE = 1e-3  # mm: keeps the regression solvable on motion without any noise


@dataclass(frozen=True, eq=False)
class LowRank:
    """Mean and components of poses; poses are flat, shape (coordinates,).

    Attributes
    ----------
    mean : ndarray, shape (coordinates,)
    components : ndarray, shape (k, coordinates)
        Each scaled by its spread, mm, so that a frame's weights have unit variance.
    noise : float
        Standard deviation of what the components leave, per coordinate, mm.
    """

    mean: NDArray[np.float64]
    components: NDArray[np.float64]
    noise: float

    @classmethod
    def fit(cls, poses: NDArray[np.float64], rank: int) -> LowRank:
        """Learn from poses (frames, coordinates) with NaN in the holes.

        Frames without holes are enough if there are twice as many as components; else the holes are filled, first
        along time and then in turn with the fitting. The rank is lowered to what frames and coordinates can carry.
        """
        holes = np.isnan(poses)
        rank = max(1, min(rank, (len(poses) - 1) // 2, poses.shape[1] - 1))
        whole = poses[~holes.any(axis=1)]
        if len(whole) >= 2 * rank + 1:
            return cls._of_complete(whole, rank)
        full = _along_time(poses)
        model = cls._of_complete(full, rank)
        for _ in range(_ROUNDS):
            guess = np.stack([model.rebuild(row) for row in poses])
            change = float(np.abs(guess - full)[holes].max())
            full = np.where(holes, guess, poses)
            model = cls._of_complete(full, rank)
            if change < 1e-4:
                break
        return model

    @classmethod
    def _of_complete(cls, poses: NDArray[np.float64], rank: int) -> LowRank:
        mean = poses.mean(axis=0)
        _, sizes, axes = np.linalg.svd(poses - mean, full_matrices=False)
        rest = float((sizes[rank:] ** 2).sum()) / max(1, len(poses) * (poses.shape[1] - rank))
        noise = max(float(np.sqrt(rest)), _SMALLEST_NOISE)
        spread = sizes[:rank] / np.sqrt(max(1, len(poses) - 1))
        return cls(mean, spread[:, None] * axes[:rank], noise)

    def rebuild(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """The pose that the components give for what is seen of ``pose``: all coordinates, none NaN."""
        seen = np.isfinite(pose)
        basis = self.components[:, seen]
        ridge = basis @ basis.T + self.noise**2 * np.eye(len(basis))
        weights = np.linalg.solve(ridge, basis @ (pose - self.mean)[seen])
        return np.asarray(self.mean + weights @ self.components, dtype=np.float64)


def _along_time(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holes filled on a straight line between the frames around them; 0 in a column that is empty."""
    full = poses.copy()
    frames = np.arange(len(poses))
    for column in np.flatnonzero(np.isnan(poses).any(axis=0)):
        seen = np.isfinite(poses[:, column])
        full[:, column] = np.interp(frames, frames[seen], poses[seen, column]) if seen.any() else 0.0
    return full
