"""Warping recorded time onto said time by what is heard (dynamic time warping; Cao et al. 2005, section 4.3).

`warped_rows` finds for each frame of the said phone where it lies in the recorded phone, so that the sum of
distances of their audio features is least (Sakoe, Chiba 1978, symmetric: a step on in both counts twice). `time_map`
turns that into knots of a function from said to recorded seconds that begins and ends where the phones do.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["time_map", "warped_rows"]

Floats = NDArray[np.float64]


def warped_rows(said: NDArray[Any], recorded: NDArray[Any]) -> Floats:
    """Row of ``recorded`` that lies under each row of ``said``: the mean of those on the best path.

    Parameters
    ----------
    said, recorded : ndarray, shape (frames, coefficients)
        One frame or more each.

    Returns
    -------
    ndarray, shape (frames of said,)
        Never falls; from 0 or more to the last row or less.

    Examples
    --------
    >>> warped_rows(np.array([[0.0], [5.0], [5.0]]), np.array([[0.0], [0.0], [5.0]])).tolist()
    [0.5, 2.0, 2.0]
    """
    distances = np.sqrt(((said[:, None].astype(np.float64) - recorded[None].astype(np.float64)) ** 2).sum(axis=2))
    return np.asarray(_rows(distances))


@njit(cache=True, nogil=True)
def _rows(distances: Floats) -> Floats:
    rows, columns = distances.shape
    total = np.full((rows + 1, columns + 1), np.inf)
    total[0, 0] = 0.0
    for i in range(rows):
        for j in range(columns):
            step = distances[i, j]
            total[i + 1, j + 1] = min(total[i, j] + 2 * step, min(total[i, j + 1], total[i + 1, j]) + step)
    places, counts = np.zeros(rows), np.zeros(rows)
    i, j = rows, columns
    while i > 0 and j > 0:
        places[i - 1] += j - 1
        counts[i - 1] += 1
        both, one, other = total[i - 1, j - 1] + distances[i - 1, j - 1], total[i - 1, j], total[i, j - 1]
        if both <= one and both <= other:
            i, j = i - 1, j - 1
        elif one <= other:
            i -= 1
        else:
            j -= 1
    return places / counts


def time_map(
    said: NDArray[Any] | None,
    recorded: NDArray[Any],
    said_span: tuple[float, float],
    recorded_span: tuple[float, float],
    evenness: float,
) -> tuple[Floats, Floats]:
    """Knots of the function from said to recorded time inside one phone.

    Parameters
    ----------
    said : ndarray, shape (frames, coefficients), or None
        Audio features of the phone as said; None (no sound was given) warps evenly.
    recorded : ndarray, shape (frames, coefficients)
    said_span, recorded_span : (float, float)
        Start and end of the phone, seconds.
    evenness : float
        Share of the even warp against that of dynamic time warping, 0..1; the paper's is 0.

    Returns
    -------
    said, recorded : ndarray, shape (knots,)
        Seconds; both never fall, the first strictly rises unless the phone has no length.

    Examples
    --------
    >>> at, under = time_map(None, np.zeros((4, 9)), (1.0, 1.2), (0.0, 0.1), 0.0)
    >>> round(float(np.interp(1.1, at, under)), 6)
    0.05
    """
    (start, end), (first, last) = said_span, recorded_span
    ends = np.array([start, end]), np.array([first, last])
    if said is None or len(said) < 2 or len(recorded) < 2 or evenness >= 1 or end <= start:
        return ends
    middles = (np.arange(len(said)) + 0.5) / len(said)
    heard = (warped_rows(said, recorded) + 0.5) / len(recorded)
    share = np.concatenate([[0.0], evenness * middles + (1 - evenness) * heard, [1.0]])
    at = np.concatenate([[0.0], middles, [1.0]])
    return start + at * (end - start), first + share * (last - first)
