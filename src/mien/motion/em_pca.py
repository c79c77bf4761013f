"""Principal components by expectation maximisation (Roweis 1997), as Deng et al. 2006 reduce their mouth markers (A4).

Never forms the covariance matrix: each step costs frames x dimensions x components, and so does the memory.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["EMPCA"]

Floats = NDArray[np.float64]


class EMPCA:
    """Principal component analysis by expectation maximisation.

    Parameters
    ----------
    components : int
        Dimensions to keep.
    tolerance : float
        Stop when a step adds less than this share of the total variance.
    most_steps : int
        Never take more steps.

    Attributes
    ----------
    mean_ : ndarray, shape (dimensions,)
    weights_ : ndarray, shape (dimensions,)
        How much each dimension counts; the axes are those of the weighted data.
    axes_ : ndarray, shape (components, dimensions)
        Orthonormal, the direction of most variance first; the largest entry of each is positive.
    variances_ : ndarray, shape (components,)
    share_ : float
        Share of the total (weighted) variance that the components hold.
    steps_ : int

    Notes
    -----
    Sweeping E (``X = (C'C)^-1 C'Y``) and M (``C = YX'(XX')^-1``) turns the columns of C into a basis of the
    principal subspace (Roweis 1997, section 3). The axes inside it are found at the end from the small covariance of X.

    Examples
    --------
    >>> line = np.outer(np.linspace(-1, 1, 9), [3.0, 4.0]) + 5.0
    >>> model = EMPCA(1).fit(line)
    >>> model.axes_.round(6).tolist(), round(model.share_, 6)
    ([[0.6, 0.8]], 1.0)
    """

    def __init__(self, components: int, tolerance: float = 1e-7, most_steps: int = 300) -> None:
        self.components, self.tolerance, self.most_steps = components, tolerance, most_steps

    def fit(self, data: Floats, weights: Floats | None = None) -> Self:
        """Learn mean and axes from rows, shape (frames, dimensions).

        Parameters
        ----------
        data : ndarray
        weights : ndarray, shape (dimensions,), or None
            Above 0; None counts all dimensions alike.

        Raises
        ------
        InputError
            If there are fewer frames or dimensions than components.
        """
        frames, dimensions = data.shape
        if self.components > min(frames, dimensions):
            raise InputError(
                f"{self.components} components cannot be learned from {frames} frames of {dimensions} dimensions"
            )
        self.mean_ = data.mean(axis=0)
        self.weights_ = np.ones(dimensions) if weights is None else np.asarray(weights, dtype=np.float64)
        centred = (data - self.mean_) * self.weights_
        total = float((centred**2).sum())
        span = np.linalg.qr(np.random.default_rng(0).standard_normal((dimensions, self.components)))[0]
        held = 0.0
        for step in range(1, self.most_steps + 1):
            self.steps_ = step
            scores = centred @ span  # E: span is orthonormal, so (C'C)^-1 C'Y is C'Y
            now = float((scores**2).sum())
            if now - held <= self.tolerance * total and step > 1:
                break
            held = now
            span = np.linalg.qr(centred.T @ scores)[0]  # M: YX'(XX')^-1 spans what YX' spans
        self._settle(centred, span, total)
        return self

    def _settle(self, centred: Floats, span: Floats, total: float) -> None:
        scores = centred @ span
        powers, turn = np.linalg.eigh(scores.T @ scores)
        axes = (span @ turn[:, ::-1]).T
        largest = np.abs(axes).argmax(axis=1)
        self.axes_ = axes * np.sign(axes[np.arange(len(axes)), largest])[:, None]
        self.variances_ = powers[::-1] / len(centred)
        self.share_ = float(powers.sum() / total) if total > 0 else 1.0

    def encode(self, data: Floats) -> Floats:
        """Components of rows, shape (frames, components)."""
        return np.asarray(((data - self.mean_) * self.weights_) @ self.axes_.T)

    def decode(self, scores: Floats) -> Floats:
        """Rows of components, shape (frames, dimensions)."""
        rows = np.asarray(scores @ self.axes_)
        rows /= self.weights_
        rows += self.mean_
        return rows
