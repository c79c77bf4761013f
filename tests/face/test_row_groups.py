"""Rows numbered as `numpy.unique` numbers them."""

import numpy as np

from mien.face.row_groups import row_groups


def test_rows_are_numbered_as_numpy_does() -> None:
    rows = np.random.default_rng(1).integers(-3, 4, (500, 4))
    assert row_groups(rows).tolist() == np.unique(rows, axis=0, return_inverse=True)[1].tolist()


def test_columns_that_do_not_fit_into_one_number() -> None:
    rows = np.random.default_rng(2).integers(0, 2, (200, 5)) * 2**40
    assert row_groups(rows).tolist() == np.unique(rows, axis=0, return_inverse=True)[1].tolist()


def test_no_rows() -> None:
    assert row_groups(np.zeros((0, 3))).shape == (0,)
