import numpy as np
import pytest

from mien.core.errors import InputError
from mien.motion.em_pca import EMPCA


def mixture(frames=400, dimensions=30, seed=0):
    random = np.random.default_rng(seed)
    spread = np.r_[9.0, 5.0, 3.0, 2.0, 1.0, np.full(dimensions - 5, 0.05)]
    turned = np.linalg.qr(random.standard_normal((dimensions, dimensions)))[0]
    return random.standard_normal((frames, dimensions)) * spread @ turned + 7.0


def test_the_same_axes_as_singular_values_find():
    data = mixture()
    model = EMPCA(5, tolerance=1e-14).fit(data)
    _, singular, axes = np.linalg.svd(data - data.mean(axis=0), full_matrices=False)
    assert np.abs(np.abs((model.axes_ * axes[:5]).sum(axis=1)) - 1).max() < 1e-6
    assert np.allclose(model.variances_, singular[:5] ** 2 / len(data))
    assert model.share_ == pytest.approx((singular[:5] ** 2).sum() / (singular**2).sum(), abs=1e-9)


def test_what_lies_in_the_space_comes_back():
    data = mixture()
    model = EMPCA(5).fit(data)
    inside = model.decode(model.encode(data))
    assert np.allclose(model.decode(model.encode(inside)), inside)
    assert ((inside - data) ** 2).sum() < 0.02 * ((data - data.mean(axis=0)) ** 2).sum()


def test_more_components_than_the_data_has_are_refused():
    with pytest.raises(InputError, match="5 components cannot be learned from 4 frames"):
        EMPCA(5).fit(np.zeros((4, 30)))


def test_data_that_do_not_move_have_all_their_variance():
    assert EMPCA(1).fit(np.ones((5, 3))).share_ == 1.0


def test_what_counts_more_is_kept_better():
    data = mixture()
    counts = np.r_[np.ones(29), 50.0]
    plain, weighted = EMPCA(3).fit(data), EMPCA(3).fit(data, counts)
    missed = [np.abs(model.decode(model.encode(data)) - data)[:, 29].mean() for model in (plain, weighted)]
    assert missed[1] < 0.1 * missed[0]
    inside = weighted.decode(weighted.encode(data))
    assert np.allclose(weighted.decode(weighted.encode(inside)), inside)
