"""Which rows of a table are alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["row_groups"]

_MOST = 2**62


def row_groups(rows: NDArray[Any]) -> NDArray[np.int64]:
    """Number the rows of a table, equal ones alike, in their order: `numpy.unique` of rows, several times as fast.

    Parameters
    ----------
    rows : ndarray of whole numbers (of any type), shape (rows, columns)

    Returns
    -------
    ndarray, shape (rows,)
        0 for the first row in lexicographic order.

    Examples
    --------
    >>> row_groups(np.array([[1, 2], [0, 5], [1, 2], [1, 0]])).tolist()
    [2, 0, 2, 1]
    """
    found, size = np.zeros(len(rows), np.int64), 1
    for column in rows.T if len(rows) else ():
        low = column.min()
        span = int(column.max() - low) + 1
        if size * span >= _MOST:
            found = np.unique(found, return_inverse=True)[1]
            size = int(found.max()) + 1
        found = found * span + (column - low).astype(np.int64)
        size *= span
    return np.unique(found, return_inverse=True)[1]
