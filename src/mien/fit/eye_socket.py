"""The skin behind the lids: it turns about the eyeball with them, so that it never comes through the eyeball."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.model import Eye, Face
from mien.fit.shape_transfer import Carried

__all__ = ["Socket", "sockets_of"]

Floats = NDArray[np.float64]

_BACK_MM = (0.5, 2.0, 20.0)  # behind the lids: from where, how fast it stops to move as these do, and to move at all
_DRAWN = 0.7  # of a lid's turn; hand-made, as these


@dataclass(frozen=True, eq=False)
class Socket:
    """The skin behind an eye's lids: each lid draws its half round the eyeball, less and less the deeper it lies.

    ``numbers`` (k,) are its vertices, ``arm`` (k, 3) from the eyeball's centre, ``depth`` (k,) behind the lids, and
    ``upper`` (k,) the share of the upper lid; ``lids`` the numbers and arms of the two lids' vertices; mm.
    """

    numbers: NDArray[np.int64]
    arm: Floats
    depth: Floats
    upper: Floats
    lids: tuple[tuple[NDArray[np.int64], Floats], ...]

    def turn(self, moves: NDArray[np.floating[Any]]) -> None:
        """Set its part of moves (n, 3 times targets)."""
        near = np.exp(-(self.depth - _BACK_MM[0]) / _BACK_MM[1])[:, None]  # moves as the lid before it
        drawn = _DRAWN * (1 - near) * np.exp(-self.depth[:, None] / _BACK_MM[2])
        systems = [_cross_matrices(arm).reshape(-1, 3) for _, arm in self.lids]
        for column in range(0, moves.shape[1], 3):
            own = slice(column, column + 3)
            upper, lower = (
                np.cross(np.linalg.lstsq(system, moves[numbers, own].ravel(), rcond=None)[0], self.arm)
                for system, (numbers, _) in zip(systems, self.lids, strict=True)
            )
            turned = self.upper[:, None] * upper + (1 - self.upper[:, None]) * lower
            moves[self.numbers, own] = near * moves[self.numbers, own] + drawn * turned


def _cross_matrices(arm: Floats) -> Floats:
    """Matrices M (m, 3, 3) with ``M @ w = w x arm``."""
    x, y, z = arm.T
    zero = np.zeros_like(x)
    return np.stack([np.stack(row, axis=1) for row in ((zero, z, -y), (-z, zero, x), (y, -x, zero))], axis=1)


def sockets_of(face: Face, carried: Carried, vertices: Floats) -> tuple[Socket, ...]:
    """What lies behind the lids of a head with vertices (n, 3), mm; ``face`` is the default's on this head."""
    return tuple(found for eye in face.eyes if (found := _socket(face, eye, carried, vertices)) is not None)


def _socket(face: Face, eye: Eye, carried: Carried, vertices: Floats) -> Socket | None:
    centre = np.array(eye.centre)
    radius = float(np.median(np.linalg.norm(face.part(eye.part).vertices - centre, axis=1)))
    arm = vertices - centre
    away = np.linalg.norm(arm, axis=1)
    hidden = (arm[:, 2] < 0.6 * radius) | (away < 0.98 * radius)  # no lid's outside lies within the eyeball
    behind = np.flatnonzero((away < 2.0 * radius) & hidden & (carried.distance > _BACK_MM[0]))
    outside = (away < 1.25 * radius) & (carried.distance < 1.0) & ~hidden
    side = carried.upper[f"eye_{eye.side.lower()}"]
    lids = tuple((some, arm[some]) for sign in (1, -1) if len(some := np.flatnonzero(outside & (side == sign))) > 2)
    if not len(behind) or len(lids) < 2:
        return None
    upper = np.clip(0.5 + arm[behind, 1] / radius, 0, 1)
    return Socket(behind, arm[behind], carried.distance[behind], upper, lids)
