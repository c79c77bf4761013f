"""`plain_search`: the least cost by plain dynamic programming, the reference of the fast search (`search`).

Every pair of nodes of neighbouring phones is looked at, and the audio distance of every node that could be taken is
computed: time grows with the square of the graph.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.motion.graph.candidates import Candidates, GraphIndex, candidates_for
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.query import SpokenPhones

__all__ = ["plain_search"]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Whole32 = NDArray[np.int32]

BLOCK = 1 << 22
"""Pairs that are looked at together, which bounds the memory."""


def plain_search(index: GraphIndex, asked: SpokenPhones, weights: SearchWeights) -> tuple[Whole, float]:
    """Nodes of the cheapest way and its cost.

    Parameters
    ----------
    index : GraphIndex
    asked : SpokenPhones
        At least one phone.
    weights : SearchWeights
    """
    steps = candidates_for(index, asked, weights)
    best = _alone(steps, 0)
    origins: list[Whole] = []
    for step in range(1, len(asked)):
        origin, reached = _reach(index, steps.nodes(step - 1), steps.nodes(step), best, weights)
        best = reached + _alone(steps, step)
        origins.append(origin)
    place = int(best.argmin())
    cost = float(best[place])
    path = [place]
    for origin in reversed(origins):
        path.append(int(origin[path[-1]]))
    return np.array([steps.nodes(step)[place] for step, place in enumerate(reversed(path))], dtype=np.int64), cost


def _alone(steps: Candidates, step: int) -> Floats:
    """What each node costs at a phone on its own."""
    offsets = np.zeros(len(steps.lists) + 1, dtype=np.int64)
    offsets[step + 1 :] = len(steps.nodes(step))
    return steps.other_costs(step) + steps.audio_costs(steps.nodes(step), offsets)


def _reach(
    index: GraphIndex, before: Whole32, after: Whole32, best: Floats, weights: SearchWeights
) -> tuple[Whole, Floats]:
    """For each node the cheapest place to come from, and what coming from there costs in all."""
    origin = np.empty(len(after), dtype=np.int64)
    reached = np.empty(len(after))
    height = max(1, BLOCK // len(before))
    exits = index.exits[before].astype(np.float64)
    for first in range(0, len(after), height):
        here = after[first : first + height]
        entries = index.entries[here].astype(np.float64)
        apart = np.sqrt(np.maximum(_square_distances(exits, entries), 0.0))
        recorded = (before[:, None] == here[None] - 1) & index.follows[here][None]
        join = weights.join * apart
        costs = best[:, None] + np.where(recorded, join * weights.join_everywhere, weights.jump + join)
        places = costs.argmin(axis=0)
        origin[first : first + height] = places
        reached[first : first + height] = costs[places, np.arange(len(here))]
    return origin, reached


def _square_distances(exits: Floats, entries: Floats) -> Floats:
    total = np.zeros((len(exits), len(entries)))
    for axis in range(exits.shape[1]):
        total += (exits[:, axis, None] - entries[None, :, axis]) ** 2
    return total
