"""Bounded least squares over all frames of a recording at once, by coordinate descent.

::

    minimise  sum_t  1/2 w_t' G w_t - (g_t - p_t)' w_t + 1/2 sum_j c_tj (q_j' w_t - r_tj)^2
                     + 1/2 sum_k s_tk (w_tk - w_(t-1)k)^2
    with      0 <= w_tk <= u_tk

``G`` and ``g`` come from the markers, ``p`` is a price on each weight (the sparse prior), ``q_j`` says how far each
channel opens the opening ``j`` (lips, lids), ``r`` how far it was open and ``c`` how much that counts in this frame.
The problem is convex; one weight after another is set to its best value, frame by frame, forwards and then backwards
(Tseng 2001, "Convergence of a block coordinate descent method"). One thread, so the same bits each time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.compiled import njit

__all__ = ["descend"]

Floats = NDArray[np.float64]


@njit(cache=True, error_model="numpy", nogil=True)
def descend(
    gram: Floats,
    goal: Floats,
    upper: Floats,
    steady: Floats,
    openings: Floats,
    open_goal: Floats,
    open_weight: Floats,
    weights: Floats,
    still: float,
    most: int,
) -> int:
    """Improve ``weights`` in place until none moves by more than ``still``, or ``most`` sweeps are done.

    Parameters
    ----------
    gram : ndarray, shape (channels, channels)
    goal : ndarray, shape (frames, channels)
        ``g - p``.
    upper : ndarray, shape (frames, channels)
        Largest weights.
    steady : ndarray, shape (frames, channels)
        Cost of a change from the frame before; the first row is not read.
    openings : ndarray, shape (openings, channels)
    open_goal, open_weight : ndarray, shape (frames, openings)
    weights : ndarray, shape (frames, channels)
        Where to start; within the bounds.
    still : float
    most : int

    Returns
    -------
    int
        Sweeps done.
    """
    frames, channels = goal.shape
    count = openings.shape[0]
    slopes = np.zeros((frames, channels))
    opened = np.zeros((frames, count))
    for frame in range(frames):
        for k in range(channels):
            value = weights[frame, k]
            if value != 0.0:
                for other in range(channels):
                    slopes[frame, other] += value * gram[k, other]
                for j in range(count):
                    opened[frame, j] += value * openings[j, k]
    for sweep in range(most):
        largest = 0.0
        for step in range(frames):
            frame = step if sweep % 2 == 0 else frames - 1 - step
            for k in range(channels):
                here = weights[frame, k]
                curve = gram[k, k]
                slope = slopes[frame, k] - goal[frame, k]
                for j in range(count):
                    c = open_weight[frame, j] * openings[j, k]
                    curve += c * openings[j, k]
                    slope += c * (opened[frame, j] - open_goal[frame, j])
                if frame > 0:
                    curve += steady[frame, k]
                    slope += steady[frame, k] * (here - weights[frame - 1, k])
                if frame + 1 < frames:
                    curve += steady[frame + 1, k]
                    slope += steady[frame + 1, k] * (here - weights[frame + 1, k])
                if curve <= 0.0:
                    continue
                value = min(max(here - slope / curve, 0.0), upper[frame, k])
                moved = value - here
                if moved != 0.0:
                    weights[frame, k] = value
                    for other in range(channels):
                        slopes[frame, other] += moved * gram[k, other]
                    for j in range(count):
                        opened[frame, j] += moved * openings[j, k]
                    largest = max(largest, abs(moved))
        if largest < still:
            return sweep + 1
    return most
