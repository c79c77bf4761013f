"""The search while speech is still coming in: phones arrive one by one, and a node is settled a few phones later.

This is what Cao et al. 2005 do for speed ("we consider only 3-6 phonemes ahead"); here it is for latency alone. When
``look_ahead`` phones after a phone are known, the cheapest way from the node settled last through all that is known is
found exactly (`search`), and its first node is settled. How much more such a way costs than the cheapest of all stands
in docs/tables/graph_search.md.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.motion.graph.candidates import GraphIndex, candidates_for
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.query import SpokenPhones
from mien.motion.graph.search import Effort, FoundWay, cheapest_nodes, describe_way

__all__ = ["IncrementalSearch", "search_ahead"]


class IncrementalSearch:
    """Settles nodes as phones arrive.

    Parameters
    ----------
    index : GraphIndex
    weights : SearchWeights or None
        None: the paper's.
    look_ahead : int
        Phones that must be known after a phone before its node is settled; 0 settles it at once.

    Attributes
    ----------
    effort : Effort
        Summed over all searches so far.

    Raises
    ------
    InputError
        If the look-ahead is below 0.

    Examples
    --------
    >>> from mien.motion.graph.graph import RecordedChain, build_graph
    >>> from mien.motion.graph.query import spoken_phones
    >>> from mien.core.timeline import FrameRate, Interval, Tier
    >>> rate, tier = FrameRate.of(100), Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.2, 0.4, "M")))
    >>> take = RecordedChain("one", tier, "neutral", np.zeros((40, 9)), rate, np.zeros((40, 3)), rate)
    >>> asked = spoken_phones(tier, np.zeros((40, 9)), rate)
    >>> arriving = IncrementalSearch(GraphIndex(build_graph([take], markers=1)), look_ahead=1)
    >>> [arriving.push(asked.part(k, k + 1)) for k in range(2)], arriving.finish()
    ([(), (0,)], (1,))
    """

    def __init__(self, index: GraphIndex, weights: SearchWeights | None = None, look_ahead: int = 4) -> None:
        if look_ahead < 0:
            raise InputError(f"a look-ahead is a number of phones from 0 up, not {look_ahead}")
        self.index, self.weights, self.look_ahead = index, weights or SearchWeights(), look_ahead
        self.effort = Effort(0, 0, 0, 0)
        self._known: SpokenPhones | None = None  # the phone settled last, if any, and those that wait
        self._settled: list[int] = []  # the node settled last

    def push(self, phones: SpokenPhones) -> tuple[int, ...]:
        """Take further phones; returns the nodes that are settled by them, in order."""
        self._known = phones if self._known is None else _joined(self._known, phones)
        settled: list[int] = []
        while self._known is not None and len(self._known) - len(self._settled) > self.look_ahead:
            way = self._search(len(self._settled) + self.look_ahead + 1)
            node = int(way[len(self._settled)])
            if self._settled:
                self._known = self._known.part(1, len(self._known))
            self._settled = [node]
            settled.append(node)
        return tuple(settled)

    def finish(self) -> tuple[int, ...]:
        """Settle the phones that wait: nothing comes after them. The next phone pushed begins a new utterance."""
        rest: tuple[int, ...] = ()
        if self._known is not None and len(self._known) > len(self._settled):
            rest = tuple(int(node) for node in self._search(len(self._known))[len(self._settled) :])
        self._known, self._settled = None, []
        return rest

    def _search(self, count: int) -> NDArray[np.int64]:
        if self._known is None:
            raise InputError("no phone was pushed")
        asked = self._known.part(0, count)
        nodes, effort = cheapest_nodes(candidates_for(self.index, asked, self.weights, self._settled))
        self.effort = replace(
            self.effort,
            states=self.effort.states + effort.states,
            heard=self.effort.heard + effort.heard,
            left=self.effort.left + effort.left,
            weighed=self.effort.weighed + effort.weighed,
        )
        return nodes


def search_ahead(
    index: GraphIndex, asked: SpokenPhones, weights: SearchWeights | None = None, look_ahead: int = 4
) -> FoundWay:
    """The way that an `IncrementalSearch` settles for a whole utterance, phone by phone.

    Parameters
    ----------
    index : GraphIndex
    asked : SpokenPhones
    weights : SearchWeights or None
    look_ahead : int
    """
    arriving = IncrementalSearch(index, weights, look_ahead)
    nodes = [node for place in range(len(asked)) for node in arriving.push(asked.part(place, place + 1))]
    nodes += arriving.finish()
    return describe_way(index, asked, arriving.weights, np.array(nodes, dtype=np.int64), arriving.effort)


def _joined(before: SpokenPhones, after: SpokenPhones) -> SpokenPhones:
    if (before.emotions is None) != (after.emotions is None):
        raise InputError("either every phone comes with an emotion, or none does")
    emotions = None if before.emotions is None or after.emotions is None else before.emotions + after.emotions
    return SpokenPhones(
        before.phones + after.phones, before.features + after.features, before.durations + after.durations, emotions
    )
