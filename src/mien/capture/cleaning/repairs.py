"""`Repair`: one thing that was changed in a recording, so that it can be reported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["Repair", "RepairKind", "complete", "runs"]

RepairKind = Literal["units", "axes", "frozen", "dropped", "swap", "spike", "gap", "lost face", "head"]


@dataclass(frozen=True)
class Repair:
    """One change.

    Attributes
    ----------
    kind : RepairKind
    markers : tuple of str
        The markers concerned; empty where all are.
    first, last : int
        Frames, both included.
    method : str
        What was done.

    Examples
    --------
    >>> str(Repair("gap", ("lip",), 4, 6, "spline"))
    'gap: lip, frames 4..6: spline'
    """

    kind: RepairKind
    markers: tuple[str, ...]
    first: int
    last: int
    method: str

    def __str__(self) -> str:
        who = " and ".join(self.markers) if self.markers else "all markers"
        return f"{self.kind}: {who}, frames {self.first}..{self.last}: {self.method}"


def complete(positions: NDArray[np.float64], dimensions: int = 1) -> NDArray[np.bool_]:
    """Where all numbers over the last ``dimensions`` of an array are finite: 1 for markers, 2 for whole frames.

    Examples
    --------
    >>> complete(np.array([[[0.0, np.nan, 0.0], [1.0, 2.0, 3.0]]])).tolist()
    [[False, True]]
    """
    return np.asarray(np.isfinite(positions).all(axis=tuple(range(-dimensions, 0))), dtype=np.bool_)


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last (included) index of each run of True.

    Examples
    --------
    >>> runs(np.array([True, False, True, True]))
    [(0, 0), (2, 3)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
