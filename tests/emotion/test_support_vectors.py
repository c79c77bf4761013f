from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.svm import SVC

from mien.core.errors import InputError
from mien.emotion.support_vectors import Kernel, SupportVectors, couple, held_out_folds


def blobs(classes: int, random: np.random.Generator, spread: float = 0.7) -> tuple[NDArray[np.float64], list[str]]:
    centres = random.normal(0, 1.5, (classes, 5))
    labels = [f"c{i % classes}" for i in range(60 * classes)]
    return centres[[int(name[1:]) for name in labels]] + random.normal(0, spread, (len(labels), 5)), labels


@pytest.mark.parametrize("classes", [2, 3, 5])
@pytest.mark.parametrize("kernel", ["radial", "linear"])
def test_prediction_equals_scikit_learn(classes: int, kernel: Kernel) -> None:
    features, labels = blobs(classes, np.random.default_rng(classes))
    ours = SupportVectors(kernel).fit_vectors(features, np.array(labels))
    theirs = SVC(C=1.0, kernel="linear" if kernel == "linear" else "rbf", gamma=ours.gamma_, class_weight="balanced",
                 decision_function_shape="ovo").fit(ours.scaled(features), labels)  # fmt: skip
    fresh = np.random.default_rng(9).normal(0, 2, (50, 5))
    expected = theirs.decision_function(ours.scaled(fresh))
    expected = -expected[:, None] if classes == 2 else expected
    assert np.allclose(ours.decisions(fresh), expected, atol=1e-9)
    assert ours.votes(features) == list(theirs.predict(ours.scaled(features)))


def test_what_is_stored_predicts_the_same_bits() -> None:
    features, labels = blobs(4, np.random.default_rng(0))
    learned = SupportVectors().fit(features, labels, [str(i % 6) for i in range(len(labels))])
    again = SupportVectors.from_arrays(learned.to_arrays())
    assert np.array_equal(learned.probabilities(features), again.probabilities(features))


def test_probabilities_are_as_sure_as_they_are_right() -> None:
    random = np.random.default_rng(1)
    features, labels = blobs(3, random, spread=2.0)
    half = np.arange(len(labels)) < len(labels) // 2
    learned = SupportVectors().fit(
        features[half], [n for n, h in zip(labels, half, strict=True) if h], [str(i % 5) for i in range(half.sum())]
    )
    probabilities = learned.probabilities(features[~half])
    assert np.allclose(probabilities.sum(axis=1), 1)
    right = np.array(learned.classes_)[probabilities.argmax(axis=1)] == np.array(labels)[~half]
    assert probabilities.max(axis=1).mean() == pytest.approx(right.mean(), abs=0.12)


def test_coupling_recovers_probabilities_that_fit() -> None:
    true = np.array([0.5, 0.3, 0.15, 0.05])
    pairs = [true[i] / (true[i] + true[j]) for i in range(4) for j in range(i + 1, 4)]
    assert couple(np.array([pairs]), 4)[0] == pytest.approx(true)


def test_groups_stay_together_in_folds() -> None:
    groups = np.array([str(i % 4) for i in range(40)])
    for known, out in held_out_folds(np.array(["a", "b"] * 20), groups):
        assert not set(groups[known]) & set(groups[out])


def test_one_class_is_refused() -> None:
    with pytest.raises(InputError, match="at least two"):
        SupportVectors().fit(np.zeros((3, 2)), ["a"] * 3, ["1", "2", "3"])
