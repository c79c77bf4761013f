"""From a person's markers to channel weights: regions, priors and antagonists around `kernel.descend`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.capture.kernel import descend
from mien.capture.knowledge import Source, knowledge, source_named
from mien.capture.openings import wanted
from mien.capture.person import Person

__all__ = ["Priors", "Solved", "Solver"]

Floats = NDArray[np.float64]

_STILL, _SWEEPS = 1e-5, 400
_LOSER = 0.8  # of what both antagonists may have, left to the weaker one


@dataclass(frozen=True)
class Priors:
    """What is held against a solution, in mm^2 of misfit of one marker.

    Attributes
    ----------
    ridge : float
        On each squared weight, small: it only settles what the markers leave open.
    price : float
        On a weight, the sparse prior: paid in full near 0 and hardly at 1 (Candes, Wakin, Boyd 2008, reweighted l1).
    knee : float
        Weight at which the price is halved.
    alike : float
        On the squared difference of left and right.
    steady : float
        On the squared change from frame to frame at 30 frames/s.
    brisk : float
        Change of a weight from frame to frame at 30 frames/s above which it is taken to be meant: held back half as
        much there, and ever less beyond.
    opening, shut : float
        On the squared misfit across lips and lids, and where they are shut.
    rounds : int
        Times that the prices are set anew.
    """

    ridge: float = 0.2
    price: float = 0.1
    knee: float = 0.02
    alike: float = 4.0
    steady: float = 20.0
    brisk: float = 0.015
    opening: float = 8.0
    shut: float = 150.0
    rounds: int = 4


@dataclass(frozen=True, eq=False)
class Solved:
    """Weights and what they leave.

    Attributes
    ----------
    weights : ndarray, shape (frames, channels)
        Of ``person.channels``, 0..1.
    missed : ndarray, shape (frames, markers, 3)
        Asked minus shown, mm, as the source sees motion.
    """

    weights: Floats
    missed: Floats


class Solver:
    """Channel weights of one person.

    Parameters
    ----------
    person : Person
    priors : Priors, optional
    source : Source, optional
        What the recording shows of motion; the person's own if not given.
    """

    def __init__(self, person: Person, priors: Priors | None = None, source: Source | None = None) -> None:
        self.person, self.priors = person, priors or Priors()
        source, known = source or source_named(person.source), knowledge()
        self._channels = person.channels
        index = {name: number for number, name in enumerate(self._channels)}
        self._gain = np.array(source.gain)
        basis = person.basis * self._gain
        # lips shut over an open jaw need the jaw: the column "mouthClose" stands for both together
        self._shut_jaw = (index["jawOpen"], index["mouthClose"]) if {"jawOpen", "mouthClose"} <= set(index) else None
        seen = person.basis.copy()
        if self._shut_jaw is not None:
            basis[self._shut_jaw[1]] += basis[self._shut_jaw[0]]
            seen[self._shut_jaw[1]] += seen[self._shut_jaw[0]]
        trust = np.zeros(person.neutral.shape)
        heard = np.zeros(basis.shape[:2])
        for number, region in enumerate(known.regions):
            members = person.region == number
            if members.any():
                noise = person.noise[members] / source.floor
                trust[members] = min(1.0, region.count / members.sum()) * np.array(source.weight) ** 2 / (1 + noise**2)
                heard[np.ix_([index[name] for name in region.hears if name in index], members)] = 1.0
        self._basis = basis * heard[:, :, None]
        self._trust = trust
        flat = self._basis.reshape(len(basis), -1)
        self._weighed = flat * trust.ravel()
        gram = np.einsum("km,jm->kj", self._weighed, flat)  # not by BLAS: the same bits on any number of threads
        self._scale = np.sqrt(np.maximum(np.diag(gram), 1e-9))
        self._cost = self._scale * [known.rare.get(name, 1.0) for name in self._channels]
        gram += self.priors.ridge * np.eye(len(gram))
        for name, number in index.items():
            other = index.get(name.replace("Left", "Right"), number) if name.endswith("Left") else number
            if other != number:
                pair = np.ix_([number, other], [number, other])
                gram[pair] += self.priors.alike * np.array([[1.0, -1.0], [-1.0, 1.0]])
        self._gram = gram
        self._pairs = [(index[a], index[b]) for a, b in known.antagonists if a in index and b in index]
        self._openings = np.array([seen[:, :, o.opening.axis] @ o.rows for o in person.openings]).reshape(
            -1, len(index)
        )
        self._own_rest = [
            -float(self._openings[j, index[o.opening.shut_by]]) if o.opening.shut_by in index else 0.0
            for j, o in enumerate(person.openings)
        ]

    def solve(self, positions: Floats, fps: float, most: Floats | None = None, taken: Floats | None = None) -> Solved:
        """Weights for every frame of ``positions`` (frames, markers, 3), of ``person.markers``, mm as recorded.

        ``most``: bounds (frames, channels). ``taken``: motion (frames, markers, 3) of the face, mm, that something else
        than these channels does.
        """
        person, priors = self.person, self.priors
        placed = positions @ person.turn.T
        asked = placed - person.neutral @ person.turn.T
        if taken is not None:
            asked = asked - taken * self._gain
        goal = np.einsum("tm,km->tk", asked.reshape(len(asked), -1), self._weighed)
        open_goal, open_weight = self._opening_goals(placed)
        if taken is not None:
            open_goal -= (
                np.array([taken[:, :, o.opening.axis] @ o.rows for o in person.openings])
                .reshape(len(person.openings), -1)
                .T
            )
        weights = np.zeros_like(goal)
        upper = np.ones_like(goal) if most is None else most
        steady = held = np.full_like(goal, priors.steady * (fps / 30.0) ** 2)
        price = np.full_like(goal, priors.price) * self._cost
        for _ in range(priors.rounds):
            descend(
                self._gram,
                goal - price,
                upper,
                steady,
                self._openings,
                open_goal,
                open_weight,
                weights,
                _STILL,
                _SWEEPS,
            )
            calm = _calmed(weights)
            price = priors.price * self._cost / (1 + calm / priors.knee)
            pace = np.abs(np.diff(calm, axis=0, prepend=calm[:1])) * (fps / 30.0)
            steady = held / (1 + (pace / priors.brisk) ** 2)
        upper = np.minimum(self._apart(weights), upper)
        np.minimum(weights, upper, out=weights)
        descend(
            self._gram, goal - price, upper, steady, self._openings, open_goal, open_weight, weights, _STILL, _SWEEPS
        )
        missed = asked - np.einsum("tc,cmk->tmk", weights, self._basis)
        if self._shut_jaw is not None:
            jaw, close = self._shut_jaw
            weights[:, jaw] = np.minimum(weights[:, jaw] + weights[:, close], 1.0)
        return Solved(weights, missed)

    def _opening_goals(self, placed: Floats) -> tuple[Floats, Floats]:
        goals, weights = [], []
        all_shut: dict[str, NDArray[np.bool_]] = {}
        for seen, own_rest in zip(self.person.openings, self._own_rest, strict=True):
            goal, shut = wanted(seen, placed[:, :, seen.opening.axis] @ seen.rows, own_rest)
            if seen.opening.shut_with is not None:
                shut = shut & all_shut.get(seen.opening.shut_with, shut)
            all_shut[seen.opening.name] = shut
            goals.append(goal)
            weights.append(seen.opening.weight * np.where(shut, self.priors.shut, self.priors.opening))
        shape = (len(self.person.openings), len(placed))
        return (
            np.ascontiguousarray(np.array(goals).reshape(shape).T),
            np.ascontiguousarray(np.array(weights, dtype=np.float64).reshape(shape).T),
        )

    def _apart(self, weights: Floats) -> Floats:
        """Bounds that leave the weaker of two antagonists next to nothing."""
        upper, calm = np.ones_like(weights), _calmed(weights)
        small = _LOSER * knowledge().most_of_both
        for one, other in self._pairs:
            stronger = calm[:, one] * self._scale[one] >= calm[:, other] * self._scale[other]
            upper[stronger, other] = np.minimum(upper[stronger, other], small)
            upper[~stronger, one] = np.minimum(upper[~stronger, one], small)
        return upper


def _calmed(weights: Floats) -> Floats:
    """Means over three frames: prices and bounds that do not flicker."""
    padded = np.concatenate([weights[:1], weights, weights[-1:]])
    return np.asarray((padded[:-2] + 2 * padded[1:-1] + padded[2:]) / 4)
