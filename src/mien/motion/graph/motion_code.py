"""Motion in a few components: principal ones to keep and compare it, independent ones to smooth it (Cao et al. 2005).

Cao et al. 2005, sections 4.1 and 5.1: principal components that hold 95 % of the variance of all recorded motion, then
independent component analysis (FastICA, Hyvärinen 1999), which turns and scales them. The graph keeps the principal
ones: in them the distance of two poses is that of the markers, in mm. Each independent component is what one source
moves (Eq. 7, x = u A); they are had from the principal ones by a small matrix.
"""

from __future__ import annotations

import warnings
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["PAPER_SHARE", "MotionCode"]

PAPER_SHARE = 0.95
"""Share of the variance that the paper keeps ("95 %-98 %")."""
_MOST_FRAMES = 20_000  # FastICA sees no more frames than these, evenly spread; the turn needs no more
_STEPS, _TOLERANCE = 400, 1e-4

Floats = NDArray[np.float64]


class MotionCode:
    """Principal and independent components of motion.

    Parameters
    ----------
    share : float
        Share of the variance to keep, above 0 and up to 1.
    seed : int
        Of the start of FastICA.

    Attributes
    ----------
    mean_ : ndarray, shape (dimensions,)
    axes_ : ndarray, shape (components, dimensions)
        Orthonormal, the direction of most variance first; the largest entry of each is positive.
    mixing_ : ndarray, shape (components, components)
        Principal components of one standard deviation of each independent one (A); the one that moves most first.
    share_ : float
        Share of the variance that is kept.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> sources = random.uniform(-1, 1, (2000, 2)) * [3.0, 1.0]
    >>> turned = sources @ np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
    >>> code = MotionCode(1.0).fit(turned)
    >>> abs(code.mixing_ @ code.axes_).round(1).tolist()        # the two sources are found, 3 and 1 over root 3
    [[1.0, 1.4, 0.0], [0.5, 0.3, 0.0]]
    """

    def __init__(self, share: float = PAPER_SHARE, seed: int = 0) -> None:
        if not 0 < share <= 1:
            raise InputError(f"a share of variance lies above 0 and up to 1, not {share:g}")
        self.share, self.seed = share, seed

    def fit(self, data: Floats) -> Self:
        """Learn from rows, shape (frames, dimensions).

        Raises
        ------
        InputError
            If there are fewer than two frames or numbers that are not finite.
        """
        if len(data) < 2 or not np.isfinite(data).all():
            raise InputError(f"motion is coded from two or more frames of finite numbers, not from shape {data.shape}")
        mean = data.mean(axis=0)
        powers, axes = np.linalg.eigh((data - mean).T @ (data - mean) / len(data))
        powers, axes = np.maximum(powers[::-1], 0.0), axes[:, ::-1].T
        total = float(powers.sum())
        held = np.cumsum(powers) / total if total > 0 else np.ones(len(powers))
        alive = max(1, int((powers > 1e-12 * total).sum()))
        kept = min(int(np.searchsorted(held, self.share - 1e-12)) + 1, alive)
        axes = axes[:kept] * np.sign(axes[np.arange(kept), np.abs(axes[:kept]).argmax(axis=1)])[:, None]
        spread = np.sqrt(powers[:kept]) if total > 0 else np.ones(kept)
        turn = self._turn((data - mean) @ axes.T / spread)
        mixing = turn * spread
        order = np.argsort(-np.linalg.norm(mixing, axis=1), kind="stable")
        signs = np.sign(mixing[order, np.abs(mixing[order]).argmax(axis=1)])
        return self.restore(mean, axes, mixing[order] * signs[:, None], float(held[kept - 1]))

    def restore(self, mean: Floats, axes: Floats, mixing: Floats, share: float) -> Self:
        """Take what was learned before."""
        self.mean_, self.axes_, self.mixing_, self.share_ = mean, axes, mixing, share
        self._unmixing = np.linalg.inv(mixing)
        return self

    def _turn(self, whitened: Floats) -> Floats:
        """Orthogonal turn of whitened principal components that makes them independent."""
        from sklearn.decomposition import FastICA
        from sklearn.exceptions import ConvergenceWarning

        count = whitened.shape[1]
        rows = whitened[:: max(1, -(-len(whitened) // _MOST_FRAMES))]
        if count == 1 or len(rows) <= count:
            return np.eye(count)
        start = np.linalg.qr(np.random.default_rng(self.seed).standard_normal((count, count)))[0]
        model = FastICA(whiten=False, w_init=start, max_iter=_STEPS, tol=_TOLERANCE)
        with warnings.catch_warnings():
            # where motion is Gaussian or made of few poses it finds no rest; any turn codes the motion as well
            warnings.simplefilter("ignore", ConvergenceWarning)
            turn = model.fit(rows - rows.mean(axis=0)).components_
        left, _, right = np.linalg.svd(turn)  # a turn to rounding, even where it stopped early
        return np.asarray(left @ right)

    def encode(self, data: Floats) -> Floats:
        """Principal components of rows, mm, shape (frames, components)."""
        return np.asarray((data - self.mean_) @ self.axes_.T)

    def decode(self, components: Floats) -> Floats:
        """Rows of principal components, shape (frames, dimensions)."""
        return np.asarray(components @ self.axes_ + self.mean_)

    def separate(self, components: Floats) -> Floats:
        """Independent components (deviation 1) of principal ones."""
        return np.asarray(components @ self._unmixing)

    def mix(self, independent: Floats) -> Floats:
        """Principal components of independent ones."""
        return np.asarray(independent @ self.mixing_)
