"""From the motion of places on a face to the weights of its morph targets: bounded least squares, steady in time.

Each frame asks for displacements ``d`` (markers x 3, mm) of known places; at weight 1 the target ``k`` moves them by
``B_k``. All frames are solved together::

    minimise  sum_t |B w_t - d_t|^2 + ridge |w_t|^2 + steadiness |w_t - w_(t-1)|^2     with 0 <= w <= 1

(Deng et al. 2006, section VII, ask for weights in [0, 1].) The problem is convex; it is solved by projected gradients
with Nesterov's momentum and restarts (O'Donoghue & Candes 2015), which factorises nothing and gives the same bits
each time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError
from mien.face.model import Face

__all__ = ["Retargeted", "Retargeter"]

Floats = NDArray[np.float64]
Site = tuple[str, int]

ITERATIONS = 2000
_WINDOW, _OVERLAP = 20.0, 1.0  # seconds that are solved at once, and how far beyond them is looked
STILL = 1e-6  # largest change of a weight in a step at which the solution counts as reached


@dataclass(frozen=True)
class Retargeted:
    """Weights, and how well they do what was asked.

    Attributes
    ----------
    weights : ndarray, shape (frames, channels)
        0..1.
    residual : ndarray, shape (frames,)
        Root mean square distance over the markers between asked and reached, mm.
    """

    weights: Floats
    residual: Floats


class Retargeter:
    """Finds the weights of a face's morph targets that move given places as asked.

    Parameters
    ----------
    face : Face
    sites : sequence of (part name, vertex index)
        Where each marker sits on the face.
    channels : sequence of str
        Morph targets that may be used.
    ridge, steadiness : float
        Share of the mean squared length of a target (over all markers) with which large weights, and changes from frame
        to frame at 30 frames per second, are held back.
    depth : float
        How much a displacement in depth (z) counts against one that is seen from the front.

    Raises
    ------
    InputError
        If a site is not on the face, or a channel moves none of the sites.
    """

    def __init__(
        self,
        face: Face,
        sites: Sequence[Site],
        channels: Sequence[str],
        ridge: float = 2e-3,
        steadiness: float = 2e-3,
        depth: float = 1.0,
    ) -> None:
        self.channels = tuple(channels)
        self.sites = tuple(sites)
        self.ridge, self.steadiness = ridge, steadiness
        self.weights = np.array([1.0, 1.0, depth])
        self.basis = basis_at(face, self.sites, self.channels)
        still = [n for n, column in zip(self.channels, self.basis, strict=True) if not column.any()]
        if still:
            raise InputError(f"face {face.name!r}: {', '.join(still)} move none of the {len(self.sites)} marker sites")

    def solve(self, displacements: ArrayLike, fps: float = 30.0) -> Retargeted:
        """Weights for every frame.

        Parameters
        ----------
        displacements : array_like, shape (frames, markers, 3)
            Millimetres from the rest position, in the face's axes.
        fps : float
            Frames per second: the same motion at twice the rate is held back as much per second.

        Raises
        ------
        InputError
            If the shape does not fit, or a number is not finite.
        """
        asked = np.asarray(displacements, dtype=np.float64)
        if asked.ndim != 3 or asked.shape[1:] != (len(self.sites), 3):
            raise InputError(
                f"displacements: expected (frames, {len(self.sites)} markers, 3 coordinates), got {asked.shape}"
            )
        if not np.isfinite(asked).all():
            frame, marker = np.argwhere(~np.isfinite(asked))[0][:2]
            raise InputError(f"displacements: frame {frame}, marker {marker} is not a finite number; fill gaps first")
        flat = (self.basis * self.weights).reshape(len(self.channels), -1)
        scale = float((flat**2).sum(axis=1).mean())
        steady = self.steadiness * scale * (fps / 30.0) ** 2
        weights = _solve(flat, (asked * self.weights).reshape(len(asked), -1), self.ridge * scale, steady, fps)
        missed = np.einsum("tc,cmx->tmx", weights, self.basis) - asked
        return Retargeted(weights, np.sqrt((missed**2).sum(axis=2).mean(axis=1)))


def basis_at(face: Face, sites: Sequence[Site], channels: Sequence[str]) -> Floats:
    """How far each channel moves each site at weight 1, shape (channels, markers, 3), mm."""
    parts = {part.name: part for part in face.parts}
    basis = np.zeros((len(channels), len(sites), 3))
    for name, vertex in sites:
        if name not in parts or not 0 <= vertex < len(parts[name].vertices):
            raise InputError(f"face {face.name!r} has no vertex {vertex} in a part {name!r}")
    for part_name in {name for name, _ in sites}:
        columns = np.array([c for c, (name, _) in enumerate(sites) if name == part_name])
        vertices = np.array([sites[c][1] for c in columns])
        for row, channel in enumerate(channels):
            target = parts[part_name].targets.get(channel)
            if target is not None:
                dense = np.zeros((len(parts[part_name].vertices), 3))
                dense[target.vertices] = target.offsets
                basis[row, columns] = dense[vertices]
    return basis


def _solve(basis: Floats, asked: Floats, ridge: float, steady: float, fps: float) -> Floats:
    """Bounded least squares over all frames; ``basis`` (channels, 3 markers), ``asked`` (frames, 3 markers).

    In windows that overlap: what a frame asks for is forgotten within a few frames (the steadiness is of the ridge's
    size), so a long line costs as much per second as a short one, and no more memory at a time.
    """
    gram = basis @ basis.T + ridge * np.eye(len(basis))
    step = float(1.0 / (np.linalg.eigvalsh(gram)[-1] + 4 * steady))
    kept, beside = max(1, round(_WINDOW * fps)), max(1, round(_OVERLAP * fps))
    weights = np.empty((len(asked), len(basis)))
    for first in range(0, len(asked), kept):
        last = min(first + kept, len(asked))
        begin, end = max(0, first - beside), min(len(asked), last + beside)
        found = _descended(gram, asked[begin:end] @ basis.T, steady, step)
        weights[first:last] = found[first - begin : last - begin]
    return weights


def _descended(gram: Floats, goal: Floats, steady: float, step: float) -> Floats:
    """Projected descent with momentum, all frames at once; `descended_plainly` in the tests is its reference."""
    weights, ahead, momentum = np.zeros_like(goal), np.zeros_like(goal), 1.0
    for _ in range(ITERATIONS):
        pull = ahead @ gram
        pull -= goal
        change = np.diff(ahead, axis=0)
        change *= steady
        pull[:-1] -= change
        pull[1:] += change
        pull *= -step
        pull += ahead
        new = np.clip(pull, 0.0, 1.0, out=pull)
        moved = new - weights
        ahead -= new
        if (ahead * moved).sum() > 0:  # the momentum points uphill: start it anew
            momentum = 1.0
        next_momentum = (1 + math.sqrt(1 + 4 * momentum**2)) / 2
        ahead = ((momentum - 1) / next_momentum) * moved
        ahead += new
        weights, momentum = new, next_momentum
        if np.abs(moved).max(initial=0.0) < STILL:
            break
    return weights
