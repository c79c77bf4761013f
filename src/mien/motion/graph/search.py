"""`search`: the cheapest way through the Anime Graph, exactly, in a small part of the plain programme's time.

The plain programme (`plain_search`) walks through the phones and keeps, for each node that may stand at a phone, the
least cost of a way that ends there: every pair of nodes of neighbouring phones is looked at. Here a *state* is a node
at a phone; V is the least cost of a way up to and with a state. Four observations make states and pairs superfluous;
each keeps at least one cheapest way.

1. *Bounds.* Let joins at jumps cost nothing and let every node cost no more than it does. The least cost F of a way
   from the start up to a state, and B of one from there to the end, then take one pass each over the states, since all
   jumps into a phone come from the same cheapest state. Every true way through a state costs at least F + B. If some
   way of cost U is known, states with F + B > U are on no cheapest way and are dropped. Where jumps are dear (the
   paper's weights), what is left is nothing but the ways with the fewest jumps: long recorded runs. That the other
   costs never add up to a jump is not assumed: where they do, U says so, and the states stay.
2. *The audio distance, the dear part of a node, is computed late*: first F and B are taken with it at 0 (it is never
   below), then it is computed for the states that are left, and both are taken again. Long stretches, most of all
   pauses, whose cost grows with the square of their length, wait once more: where few states are left, F and B are
   taken with the joins, and only what is within U is heard.
3. *Dominated sources.* The join is a distance, so the triangle inequality holds: if two states of one phone have
   V(a) + join · |exit a - exit b| <= V(b), any jump from b costs at least as much as the same jump from a. (If that
   jump leads to the recorded successor of a, it is none from a and costs less still.) Then b matters only for going on
   along its own recording, and not even for that if the jump from a to b's successor is as cheap. States are taken in
   the order of lower bounds of V; many are dominated before their V is computed at all, and few are left to jump from.
4. *Blocks.* The places to jump from are packed into blocks of 16 with like exit poses; a block whose least V, plus the
   distance of a pose to the block's box, is no less than the best jump found is skipped.

U is the cost of a way found by a beam that is led by B. Comparisons with U leave room for rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.utterance import PAUSE
from mien.motion.graph.candidates import Candidates, GraphIndex, candidates_for
from mien.motion.graph.cheapest_way import cheapest_way
from mien.motion.graph.costs import PathCost, SearchWeights, path_cost
from mien.motion.graph.jump_kernels import join_bounds
from mien.motion.graph.kernels import backward_bounds, beam, within
from mien.motion.graph.query import SpokenPhones
from mien.motion.graph.standing_in import Substitution, substitutions_in

__all__ = ["Effort", "FoundWay", "cheapest_nodes", "describe_way", "search"]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Whole32 = NDArray[np.int32]

WIDTH = 24
"""States that the beam keeps."""

LONG = 32
"""Frames of features from which a phone counts as long; pauses always do."""

FEW = 0.6
"""Share of all states that may be left for bounds with joins to be worth their time."""

ROUNDING = 1e-5
"""Share of a known cost that bounds must exceed it by: distances are in single precision."""


@dataclass(frozen=True)
class Effort:
    """What a search looked at.

    Attributes
    ----------
    states : int
        Nodes that could stand at the phones, summed over the phones.
    heard : int
        States left when the audio of long phones was compared, the last.
    left : int
        States left after the second bounds.
    weighed : int
        States whose least cost was computed.
    """

    states: int
    heard: int
    left: int
    weighed: int


@dataclass(frozen=True, eq=False)
class FoundWay:
    """The cheapest way.

    Attributes
    ----------
    nodes : ndarray of int64, shape (phones,)
        One node for each phone.
    jumps : ndarray of bool, shape (phones,)
        Whether a node is not the recorded successor of the one before it; the first is no jump.
    cost : PathCost
    substitutions : tuple of Substitution
        Where another phone or another emotion than asked for had to be taken.
    effort : Effort
    """

    nodes: Whole
    jumps: NDArray[np.bool_]
    cost: PathCost
    substitutions: tuple[Substitution, ...]
    effort: Effort


def search(index: GraphIndex, asked: SpokenPhones, weights: SearchWeights | None = None) -> FoundWay:
    """Find the cheapest way.

    Parameters
    ----------
    index : GraphIndex
    asked : SpokenPhones
        At least one phone.
    weights : SearchWeights or None
        None: the paper's.

    Raises
    ------
    InputError
        If no phone is asked for, the features do not fit the graph's, or a phone is known neither to the graph nor to
        the table of articulation.

    Examples
    --------
    >>> from mien.motion.graph.graph import RecordedChain, build_graph
    >>> from mien.motion.graph.query import spoken_phones
    >>> from mien.core.timeline import FrameRate, Interval, Tier
    >>> rate, tier = FrameRate.of(100), Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.2, 0.4, "M")))
    >>> take = RecordedChain("one", tier, "neutral", np.zeros((40, 9)), rate, np.zeros((40, 3)), rate)
    >>> index = GraphIndex(build_graph([take], markers=1))
    >>> way = search(index, spoken_phones(tier, np.zeros((40, 9)), rate))
    >>> way.nodes.tolist(), way.cost.jumps, way.cost.total
    ([0, 1], 0, 0.0)
    """
    weights = weights or SearchWeights()
    nodes, effort = cheapest_nodes(candidates_for(index, asked, weights))
    return describe_way(index, asked, weights, nodes, effort)


def describe_way(
    index: GraphIndex, asked: SpokenPhones, weights: SearchWeights, nodes: Whole, effort: Effort
) -> FoundWay:
    """What there is to say of a way given by its nodes."""
    jumps = np.zeros(len(nodes), dtype=bool)
    jumps[1:] = (nodes[1:] != nodes[:-1] + 1) | ~index.follows[nodes[1:]]
    cost = path_cost(index.graph, asked, weights, nodes)
    return FoundWay(nodes, jumps, cost, substitutions_in(index.graph, asked, nodes), effort)


def cheapest_nodes(candidates: Candidates) -> tuple[Whole, Effort]:
    """Nodes of the cheapest way among candidates, and what finding them took."""
    states = _States.of(candidates)
    every = len(states.nodes)
    states.bound()
    states.drop(states.known_cost())
    states.hear(states.short)
    states.bound()
    most = states.known_cost()
    states.drop(most)
    if states.weighs_long and len(states.nodes) < FEW * every:
        states.bound_with_joins(most)
    heard = len(states.nodes)
    states.hear(~states.short)
    states.bound()
    most = states.known_cost()
    states.drop(most)
    path, weighed = states.cheapest(most)
    return states.nodes[path].astype(np.int64), Effort(every, heard, len(states.nodes), weighed)


class _States:
    """The states that are left, and what is known of them."""

    def __init__(self, candidates: Candidates, nodes: Whole32, offsets: Whole, costs: Floats) -> None:
        self.candidates, self.nodes, self.offsets, self.costs = candidates, nodes, offsets, costs
        self.index, weights = candidates.index, candidates.weights
        self.recorded = self.index.recorded_joins(weights.join if weights.join_everywhere else 0.0)
        self.bounds = np.empty(0)
        asked = candidates.asked
        self.short = np.array([len(rows) < LONG for rows in asked.features]) & (np.array(asked.phones) != PAUSE)
        self._unheard = np.array([weights.audio_of(phone) for phone in asked.phones])

    @classmethod
    def of(cls, candidates: Candidates) -> _States:
        """All states, at what they cost without their audio."""
        offsets = np.cumsum([0, *(len(nodes) for nodes in candidates.lists)])
        costs = np.zeros(offsets[-1])
        if candidates.has_other_costs:
            for step in range(len(candidates.lists)):
                costs[offsets[step] : offsets[step + 1]] = candidates.other_costs(step)
        return cls(candidates, np.concatenate(candidates.lists), offsets, costs)

    def _run(self, kernel: Any, *further: Any) -> Any:
        """Call a kernel with what all of them need first."""
        jump = self.candidates.weights.jump
        return kernel(self.nodes, self.offsets, self.costs, self.index.follows, self.recorded, jump, *further)

    def bound(self) -> None:
        self.bounds = np.empty(len(self.nodes))
        self._run(backward_bounds, self.bounds)

    def known_cost(self) -> float:
        """Cost of a way that a beam finds, and a little more."""
        path = np.empty(len(self.offsets) - 1, dtype=np.int64)
        index, weights = self.index, self.candidates.weights
        self._run(beam, weights.join, index.exits, index.entries, self.bounds, WIDTH, path)
        nodes = self.nodes[path]
        apart = np.sqrt(((index.exits[nodes[:-1]] - index.entries[nodes[1:]]) ** 2).sum(axis=1))
        along = (nodes[1:] == nodes[:-1] + 1) & index.follows[nodes[1:]]
        steps = np.where(along, self.recorded[nodes[1:]], weights.jump + weights.join * apart)
        cost = float(self.costs[path].sum() + steps.sum(dtype=np.float64))
        cost += float(self.candidates.audio_costs(nodes, np.arange(len(nodes) + 1), self._unheard).sum())
        return cost * (1 + ROUNDING) + ROUNDING

    def bound_with_joins(self, most: float) -> None:
        """Keep what the best known way could pass when joins are counted; ``most`` is the cost of one."""
        before, after = np.empty(len(self.nodes)), np.empty(len(self.nodes))
        index, join = self.index, self.candidates.weights.join
        self._run(join_bounds, join, index.exits, index.entries, index.exit_order, self.bounds, most, before, after)
        whole = before + after
        self.bounds = after
        self._keep(whole <= most)
        self._keep(whole[whole <= most] <= self.known_cost())  # led by these bounds the beam finds a better way

    def drop(self, most: float) -> None:
        """Keep what a way of cost ``most`` could pass."""
        kept = np.empty(len(self.nodes), dtype=bool)
        self._run(within, self.bounds, most, kept)
        self._keep(kept)

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        running = np.concatenate([[0], np.cumsum(kept)])
        self.nodes, self.costs, self.bounds = self.nodes[kept], self.costs[kept], self.bounds[kept]
        self.offsets = running[self.offsets]

    def hear(self, phones: NDArray[np.bool_]) -> None:
        """Add the audio distances of some phones to the costs."""
        self.costs += self.candidates.audio_costs(self.nodes, self.offsets, np.where(phones, self._unheard, 0.0))
        self._unheard = np.where(phones, 0.0, self._unheard)

    @property
    def weighs_long(self) -> bool:
        """Whether the audio of a long phone still counts for something."""
        return bool((self._unheard > 0).any())

    def cheapest(self, most: float) -> tuple[Whole, int]:
        path = np.empty(len(self.offsets) - 1, dtype=np.int64)
        index, join = self.index, self.candidates.weights.join
        cost, weighed = self._run(
            cheapest_way, join, index.exits, index.entries, index.exit_order, self.bounds, most, path
        )
        if not np.isfinite(cost):
            raise RuntimeError("no way was left within the cost of a way that is known: a fault in the search")
        return path, int(weighed)
