"""The best warping path, compiled: `mien.motion.graph.audio_distance.warping_path` is its plain reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["warping_path"]


def warping_path(heard: NDArray[np.float64], recorded: NDArray[np.float64]) -> NDArray[np.int64]:
    """Pairs of frames that the best warping path brings together, shape (steps, 2), first to last.

    The symmetric form of Sakoe and Chiba (1978): a step on in one stretch counts the distance of the frames it reaches
    once, a step on in both twice.

    Parameters
    ----------
    heard, recorded : ndarray, shapes (frames, coefficients) and (other frames, coefficients)

    Examples
    --------
    >>> warping_path(np.array([[0.0], [0.0], [1.0]]), np.array([[0.0], [1.0]])).tolist()
    [[0, 0], [1, 0], [2, 1]]
    """
    squares = (heard**2).sum(axis=1)[:, None] + (recorded**2).sum(axis=1) - 2 * heard @ recorded.T
    return np.asarray(_path(np.sqrt(np.maximum(squares, 0.0))), dtype=np.int64)


@njit(cache=True)
def _path(distances):  # type: ignore[no-untyped-def]  # numba infers the types
    rows, columns = distances.shape
    sums = np.full((rows + 1, columns + 1), np.inf)
    steps = np.zeros((rows, columns), dtype=np.int8)
    sums[0, 0] = 0.0
    for i in range(rows):
        for j in range(columns):
            best, step = sums[i, j] + 2 * distances[i, j], 0
            if sums[i, j + 1] + distances[i, j] < best:
                best, step = sums[i, j + 1] + distances[i, j], 1
            if sums[i + 1, j] + distances[i, j] < best:
                best, step = sums[i + 1, j] + distances[i, j], 2
            sums[i + 1, j + 1], steps[i, j] = best, step
    path = np.empty((rows + columns, 2), dtype=np.int64)
    i, j, place = rows - 1, columns - 1, rows + columns
    while True:
        place -= 1
        path[place, 0], path[place, 1] = i, j
        if i == 0 and j == 0:
            break
        step = steps[i, j]
        if step != 2:
            i -= 1
        if step != 1:
            j -= 1
    return path[place:]
