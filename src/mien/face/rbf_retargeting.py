"""From markers to weights by regression on radial basis functions, learned from pairs (Deng et al. 2006).

Displacements of markers are brought to few numbers ``x`` by principal components; each weight is::

    w(x) = sum_i a_i |x - x_i| + b . x + c                        kernel "linear" (biharmonic, with a plane)
    w(x) = sum_i a_i exp(-|x - x_i|^2 / (2 width^2))              kernel "gaussian" (as in the paper)

The coefficients solve one linear system each, with a ridge. Answers are held in [0, 1] and steadied over time.

Pairs are given, or made from a face's own marker sites (`sampled_pairs`): then nobody has to tune weights by hand.

References
----------
Deng, Neumann, Lewis, Kim, Bulut & Narayanan (2006), section VII; Buhmann (2003), Radial Basis Functions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve, solveh_banded
from scipy.spatial.distance import cdist

from mien.core.errors import InputError

__all__ = ["RbfRetargeter", "sampled_pairs", "steadied"]

Floats = NDArray[np.float64]
KERNELS = ("linear", "gaussian")


class RbfRetargeter:
    """Learns weights of morph targets from displacements of markers.

    Parameters
    ----------
    kernel : {"linear", "gaussian"}
        The first answers straight lines exactly and goes on beyond its examples; the second is the paper's.
    variance : float
        Share of the pairs' variance that the principal components keep, 0..1.
    ridge : float
        Added to the diagonal of the system, as a share of the mean distance (linear) or as it stands (gaussian).
    steadiness : float
        How much changes from frame to frame (at 30 frames per second) are held back; 0 takes each frame by itself.

    Attributes
    ----------
    mean_, axes_ : ndarray, shapes (numbers,) and (components, numbers)
        The principal components of flattened displacements, mm.
    centres_ : ndarray, shape (pairs, components)
    coefficients_ : ndarray, shape (pairs [+ components + 1], channels)
    width_ : float
        Of the Gaussian: the median distance between centres.

    Raises
    ------
    InputError
        If a setting is out of range.

    Examples
    --------
    >>> basis = np.eye(6).reshape(2, 3, 2, 3)[:, 0] * 5  # two channels that move two markers by 5 mm
    >>> shown, weights = sampled_pairs(basis, 40, np.random.default_rng(1))
    >>> learned = RbfRetargeter().fit(shown, weights)
    >>> learned.predict(0.5 * basis[:1]).round(2).tolist()
    [[0.5, 0.0]]
    """

    def __init__(
        self, kernel: str = "linear", variance: float = 0.99999, ridge: float = 1e-6, steadiness: float = 0.1
    ) -> None:
        if kernel not in KERNELS:
            raise InputError(f"a kernel is {' or '.join(KERNELS)}, not {kernel!r}")
        if not 0 < variance <= 1 or ridge < 0 or steadiness < 0:
            raise InputError("variance lies above 0 and up to 1; ridge and steadiness are 0 or more")
        self.kernel, self.variance, self.ridge, self.steadiness = kernel, variance, ridge, steadiness

    def fit(self, displacements: ArrayLike, weights: ArrayLike) -> RbfRetargeter:
        """Learn from pairs.

        Parameters
        ----------
        displacements : array_like, shape (pairs, markers, 3)
            Millimetres from rest.
        weights : array_like, shape (pairs, channels)
            0..1.

        Raises
        ------
        InputError
            If shapes do not fit, numbers are missing or out of range, or all pairs show the same.
        """
        shown, wanted = np.asarray(displacements, dtype=np.float64), np.asarray(weights, dtype=np.float64)
        if shown.ndim != 3 or shown.shape[2] != 3 or wanted.ndim != 2 or len(shown) != len(wanted) or len(shown) < 2:
            raise InputError(
                "pairs: expected (pairs, markers, 3) and (pairs, channels), two pairs or more, "
                f"got {shown.shape} and {wanted.shape}"
            )
        if not np.isfinite(shown).all() or not ((wanted >= 0) & (wanted <= 1)).all():
            raise InputError("pairs: displacements must be finite numbers, weights numbers from 0 to 1")
        flat = shown.reshape(len(shown), -1)
        self.mean_ = flat.mean(axis=0)
        _, strength, axes = np.linalg.svd(flat - self.mean_, full_matrices=False)
        share = np.cumsum(strength**2) / max(float((strength**2).sum()), 1e-300)
        if not strength[0] > 0:
            raise InputError("pairs: all of them show the same displacements; nothing can be learned")
        kept = min(int(np.searchsorted(share, self.variance - 1e-15)) + 1, int((strength > 1e-9 * strength[0]).sum()))
        self.axes_ = axes[:kept]
        self.centres_ = (flat - self.mean_) @ self.axes_.T
        apart = cdist(self.centres_, self.centres_)
        self.width_ = float(np.median(apart[apart > 0])) if (apart > 0).any() else 1.0
        self._markers = shown.shape[1]
        self.coefficients_ = self._solved(apart, wanted)
        return self

    def _solved(self, apart: Floats, wanted: Floats) -> Floats:
        if self.kernel == "gaussian":
            design = np.exp(-(apart**2) / (2 * self.width_**2))
            gram = design.T @ design + self.ridge * np.eye(len(design))
            return np.asarray(solve(gram, design.T @ wanted, assume_a="sym"))
        plane = np.hstack([self.centres_, np.ones((len(self.centres_), 1))])
        ridge = self.ridge * float(apart.mean())
        system = np.block([[-apart + ridge * np.eye(len(apart)), plane], [plane.T, np.zeros((plane.shape[1],) * 2)]])
        goal = np.vstack([wanted, np.zeros((plane.shape[1], wanted.shape[1]))])
        # Few pairs may not span the plane; least squares then takes the smallest answer.
        return np.asarray(np.linalg.lstsq(system, goal, rcond=1e-13)[0])

    def predict(self, displacements: ArrayLike) -> Floats:
        """Weights of every frame by itself, shape (frames, channels), 0..1; displacements (frames, markers, 3), mm.

        Raises
        ------
        InputError
            If the shape does not fit, or a number is not finite.
        """
        asked = np.asarray(displacements, dtype=np.float64)
        if asked.ndim != 3 or asked.shape[1:] != (self._markers, 3):
            raise InputError(f"displacements: expected (frames, {self._markers} markers, 3), got {asked.shape}")
        if not np.isfinite(asked).all():
            frame, marker = np.argwhere(~np.isfinite(asked))[0][:2]
            raise InputError(f"displacements: frame {frame}, marker {marker} is not a finite number; fill gaps first")
        numbers = (asked.reshape(len(asked), -1) - self.mean_) @ self.axes_.T
        apart = cdist(numbers, self.centres_)
        if self.kernel == "gaussian":
            design = np.exp(-(apart**2) / (2 * self.width_**2))
        else:
            design = np.hstack([-apart, numbers, np.ones((len(numbers), 1))])
        return np.asarray(np.clip(design @ self.coefficients_, 0.0, 1.0))

    def solve(self, displacements: ArrayLike, fps: float = 30.0) -> Floats:
        """Weights of a whole motion, steadied over time; as `predict` otherwise."""
        return np.clip(steadied(self.predict(displacements), self.steadiness * (fps / 30.0) ** 2), 0.0, 1.0)


def steadied(values: Floats, steadiness: float) -> Floats:
    """The motion nearest to ``values`` (frames, channels) that changes little: |v - values|^2 + steadiness |dv|^2.

    Examples
    --------
    >>> steadied(np.array([[0.0], [1.0], [0.0]]), 1.0).round(2).ravel().tolist()
    [0.25, 0.5, 0.25]
    """
    if len(values) < 2 or steadiness == 0:
        return values
    diagonal = np.full(len(values), 1.0 + 2.0 * steadiness)
    diagonal[[0, -1]] -= steadiness
    beside = np.full(len(values), -steadiness)
    return np.asarray(solveh_banded(np.vstack([beside, diagonal]), values))


def sampled_pairs(
    basis: Floats,
    count: int,
    random: np.random.Generator,
    most: int = 5,
    singles: Sequence[float] = (0.25, 0.5, 0.75, 1.0),
) -> tuple[Floats, Floats]:
    """Pairs of displacements and weights of a rig, by drawing weights.

    Parameters
    ----------
    basis : ndarray, shape (channels, markers, 3)
        What each channel does to the markers at weight 1 (`mien.face.retargeting.basis_at`).
    count : int
        How many mixtures to draw: one to ``most`` channels each, weights even in 0..1.
    random : Generator
    most : int
    singles : sequence of float
        Weights at which each channel is shown alone, besides; and rest once.

    Returns
    -------
    displacements : ndarray, shape (pairs, markers, 3)
    weights : ndarray, shape (pairs, channels)
    """
    channels = len(basis)
    alone = [weight * np.eye(channels) for weight in singles]
    mixed = np.zeros((count, channels))
    for row in mixed:
        chosen = random.choice(channels, size=min(channels, int(random.integers(1, most + 1))), replace=False)
        row[chosen] = random.uniform(0.0, 1.0, len(chosen))
    weights = np.vstack([np.zeros((1, channels)), *alone, mixed])
    return np.einsum("pc,cmk->pmk", weights, basis), weights
