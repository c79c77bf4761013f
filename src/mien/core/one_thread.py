"""The same bits on any number of processor cores: sums of matrix products are taken in one order.

BLAS splits a product among its threads, so that the last bits of a result depend on how many there are. What is
performed is small enough for one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

__all__ = ["one_thread"]

Given = ParamSpec("Given")
Result = TypeVar("Result")


def one_thread(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """Have matrix products inside a function done by one thread.

    Examples
    --------
    >>> import numpy as np
    >>> @one_thread
    ... def product(a, b): return a @ b
    >>> product(np.eye(2), np.ones(2)).tolist()
    [1.0, 1.0]
    """

    @wraps(function)
    def alone(*given: Given.args, **named: Given.kwargs) -> Result:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            return function(*given, **named)

    return alone
