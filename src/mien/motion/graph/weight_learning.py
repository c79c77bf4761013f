"""Weights of the search and the warp, learned by cross-validation on the takes that are learned from.

Some takes are held out, a graph is made of the others, and weights are tried on the held-out ones, one after the other
(coordinate descent): those stay with which the joined motion comes nearest to the recorded one (RMS over markers, mm,
inside speech; closures not held). The join's weight stays 1: only ratios matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph
from mien.motion.graph.sound import heard_features
from mien.motion.mouth.mouth_space import MouthSpace

__all__ = ["LEARNED_START", "TRIALS", "Searched", "learn_weights"]

HELD_OUT = 8
"""One take in so many is held out ..."""
MOST_HELD_OUT = 20
"""... but no more than these."""
LEAST_TAKES = 16
"""With fewer takes nothing is learned: the start is used."""
_TRIED: dict[str, tuple[float, ...]] = {
    "evenness": (0.0, 0.5, 1.0),
    "jump": (0.3, 3.0),
    "audio": (0.5, 2.0, 4.0),
    "duration": (0.0, 1.0, 4.0),
}
TRIALS = 1 + 2 * sum(len(values) for values in _TRIED.values())
"""How often `learn_weights` tells that it has gone on: as many trials as it can need."""

LEARNED_START = SearchWeights(jump=1.0, join=1.0, audio=1.0, duration=2.0)
"""Where the learning of the weights begins, and what is used where too few takes are there to learn from."""

Floats = NDArray[np.float64]


class Searched(Protocol):
    """What is tried: a model that takes a graph with weights, and performs features of sound (`GraphMotion`)."""

    settings: Any
    mouth_: MouthSpace

    def restore(self, graph: AnimeGraph, weights: SearchWeights, evenness: float) -> Any:
        """Take a graph and weights."""

    def perform_features(self, phones: Tier, times: Floats, features: Floats | None) -> Floats:
        """Motion at instants."""


@dataclass(frozen=True)
class _Choice:
    weights: SearchWeights
    evenness: float

    def but(self, name: str, value: float) -> _Choice:
        if name == "evenness":
            return replace(self, evenness=value)
        given: dict[str, Any] = {name: value}
        return replace(self, weights=replace(self.weights, **given))


def learn_weights(
    motion: Searched,
    takes: Sequence[Take],
    chains: Sequence[RecordedChain],
    weights: SearchWeights | None,
    evenness: float | None,
    after_trial: Callable[[], None],
) -> tuple[SearchWeights, float]:
    """Weights and evenness that join held-out takes best; those given stay as they are.

    Parameters
    ----------
    motion : Searched
        With code and cut-offs learned; it is left as it is.
    takes, chains : sequences
        The same takes, ready to be a graph.
    weights, evenness
        Given, or None to learn them.
    after_trial : callable
        Called `TRIALS` times, to show progress.
    """
    start = _Choice(weights or LEARNED_START, 0.5 if evenness is None else evenness)
    if len(takes) < LEAST_TAKES:
        _tell_rest(after_trial, 0)
        return start.weights, start.evenness
    held = list(range(HELD_OUT // 2, len(takes), HELD_OUT))
    held = held[:: -(-len(held) // MOST_HELD_OUT)]
    graph = build_graph([c for place, c in enumerate(chains) if place not in held], motion.mouth_.points, instants=True)
    trial = copy(motion)
    trial.settings = replace(motion.settings, hold_closures=False)
    tests = [_Test.of(takes[place], motion.mouth_) for place in held]
    free = [name for name in _TRIED if (evenness if name == "evenness" else weights) is None]

    done = 0

    def missed(choice: _Choice) -> float:
        nonlocal done
        done += 1
        trial.restore(graph, choice.weights, choice.evenness)
        error = float(np.mean([test.missed(trial) for test in tests]))
        after_trial()
        return error

    best, least = start, missed(start)
    for _ in range(2):
        before = best
        for name in free:
            for value in _TRIED[name] if name == "evenness" else _steps(best, name):
                tried = best.but(name, value)
                if tried != best and (error := missed(tried)) < least:
                    best, least = tried, error
        if best == before:
            break
    _tell_rest(after_trial, done)
    return best.weights, best.evenness


def _tell_rest(after_trial: Callable[[], None], done: int) -> None:
    for _ in range(done, TRIALS):
        after_trial()


def _steps(best: _Choice, name: str) -> tuple[float, ...]:
    """Values to try for a weight: shares and multiples of its present one."""
    now = float(getattr(best.weights, name))
    return tuple(factor * now for factor in _TRIED[name])


@dataclass(frozen=True, eq=False)
class _Test:
    """A take that is held out, as it is asked for and as it was recorded."""

    take: Take
    features: Floats
    times: Floats
    rows: Floats

    @classmethod
    def of(cls, take: Take, mouth: MouthSpace) -> _Test:
        flat = mouth.rows_of(take)
        times = take.markers.rate.times(len(flat))
        spoken = [phone for phone in take.phones if phone.label != PAUSE]
        kept = np.isfinite(flat).all(axis=1)
        if spoken:
            kept &= (times >= spoken[0].start - 0.08) & (times <= spoken[-1].end + 0.08)
        return cls(take, heard_features(take.audio, take.phones), times[kept], flat[kept])

    def missed(self, motion: Searched) -> float:
        """RMS over the points of the mouth and frames, mm."""
        if not len(self.times):
            return 0.0
        found = motion.mouth_.rows_from(motion.perform_features(self.take.phones, self.times, self.features))
        return float(np.sqrt(((found - self.rows) ** 2).sum() / len(self.rows) / motion.mouth_.points))
