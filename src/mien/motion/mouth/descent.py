"""Adam (Kingma, Ba 2015) with steps that shrink to nothing on a half cosine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Adam", "going_on"]

_MEMORY, _POWER_MEMORY, _FLOOR = 0.9, 0.99, 1e-8

HELD, LEAST_STEPS, CAREFUL = 100.0, 20, 0.3
"""Learning on: frames that a start counts as; steps that are made at least; share of the usual rate."""

Array = NDArray[np.floating[Any]]


def going_on(frames: int, batch: int, epochs: int, rate: float) -> tuple[int, float, float]:
    """How to learn on from what was learned of others: passes in each epoch, size of the steps, pull to the start.

    Examples
    --------
    >>> going_on(512, 256, 8, 0.02)[0]  # few frames are gone through more often
    2
    """
    steps = epochs * -(-frames // batch)
    return max(1, -(-LEAST_STEPS // steps)), CAREFUL * rate, HELD / frames


class Adam:
    """Moves parameters in place against their slopes.

    Parameters
    ----------
    parameters : sequence of ndarray
        Changed in place.
    rate : float
        Size of the first steps.
    steps : int
        How many steps will be made in all.

    Examples
    --------
    >>> place = np.array([3.0])
    >>> adam = Adam([place], rate=0.1, steps=200)
    >>> for _ in range(200):
    ...     adam.step([2 * place])
    >>> bool(abs(place[0]) < 0.01)
    True
    """

    def __init__(self, parameters: Sequence[Array], rate: float, steps: int) -> None:
        self.parameters, self.rate, self.steps, self.done = parameters, rate, steps, 0
        self.slopes = [np.zeros_like(parameter) for parameter in parameters]
        self.powers = [np.zeros_like(parameter) for parameter in parameters]

    def step(self, slopes: Sequence[Array]) -> None:
        """One step against the slopes, given in the order of the parameters."""
        self.done += 1
        rate = self.rate * 0.5 * (1 + np.cos(np.pi * min(self.done / self.steps, 1.0)))
        fresh, fresh_power = 1 - _MEMORY**self.done, 1 - _POWER_MEMORY**self.done
        for parameter, slope, mean, power in zip(self.parameters, slopes, self.slopes, self.powers, strict=True):
            mean += (1 - _MEMORY) * (slope - mean)
            power += (1 - _POWER_MEMORY) * (slope * slope - power)
            change = rate * (mean / fresh) / (np.sqrt(power / fresh_power) + _FLOOR)
            parameter -= change.astype(parameter.dtype)
