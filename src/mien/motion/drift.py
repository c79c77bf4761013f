"""Smooth random drift, the same at every frame rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["smooth_drift"]


def smooth_drift(
    times: NDArray[np.float64], correlation_time: float, random: np.random.Generator
) -> NDArray[np.float64]:
    """A stationary random curve with mean 0 and standard deviation 1.

    White noise on a grid of a quarter of the correlation time, smoothed by a Gaussian whose standard deviation is
    half of it. The draw depends on the last time and the generator, not on the frame rate: the same
    seed gives the same curve at 24 and at 60 frames per second.

    Parameters
    ----------
    times : ndarray, shape (frames,)
        Seconds, not negative.
    correlation_time : float
        Seconds; over this time the curve loses about two thirds of its memory.
    random : numpy.random.Generator

    Returns
    -------
    ndarray, shape (frames,)

    Examples
    --------
    >>> times = np.arange(0, 200, 0.04)
    >>> curve = smooth_drift(times, 0.5, np.random.default_rng(1))
    >>> bool(0.8 < curve.std() < 1.2)
    True
    """
    step = correlation_time / 4
    reach = 8  # grid steps: four standard deviations of the Gaussian
    knots = int(np.ceil(_last_second(times) / step)) + 2 * reach + 2
    noise = random.standard_normal(knots)
    position = times / step + reach
    offsets = np.arange(-reach, reach + 1)
    nearest = np.round(position).astype(int)
    index = nearest[:, None] + offsets[None, :]
    kernel = np.exp(-0.5 * ((index - position[:, None]) / 2.0) ** 2)
    kernel /= np.sqrt((kernel**2).sum(axis=1, keepdims=True))
    smooth: NDArray[np.float64] = (kernel * noise[np.clip(index, 0, knots - 1)]).sum(axis=1)
    return smooth


def _last_second(times: NDArray[np.float64]) -> float:
    """The end of the stretch in whole seconds, so that the number of draws does not depend on the frame rate."""
    return float(np.floor(times[-1]) + 1) if len(times) else 1.0
