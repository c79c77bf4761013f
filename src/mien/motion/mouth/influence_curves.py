"""Co-articulation curves: how the weight of each phone runs between their samples (Deng et al. 2006, Eq. 1 to 9).

For each frame F_j of an area the weights w solve F_j = w_s S_s + w_e S_e by least squares (Eq. 2), or
F_j = w_s S_s + w_m S_m + w_e S_e with no weight below zero (Eq. 6). A polynomial in normalised time is then fitted to
the (t, w) pairs of all instances of a diphone or triphone (Eq. 3 and 4).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.motion.mouth.phone_samples import Area

__all__ = ["PENALTIES", "Curves", "WeightPairs", "fit_curves", "fitting_cost", "pool", "weights_of"]

PENALTIES = (0.0, 1e-5, 5e-5, 1e-4)
"""The λ of Fig. 9."""

NNLS_STEPS = 100
"""SciPy's own limit, three times the number of columns, is met by some frames of real recordings."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WeightPairs:
    """Time-weight pairs of all instances of one diphone or triphone.

    Attributes
    ----------
    times : ndarray, shape (pairs,)
    weights : ndarray, shape (pairs, phones)
    """

    times: Floats
    weights: Floats


@dataclass(frozen=True, eq=False)
class Curves:
    """Weight of each phone over normalised time.

    Attributes
    ----------
    coefficients : ndarray, shape (degree + 1, phones)
        Of 1, t, t², t³...
    pairs : int
        How many pairs they were fitted to.
    error : float
        Sum of the squared differences over the pairs (Eq. 3 and 4).
    """

    coefficients: Floats
    pairs: int
    error: float

    def at(self, times: Floats) -> Floats:
        """Weights at normalised times, shape (times, phones); Horner's scheme."""
        value: Floats = np.zeros((len(times), self.coefficients.shape[1])) + self.coefficients[-1]
        for row in self.coefficients[-2::-1]:
            value = value * times[:, None] + row
        return value


def weights_of(area: Area, steadiness: float = 0.0) -> Floats:
    """Weights of the samples in each frame of an area, shape (frames, phones).

    Two phones: least squares (where the samples are parallel, the smallest weights). Three: non-negative.

    Parameters
    ----------
    area : Area
    steadiness : float
        0 is the paper's. Above it, weights are drawn towards those of cosine interpolation by this share of the mean
        square of the samples: where two samples are nearly alike their weights are otherwise wild.
    """
    columns, poses = area.samples.T, area.poses.T
    if steadiness > 0:
        size = np.sqrt(steadiness * (area.samples**2).mean() * len(columns))
        columns = np.concatenate([columns, size * np.eye(len(area.phones))])
        poses = np.concatenate([poses, size * _cosine_weights(area.times, len(area.phones)).T])
    if len(area.phones) == 2:
        return np.asarray(np.linalg.lstsq(columns, poses, rcond=None)[0].T)
    from scipy.optimize import nnls

    return np.array([nnls(columns, pose, maxiter=NNLS_STEPS)[0] for pose in poses.T])


def _cosine_weights(times: Floats, phones: int) -> Floats:
    """Weights of cosine interpolation through samples at equal steps, shape (times, phones)."""
    place = np.clip(times * (phones - 1), 0, phones - 1)
    distance = np.abs(place[:, None] - np.arange(phones))
    return np.asarray((1 + np.cos(np.pi * np.minimum(distance, 1))) / 2)


def pool(found: Iterable[tuple[tuple[str, ...], Floats, Floats]]) -> dict[tuple[str, ...], WeightPairs]:
    """Gather (phones, times, weights) of many instances by their phones, sorted."""
    times: dict[tuple[str, ...], list[Floats]] = {}
    weights: dict[tuple[str, ...], list[Floats]] = {}
    for phones, t, w in found:
        times.setdefault(phones, []).append(t)
        weights.setdefault(phones, []).append(w)
    return {key: WeightPairs(np.concatenate(times[key]), np.concatenate(weights[key])) for key in sorted(times)}


def fit_curves(pairs: WeightPairs, degree: int) -> Curves:
    """Fit a polynomial of a degree to the weights of each phone by least squares.

    Examples
    --------
    >>> t = np.linspace(0.1, 0.9, 9)
    >>> curves = fit_curves(WeightPairs(t, np.stack([1 - t**2, t**2], axis=1)), 2)
    >>> bool(np.allclose(curves.coefficients.T, [[1, 0, -1], [0, 0, 1]]))
    True
    """
    powers = np.vander(pairs.times, degree + 1, increasing=True)
    coefficients = np.linalg.lstsq(powers, pairs.weights, rcond=None)[0]
    error = float(((powers @ coefficients - pairs.weights) ** 2).sum())
    return Curves(np.asarray(coefficients, dtype=np.float64), len(pairs.times), error)


def fitting_cost(
    groups: Sequence[Mapping[tuple[str, ...], WeightPairs]],
    least_pairs: int,
    degrees: Sequence[int] = (1, 2, 3, 4, 5, 6),
    penalties: Sequence[float] = PENALTIES,
) -> Floats:
    """The cost against the degree (Eq. 7 to 9, Fig. 9), shape (penalties, degrees).

    Parameters
    ----------
    groups : sequence of mapping
        Diphones and triphones.
    least_pairs : int
        Sequences with fewer pairs are left out, at every degree the same ones.
    degrees, penalties : sequence

    Notes
    -----
    ``cost(λ) = Σ (error + λ |coefficients|²)`` over diphones and triphones.
    """
    fair = max(least_pairs, max(degrees) + 1)
    kept = [pairs for group in groups for pairs in group.values() if len(pairs.times) >= fair]
    cost = np.zeros((len(penalties), len(degrees)))
    for column, degree in enumerate(degrees):
        fits = [fit_curves(pairs, degree) for pairs in kept]
        error = sum(fit.error for fit in fits)
        size = sum(float((fit.coefficients**2).sum()) for fit in fits)
        cost[:, column] = error + np.asarray(penalties) * size
    return cost
