"""Dominance functions (Cohen, Massaro 1993), fitted to recordings: a baseline.

Every phone pulls the mouth towards its target with a strength that falls off from its middle; the mouth is the mean of
the targets weighted by the strengths:

    D_k(t) = a_k exp(-θ_k |t - c_k|)      θ_k one before the middle c_k and one after it
    F(t)   = Σ_k D_k(t) T_k / Σ_k D_k(t)

Source: Cohen, Massaro 1993, "Modeling coarticulation in synthetic visual speech", equations 1 to 4, with the exponent
c of |t| at 1. The original was tuned by hand; here targets, strengths and fall-offs of all phones are found together
by least squares (variable projection: for given strengths the targets are a linear problem).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.metrics.context import speech_frames

__all__ = ["Dominance"]

NEIGHBOURS = 3
"""Phones to each side that pull on a frame."""
COMPONENTS = 8
"""Principal components in which the targets are fitted."""

Array = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Pulls:
    """Phones that pull on each frame: their numbers and the time since their middles, shapes (frames, pulls)."""

    phone: Whole
    since: Array


class Dominance:
    """Dominance functions of every phone, fitted by least squares.

    Parameters
    ----------
    iterations : int
        Most steps of the search for strengths and fall-offs.
    penalty : float
        Holds the targets to the mean (in frames) and the logarithms of the strengths to their start.

    Attributes
    ----------
    targets_ : ndarray, shape (phones, markers * 3)
    strength_ : ndarray, shape (phones,)
    falloff_ : ndarray, shape (2, phones)
        Before and after the middle, 1/s.
    """

    def __init__(self, iterations: int = 60, penalty: float = 1.0) -> None:
        self.iterations, self.penalty = iterations, penalty

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn targets, strengths and fall-offs."""
        from scipy.optimize import minimize

        self.symbols_ = tuple(sorted({PAUSE} | {phone.label for take in takes for phone in take.phones}))
        pairs = [(take, *speech_frames(take)) for take in takes]
        pulls = [self._pulls(take.phones, times) for take, times, _ in pairs if len(times)]
        if not pulls:
            raise InputError(f"none of the {len(takes)} takes to learn from has a frame with speech and all markers")
        flat = np.concatenate([positions for _, _, positions in pairs])
        self.mean_ = flat.mean(axis=0)
        basis = _principal(flat - self.mean_)
        pull = _Pulls(np.concatenate([p.phone for p in pulls]), np.concatenate([p.since for p in pulls]))
        scores = (flat - self.mean_) @ basis.T
        count = len(self.symbols_)
        start = np.concatenate([np.zeros(count), np.full(2 * count, np.log(15.0))])
        found = minimize(
            self._cost,
            start,
            args=(start, pull, scores),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": self.iterations},
        )
        weights = self._weights(found.x, pull)
        self.targets_ = self._targets(weights, pull, scores) @ basis + self.mean_
        self.strength_ = np.exp(found.x[:count])
        self.falloff_ = np.exp(found.x[count:]).reshape(2, count)
        return self

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """Positions at the given times, shape (frames, markers, 3), mm."""
        if not len(phones):
            return np.tile(self.mean_.reshape(-1, 3), (len(times), 1, 1))
        pull = self._pulls(phones, times)
        parameters = np.log(np.concatenate([self.strength_, self.falloff_.ravel()]))
        weights = self._weights(parameters, pull)
        flat: Array = np.einsum("nk,nkd->nd", weights, self.targets_[pull.phone])
        return flat.reshape(len(times), -1, 3)

    def _pulls(self, phones: Tier, times: Array) -> _Pulls:
        """The phone at each time and its neighbours; past the ends the first or last one again, far away."""
        number = {symbol: place for place, symbol in enumerate(self.symbols_)}
        labels = np.array([number.get(phone.label, number[PAUSE]) for phone in phones])
        starts = np.array([phone.start for phone in phones])
        middles = np.array([phone.middle for phone in phones])
        here = np.maximum(np.searchsorted(starts, times + 1e-9, side="right") - 1, 0)
        place = here[:, None] + np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
        there = np.clip(place, 0, len(phones) - 1)
        since = times[:, None] - middles[there]
        return _Pulls(labels[there], np.where(place == there, since, 1e3))

    def _weights(self, parameters: Array, pull: _Pulls) -> Array:
        """Share of each pull in each frame, shape (frames, pulls)."""
        count = len(self.symbols_)
        falloff = np.exp(parameters[count:])[pull.phone + count * (pull.since > 0)]
        logs = parameters[pull.phone] - falloff * np.abs(pull.since)
        strengths = np.exp(logs - logs.max(axis=1, keepdims=True))
        return np.asarray(strengths / strengths.sum(axis=1, keepdims=True))

    def _targets(self, weights: Array, pull: _Pulls, scores: Array) -> Array:
        """Best targets for given weights, shape (phones, components)."""
        from scipy.sparse import coo_array

        rows = np.repeat(np.arange(len(scores)), weights.shape[1])
        shape = (len(scores), len(self.symbols_))
        matrix = coo_array((weights.ravel(), (rows, pull.phone.ravel())), shape=shape).tocsr()
        gram = (matrix.T @ matrix).toarray() + self.penalty * np.eye(shape[1])
        return np.asarray(np.linalg.solve(gram, matrix.T @ scores))

    def _cost(self, parameters: Array, start: Array, pull: _Pulls, scores: Array) -> tuple[float, Array]:
        """Squared error with the best targets, and its slope; per frame."""
        count, frames = len(self.symbols_), len(scores)
        weights = self._weights(parameters, pull)
        targets = self._targets(weights, pull, scores)
        error = np.einsum("nk,nkd->nd", weights, targets[pull.phone]) - scores
        away = parameters - start
        cost = float((error**2).sum() + self.penalty * (targets**2).sum() + self.penalty * (away**2).sum()) / frames
        slope = 2 * np.einsum("nd,nkd->nk", error, targets[pull.phone])
        by_log = weights * (slope - (weights * slope).sum(axis=1, keepdims=True))
        side = pull.phone + count * (pull.since > 0)
        by_falloff = -by_log * np.exp(parameters[count:])[side] * np.abs(pull.since)
        gradient = np.concatenate([
            np.bincount(pull.phone.ravel(), by_log.ravel(), minlength=count),
            np.bincount(side.ravel(), by_falloff.ravel(), minlength=2 * count),
        ])  # fmt: skip
        return cost, (gradient + 2 * self.penalty * away) / frames


def _principal(centred: Array) -> Array:
    """Leading principal directions, shape (components, markers * 3)."""
    _, vectors = np.linalg.eigh(centred.T @ centred)
    return np.asarray(vectors[:, ::-1][:, :COMPONENTS].T)
