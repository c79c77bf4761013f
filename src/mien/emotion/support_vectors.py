"""A support vector machine with probabilities over several classes, as libsvm makes them, judged on groups held out.

libsvm (through scikit-learn) finds the support vectors of every pair of classes. Pair by pair a sigmoid turns the
decision value into a probability (Platt 1999), and the pairs are coupled (Wu, Lin, Weng 2004, second method). Unlike
libsvm's own, the sigmoids are fitted on groups (speakers) held out, since decision values on speakers known from
learning are too sure. Prediction is plain numpy; tests compare it with scikit-learn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError

__all__ = ["Kernel", "SupportVectors", "couple", "held_out_folds"]

Kernel = Literal["linear", "radial"]
_MOST_FOLDS = 10
_REACH = {"spread": 2.0, "range": 60.0}
"""How far from the middle a scaled feature counts: what is odder than two spreads is another room, or a fault."""
_Array = NDArray[np.float64]


class SupportVectors:
    """Classifier of feature vectors.

    Parameters
    ----------
    kernel : {"radial", "linear"}
        K(x, y) = exp(-γ |x - y|²), or x · y.
    cost : float
        libsvm's C.
    scaling : {"spread", "range"}
        Features brought to mean 0 and spread 1, or to the range -1 to 1 (the paper's).
    balanced : bool
        Classes count alike however many samples they have.

    Attributes
    ----------
    classes_ : tuple of str
    centre_, scale_ : ndarray, shape (features,)
    reach_ : float
        Scaled features are cut off there.
    vectors_ : ndarray, shape (vectors, features)
    weights_ : ndarray, shape (pairs, vectors)
    offsets_ : ndarray, shape (pairs,)
    sigmoids_ : ndarray, shape (pairs, 2)
        A and B of 1 / (1 + exp(A f + B)).
    gamma_ : float
    held_out_probabilities_ : ndarray, shape (samples, classes)
        What machines that did not know a sample's group say of it. Not stored.
    """

    def __init__(
        self,
        kernel: Kernel = "radial",
        cost: float = 1.0,
        scaling: Literal["spread", "range"] = "spread",
        balanced: bool = True,
    ) -> None:
        self.kernel, self.cost, self.scaling, self.balanced = kernel, cost, scaling, balanced

    def fit(self, features: _Array, labels: Sequence[str], groups: Sequence[str]) -> Self:
        """Learn; features of shape (samples, features), one label and one group (speaker) per sample.

        Raises
        ------
        InputError
            If there are fewer than two classes.
        """
        names, group_names = np.asarray(labels), np.asarray(groups)
        if len(set(labels)) < 2:
            raise InputError(f"expected at least two kinds to tell apart, got {sorted(set(labels))}")
        self.fit_vectors(features, names)
        decisions = np.full((len(names), len(self.offsets_)), np.nan)
        for known, held_out in held_out_folds(names, group_names):
            part = SupportVectors(self.kernel, self.cost, self.scaling, self.balanced)
            part.fit_vectors(features[known], names[known])
            if part.classes_ == self.classes_:
                decisions[held_out] = part.decisions(features[held_out])
        index = np.searchsorted(self.classes_, names)
        self.sigmoids_ = np.array(
            [_sigmoid(decisions[:, k], index == i, index == j) for k, (i, j) in enumerate(self._pairs())]
        )
        self.held_out_probabilities_ = self._coupled(np.nan_to_num(decisions))
        return self

    def fit_vectors(self, features: _Array, names: NDArray[np.str_]) -> Self:
        """Find the support vectors only: enough for `votes` and `decisions`, not for `probabilities`."""
        from sklearn.svm import SVC

        self.classes_ = tuple(str(name) for name in np.unique(names))
        self.centre_, self.scale_ = _scaling(features, self.scaling)
        self.reach_ = _REACH[self.scaling]
        scaled = self.scaled(features)
        spread = float(scaled.var())
        # scikit-learn's default width ("scale"); libsvm's own, one over the number of features, is close to it here.
        self.gamma_ = 1 / (scaled.shape[1] * spread) if spread > 0 else 1.0
        machine = SVC(
            C=self.cost,
            kernel="linear" if self.kernel == "linear" else "rbf",
            gamma=self.gamma_,
            class_weight="balanced" if self.balanced else None,
            decision_function_shape="ovo",
        ).fit(scaled, names)
        self.vectors_ = np.asarray(machine.support_vectors_, dtype=np.float64)
        self.weights_ = _pair_weights(machine.dual_coef_, machine.n_support_)
        # Of two classes scikit-learn turns the sign around; here a positive value speaks for the first of a pair.
        sign = -1.0 if len(self.classes_) == 2 else 1.0
        self.weights_, self.offsets_ = sign * self.weights_, sign * np.asarray(machine.intercept_, dtype=np.float64)
        if self.kernel == "linear":  # the vectors of a plane add up to one, its normal
            self.vectors_, self.weights_ = self.weights_ @ self.vectors_, np.eye(len(self.offsets_))
        return self

    def _pairs(self) -> list[tuple[int, int]]:
        return list(combinations(range(len(self.classes_)), 2))

    def scaled(self, features: _Array) -> _Array:
        """Features on one scale, as the machine sees them; shape (samples, features)."""
        # On a grid of half precision, in which vectors are stored: what is loaded is what was learned.
        scaled = np.clip((features - self.centre_) / self.scale_, -self.reach_, self.reach_)
        return np.asarray(scaled.astype(np.float16).astype(np.float64))

    def decisions(self, features: _Array) -> _Array:
        """Decision values, shape (samples, pairs): positive speaks for the first class of the pair."""
        scaled = self.scaled(np.atleast_2d(features))
        products = scaled @ self.vectors_.T
        if self.kernel == "radial":
            squares = (scaled**2).sum(axis=1)[:, None] + (self.vectors_**2).sum(axis=1) - 2 * products
            products = np.exp(-self.gamma_ * np.maximum(squares, 0))
        return np.asarray(products @ self.weights_.T + self.offsets_)

    def probabilities(self, features: _Array) -> _Array:
        """Class probabilities, shape (samples, classes); rows sum to one."""
        return self._coupled(self.decisions(features))

    def _coupled(self, decisions: _Array) -> _Array:
        slope, shift = self.sigmoids_.T
        chances = 1 / (1 + np.exp(np.clip(slope * decisions + shift, -30, 30)))
        return couple(np.clip(chances, 1e-7, 1 - 1e-7), len(self.classes_))

    def votes(self, features: _Array) -> list[str]:
        """The class that wins most pairs, as libsvm predicts."""
        decisions = self.decisions(features)
        count = np.zeros((len(decisions), len(self.classes_)))
        for k, (i, j) in enumerate(self._pairs()):
            count[:, i] += decisions[:, k] > 0
            count[:, j] += decisions[:, k] <= 0
        return [self.classes_[winner] for winner in count.argmax(axis=1)]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything that prediction needs."""
        return {
            "kernel": np.array(self.kernel),
            "classes": np.array(self.classes_),
            "centre": self.centre_,
            "scale": self.scale_,
            "reach": np.array(self.reach_),
            "vectors": self.vectors_.astype(np.float64 if self.kernel == "linear" else np.float16),
            "weights": self.weights_,
            "offsets": self.offsets_,
            "sigmoids": self.sigmoids_,
            "gamma": np.array(self.gamma_),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The reverse of `to_arrays`."""
        kernel: Kernel = "linear" if str(arrays["kernel"]) == "linear" else "radial"
        made = cls(kernel)
        made.classes_ = tuple(str(name) for name in arrays["classes"])
        made.centre_, made.scale_ = arrays["centre"], arrays["scale"]
        made.reach_ = float(arrays.get("reach", np.array(60.0)))
        made.vectors_ = arrays["vectors"].astype(np.float64)
        made.weights_, made.offsets_ = arrays["weights"], arrays["offsets"]
        made.sigmoids_, made.gamma_ = arrays["sigmoids"], float(arrays["gamma"])
        return made


def held_out_folds(
    labels: NDArray[np.str_], groups: NDArray[np.str_]
) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Indices (known, held out), whole groups together, up to ten folds; with one group, samples are dealt out."""
    from sklearn.model_selection import GroupKFold, StratifiedKFold

    count = len(np.unique(groups))
    if count >= 2:
        return list(GroupKFold(min(_MOST_FOLDS, count)).split(labels, labels, groups))
    fewest = int(np.unique(labels, return_counts=True)[1].min())
    return list(StratifiedKFold(max(2, min(5, fewest))).split(labels, labels))


def _scaling(features: _Array, kind: str) -> tuple[_Array, _Array]:
    if kind == "range":
        low, high = features.min(axis=0), features.max(axis=0)
        centre, scale = (low + high) / 2, (high - low) / 2
    else:
        centre, scale = features.mean(axis=0), features.std(axis=0)
    return centre, np.where(scale > 1e-12, scale, 1.0)


def _pair_weights(dual: _Array, counts: NDArray[np.int32]) -> _Array:
    """Libsvm keeps the weights of a class's vectors against each other class; here one row per pair."""
    ends = np.cumsum(counts)
    parts = [slice(int(end - n), int(end)) for end, n in zip(ends, counts, strict=True)]
    rows = []
    for i, j in combinations(range(len(counts)), 2):
        row = np.zeros(dual.shape[1])
        row[parts[i]] = dual[j - 1, parts[i]]
        row[parts[j]] = dual[i, parts[j]]
        rows.append(row)
    return np.array(rows)


def _sigmoid(values: _Array, first: NDArray[np.bool_], second: NDArray[np.bool_]) -> tuple[float, float]:
    """Platt's sigmoid by Newton's method with his softened targets (Lin, Lin, Weng 2007); both classes count alike.

    Which emotions are usual in a corpus of actors says nothing about the next voice.
    """
    known = np.isfinite(values)
    first, second = first & known, second & known
    ahead, behind = int(first.sum()), int(second.sum())
    if not ahead or not behind:
        return -1.0, 0.0
    f = np.concatenate([values[first], values[second]])
    target = np.concatenate([np.full(ahead, (ahead + 1) / (ahead + 2)), np.full(behind, 1 / (behind + 2))])
    design = np.stack([f, np.ones(len(f))], axis=1)
    weight = np.concatenate([np.full(ahead, 0.5 / ahead), np.full(behind, 0.5 / behind)]) * (ahead + behind)
    found = np.zeros(2)

    def cost(ab: _Array) -> float:
        z = design @ ab
        return float((weight * (target * z + np.logaddexp(0, -z))).sum())

    for _ in range(100):
        p = 1 / (1 + np.exp(np.clip(design @ found, -500, 500)))
        gradient = design.T @ (weight * (target - p))
        if np.abs(gradient).max() < 1e-6:
            break
        hessian = (design * (weight * p * (1 - p))[:, None]).T @ design + 1e-10 * np.eye(2)
        step, size = np.linalg.solve(hessian, gradient), 1.0
        while size > 1e-10 and cost(found - size * step) > cost(found) - 1e-4 * size * float(gradient @ step):
            size /= 2
        found = found - size * step
    return float(found[0]), float(found[1])


def couple(chances: _Array, classes: int) -> _Array:
    """Class probabilities from those of pairs (Wu, Lin, Weng 2004, Eq. 20 and 21); shape (samples, classes).

    Minimises Σ_i Σ_j≠i (r_ji p_i − r_ij p_j)² under Σ p = 1, which is one linear system.

    Parameters
    ----------
    chances : ndarray, shape (samples, pairs)
        r_ij: the probability of class i when it is i or j.
    classes : int

    Examples
    --------
    >>> couple(np.array([[0.5, 0.75, 0.75]]), 3).round(2).tolist()
    [[0.43, 0.43, 0.14]]
    """
    samples = len(chances)
    system = np.zeros((samples, classes + 1, classes + 1))
    for k, (i, j) in enumerate(combinations(range(classes), 2)):
        r_ij, r_ji = chances[:, k], 1 - chances[:, k]
        system[:, i, i] += r_ji**2
        system[:, j, j] += r_ij**2
        system[:, i, j] = system[:, j, i] = -r_ji * r_ij
    system[:, :classes, classes] = system[:, classes, :classes] = 1
    right = np.zeros((samples, classes + 1, 1))
    right[:, classes] = 1
    found = np.clip(np.linalg.solve(system, right)[:, :classes, 0], 0, None)
    return np.asarray(found / found.sum(axis=1, keepdims=True))
