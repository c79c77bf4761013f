"""Triangles out of an STL file, binary or ASCII; corners that lie together become one vertex."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import check_begun, check_size, read_bytes
from mien.core.plain_text import text_lines

__all__ = ["read_stl"]


def read_stl(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices (n, 3) and triangles (t, 3).

    Raises
    ------
    InputError
        If it is cut off or no STL file.
    """
    check_begun(path)
    data = read_bytes(path, "mesh")
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count and count:
        check_size("rows", count, str(path))
        rows = np.frombuffer(data, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")], count, 84)
        corners = rows["corners"].reshape(-1, 3).astype(np.float64)
    elif data[:5].lower() == b"solid":
        del data
        corners = _corners(path)
    else:
        raise InputError(f"{path} is not an STL file, or cut off: it holds {len(data)} bytes for {count} triangles")
    if len(corners) == 0 or len(corners) % 3 or not np.isfinite(corners).all():
        raise InputError(f"{path}: no whole triangles in it")
    vertices, number = np.unique(corners, axis=0, return_inverse=True)
    return vertices, number.reshape(-1, 3).astype(np.int32)


def _corners(path: Path) -> NDArray[np.float64]:
    """The corners (n, 3) of an ASCII file: three numbers after each word ``vertex``."""
    numbers, wanted = array("d"), 0
    for line in text_lines(path, "mesh"):
        for word in line.split():
            if wanted:
                numbers.append(float(word))
                wanted -= 1
            elif word.lower() == "vertex":
                wanted = 3
    return np.array(numbers[: len(numbers) // 3 * 3]).reshape(-1, 3)
