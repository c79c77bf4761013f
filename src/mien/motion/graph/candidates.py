"""Which nodes may stand at each phone, and what each of them costs there on its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.motion.graph.audio_distance import hear_all
from mien.motion.graph.costs import SHORTEST, SearchWeights
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.query import SpokenPhones
from mien.motion.graph.standing_in import stand_ins

__all__ = ["Candidates", "GraphIndex", "candidates_for"]

Floats32 = NDArray[np.float32]
Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Whole32 = NDArray[np.int32]

CURVE_AXES = 4
CURVE_BITS = 12


class GraphIndex:
    """A graph made ready for searching, once for all searches.

    Parameters
    ----------
    graph : AnimeGraph

    Attributes
    ----------
    graph : AnimeGraph
    entries, exits : ndarray of float32, shape (nodes, dimensions)
        Poses scaled so that their Euclidean distance is the RMS over markers, mm.
    log_durations : ndarray of float64, shape (nodes,)
    nodes_of : dict of str to ndarray of int32
        Nodes of each phone, rising.
    follows : ndarray of bool, shape (nodes,)
        Whether a node is the recorded successor of the one before it.
    recorded : frozenset of (phone, emotion)
    exit_order : ndarray of int32, shape (nodes,)
        Place of each node along a curve that winds through the space of exit poses, so that nodes near each other on
        it have like poses.

    Raises
    ------
    InputError
        If the graph is empty or has more nodes than 2^31 - 1.
    """

    def __init__(self, graph: AnimeGraph) -> None:
        if not 0 < len(graph) < 2**31 - 1:
            raise InputError(f"a graph to search in has at least one node and fewer than 2^31, not {len(graph)}")
        self.graph = graph
        scale = np.float32(1 / np.sqrt(graph.markers))
        self.entries = np.ascontiguousarray(graph.entries * scale)
        self.exits = np.ascontiguousarray(graph.exits * scale)
        self.log_durations = np.log(np.maximum(graph.durations.astype(np.float64), SHORTEST))
        self.follows = graph.follows
        order = np.argsort(graph.phones, kind="stable").astype(np.int32)
        bounds = np.searchsorted(graph.phones[order], np.arange(len(graph.symbols) + 1))
        groups = {symbol: order[bounds[k] : bounds[k + 1]] for k, symbol in enumerate(graph.symbols)}
        self.nodes_of = {symbol: nodes for symbol, nodes in groups.items() if len(nodes)}
        heard = graph.phones.astype(np.int64) * len(graph.emotion_names) + graph.emotions
        pairs = np.flatnonzero(np.bincount(heard))
        self.recorded = frozenset(
            (graph.symbols[pair // len(graph.emotion_names)], graph.emotion_names[pair % len(graph.emotion_names)])
            for pair in pairs
        )
        self.exit_order = _along_a_curve(self.exits)

    def recorded_joins(self, weight: float) -> Floats32:
        """What going on along the recording to each node costs: the distance to it in mm, times a weight."""
        joins = np.zeros(len(self.follows), dtype=np.float32)
        if weight > 0:
            after = np.flatnonzero(self.follows)
            joins[after] = weight * np.sqrt(((self.exits[after - 1] - self.entries[after]) ** 2).sum(axis=1))
        return joins


def _along_a_curve(poses: Floats32) -> Whole32:
    """Rank of each pose on a Z-order curve through the axes along which poses differ most."""
    axes = np.argsort(-poses.var(axis=0), kind="stable")[:CURVE_AXES]
    code = np.zeros(len(poses), dtype=np.int64)
    for place, axis in enumerate(axes):
        values = poses[:, axis].astype(np.float64)
        low, high = float(values.min()), float(values.max())
        steps = ((values - low) / max(high - low, 1e-12) * ((1 << CURVE_BITS) - 1)).astype(np.int64)
        for bit in range(CURVE_BITS):
            code |= ((steps >> bit) & 1) << (bit * len(axes) + len(axes) - 1 - place)
    rank = np.empty(len(poses), dtype=np.int32)
    rank[np.argsort(code, kind="stable")] = np.arange(len(poses), dtype=np.int32)
    return rank


@dataclass(frozen=True, eq=False)
class Candidates:
    """The nodes that may stand at each phone.

    Attributes
    ----------
    index : GraphIndex
    asked : SpokenPhones
    weights : SearchWeights
    lists : tuple of ndarray of int32
        Nodes for each phone, rising.
    """

    index: GraphIndex
    asked: SpokenPhones
    weights: SearchWeights
    lists: tuple[Whole32, ...]
    _wanted: tuple[int, ...] = field(repr=False)

    def nodes(self, step: int) -> Whole32:
        """Nodes that may stand at a phone."""
        return self.lists[step]

    def other_costs(self, step: int, nodes: Whole32 | None = None) -> Floats:
        """Weighted cost of length and emotion of nodes (default: all) at a phone."""
        nodes = self.lists[step] if nodes is None else nodes
        costs = np.zeros(len(nodes))
        if self.weights.duration > 0:
            asked = np.log(max(self.asked.durations[step], SHORTEST))
            costs += self.weights.duration * np.abs(self.index.log_durations[nodes] - asked)
        if self._soft and self.asked.emotions is not None:
            costs += self.weights.emotion * (self.index.graph.emotions[nodes] != self._wanted[step])
        return costs

    @property
    def _soft(self) -> bool:
        return self.weights.emotion > 0 and not self.weights.emotion_is_filter

    @property
    def has_other_costs(self) -> bool:
        """Whether length or emotion cost anything."""
        return self.weights.duration > 0 or (self._soft and self.asked.emotions is not None)

    def audio_costs(self, nodes: Whole32, offsets: Whole, weights: Floats | None = None) -> Floats:
        """Weighted audio distances of nodes that stand at phone ``k`` from ``offsets[k]`` to ``offsets[k + 1]``."""
        graph, asked = self.index.graph, self.asked
        if weights is None:
            weights = np.array([self.weights.audio_of(phone) for phone in asked.phones])
        costs = np.zeros(len(nodes))
        heard = np.concatenate(asked.features)
        ends = np.cumsum([0, *(len(rows) for rows in asked.features)])
        hear_all(
            heard, ends, weights, graph.features, graph.feature_starts, graph.feature_counts, nodes, offsets, costs
        )
        return costs


def candidates_for(
    index: GraphIndex, asked: SpokenPhones, weights: SearchWeights, fixed: Sequence[int] = ()
) -> Candidates:
    """Nodes for each phone.

    Parameters
    ----------
    index : GraphIndex
    asked : SpokenPhones
        At least one phone.
    weights : SearchWeights
    fixed : sequence of int
        Nodes that stand at the first phones, decided already.

    Raises
    ------
    InputError
        If no phone is asked for, the features have another number of coefficients than the graph's, or a phone is
        known neither to the graph nor to the table of articulation.
    """
    if not len(asked):
        raise InputError("no phone to search for")
    coefficients = index.graph.features.shape[1]
    for phone, rows in zip(asked.phones, asked.features, strict=True):
        if rows.shape[1] != coefficients:
            raise InputError(
                f"the graph's audio features have {coefficients} coefficients, those of phone {phone!r} {rows.shape[1]}"
            )
    lists: list[Whole32] = []
    known: dict[tuple[str, str | None], Whole32] = {}
    names = index.graph.emotion_names
    for step, phone in enumerate(asked.phones):
        if step < len(fixed):
            lists.append(np.array([fixed[step]], dtype=np.int32))
            continue
        emotion = asked.emotions[step] if asked.emotions is not None and weights.emotion_is_filter else None
        key = (phone, emotion)
        if key not in known:
            known[key] = _nodes_for(index, phone, emotion)
        lists.append(known[key])
    wanted = asked.emotions or ()
    return Candidates(
        index, asked, weights, tuple(lists), tuple(names.index(name) if name in names else -1 for name in wanted)
    )


def _nodes_for(index: GraphIndex, phone: str, emotion: str | None) -> Whole32:
    taken, felt = stand_ins(phone, emotion, index.recorded)
    parts = [index.nodes_of[name] for name in taken]
    nodes = parts[0] if len(parts) == 1 else np.sort(np.concatenate(parts))
    if felt and emotion is not None:
        number = index.graph.emotion_names.index(emotion)
        nodes = nodes[index.graph.emotions[nodes] == number]
    return nodes
