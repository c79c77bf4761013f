"""A job that ends its process, in a module that other processes can import."""

from __future__ import annotations

import os


def double_or_die(number: int) -> int:
    if number == 13:
        os._exit(1)
    return 2 * number
