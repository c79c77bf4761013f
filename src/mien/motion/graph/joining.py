"""Recorded phones strung together to one motion: warped in time, cross-faded at jumps (Cao et al. 2005, 4.3).

Every said phone shows its node's motion, warped onto it. At a *jump* (the node is not its forerunner's recorded
successor) two phones a, b are joined:

* if two neighbours m, n with the phones of a and b were recorded, their motion, warped onto the two phones, is faded
  in: its weight rises linearly from the start of a to the joint and falls to the end of b. Of several such pairs it is
  the one that begins most like a, ends most like b, and lasts most like the two;
* else what was recorded after a is faded into what was recorded before b and b itself, linearly from the start of a to
  the end of b; where nothing more was recorded the last velocity carries on and dies away.

In one phone the weights of the fades at its two ends and of its own node add up to one, so fades may follow one
another.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.warp import time_map

__all__ = ["Joiner", "RecordedMotion", "joints"]

CARRY = 0.06
"""Seconds in which an extrapolated velocity dies away (to 1/e)."""
LENGTH_WEIGHT = 2.0
"""What a factor e in the length of a helper's phones costs against millimetres, in choosing a helper."""

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


class RecordedMotion:
    """The motion of a graph at any instant of its takes.

    Between frames a cubic through four of them (Catmull and Rom); before the first and after the last frame of an
    unbroken stretch its velocity carries on and dies away.

    Parameters
    ----------
    graph : AnimeGraph
    """

    def __init__(self, graph: AnimeGraph) -> None:
        self.graph = graph
        begins = np.zeros(len(graph.motion) + 1, dtype=bool)
        begins[graph.take_motion] = True
        lost = ~np.isfinite(graph.motion).all(axis=1)
        begins[:-1] |= lost
        begins[1:] |= lost
        edges = np.flatnonzero(begins)
        stretch = np.cumsum(begins[:-1]) - 1
        self._first, self._last = edges[stretch], edges[stretch + 1] - 1

    def at(self, node: int, seconds: Floats) -> Floats:
        """Motion at seconds of the take of a node, in the stretch that holds it; shape (instants, dimensions)."""
        graph = self.graph
        row = int(graph.motion_starts[node])
        first, last = int(self._first[row]), int(self._last[row])
        wanted = graph.take_motion[graph.take_of[node]] + seconds * graph.motion_rate
        inside = np.clip(wanted, first, last)
        before = np.minimum(inside.astype(np.int64), max(last - 1, first))
        share = (inside - before)[:, None]
        rows = np.clip(before[:, None] + np.arange(-1, 3), first, last)
        p, q, r, s = np.moveaxis(np.asarray(graph.motion[rows], dtype=np.float64), 1, 0)
        p = np.where((before == first)[:, None], 2 * q - r, p)
        s = np.where((before + 1 >= last)[:, None], 2 * r - q, s)
        value = q + share / 2 * (r - p + share * (2 * p - 5 * q + 4 * r - s + share * (3 * (q - r) + s - p)))
        beyond = (wanted - inside) / graph.motion_rate
        if beyond.any() and last > first:
            ends = np.array([first, last]), np.array([first + 1, last - 1])
            velocity = np.asarray(graph.motion[ends[0]] - graph.motion[ends[1]], dtype=np.float64) * graph.motion_rate
            carried = CARRY * (1 - np.exp(-np.abs(beyond) / CARRY))
            value += velocity[(beyond > 0).astype(int)] * carried[:, None]
        return np.asarray(value)


def joints(graph: AnimeGraph, nodes: Sequence[int] | Whole) -> NDArray[np.bool_]:
    """Where a path jumps: entry i tells whether node i + 1 of it is not the recorded successor of node i."""
    path = np.asarray(nodes, dtype=np.int64)
    return np.asarray((path[1:] != path[:-1] + 1) | ~graph.follows[path[1:]])


@dataclass(frozen=True, eq=False)
class _Piece:
    """Recorded motion over one said phone: how much it counts at the phone's start and end, and where it lies."""

    weight: tuple[float, float]
    node: int
    said: Floats
    recorded: Floats


class Joiner:
    """Strings nodes together.

    Parameters
    ----------
    graph : AnimeGraph
    evenness : float
        Share of an even warp against dynamic time warping, 0..1 (`warp.time_map`).
    """

    def __init__(self, graph: AnimeGraph, evenness: float = 0.0) -> None:
        self.graph, self.evenness = graph, evenness
        self.motion = RecordedMotion(graph)
        width = len(graph.symbols)
        pairs = np.flatnonzero(graph.follows) - 1
        kinds = graph.phones[pairs].astype(np.int64) * width + graph.phones[pairs + 1]
        order = np.argsort(kinds, kind="stable")
        self._pairs, self._kinds, self._width = pairs[order], kinds[order], width

    def helper(self, before: int, after: int, lengths: tuple[float, float]) -> int | None:
        """First node of the recorded pair that leads best from one node to another; None if there is none.

        Parameters
        ----------
        before, after : int
            Nodes on the two sides of the joint.
        lengths : (float, float)
            Of the two said phones, seconds.
        """
        graph = self.graph
        kind = int(graph.phones[before]) * self._width + int(graph.phones[after])
        first, last = np.searchsorted(self._kinds, [kind, kind + 1])
        found = self._pairs[first:last]
        if not len(found):
            return None
        apart = np.linalg.norm(graph.entries[found] - graph.entries[before], axis=1)
        apart = apart + np.linalg.norm(graph.exits[found + 1] - graph.exits[after], axis=1)
        cost = apart / np.sqrt(graph.markers)
        for step, length in enumerate(lengths):
            ratio = np.maximum(graph.durations[found + step], 1e-3) / max(length, 1e-3)
            cost = cost + LENGTH_WEIGHT * np.abs(np.log(ratio))
        return int(found[cost.argmin()])

    def join(
        self, nodes: Sequence[int] | Whole, phones: Tier, times: Floats, features: Sequence[Floats] | None
    ) -> Floats:
        """The motion of nodes performed as the phones are said.

        Parameters
        ----------
        nodes : sequence of int
            One for each phone.
        phones : Tier
            Without gaps.
        times : ndarray, shape (frames,)
            Seconds; those outside the phones hold the first and the last pose.
        features : sequence of ndarray, or None
            Audio features inside each phone as said; None warps evenly.

        Returns
        -------
        ndarray, shape (frames, dimensions)
            In the space of `AnimeGraph.motion`.
        """
        spans = [(phone.start, phone.end) for phone in phones]
        heard: Sequence[Floats | None] = features if features is not None else [None] * len(spans)
        starts = np.array([start for start, _ in spans])
        held = np.clip(times, spans[0][0], spans[-1][1])
        place = np.clip(np.searchsorted(starts, held, side="right") - 1, 0, len(spans) - 1)
        result = np.zeros((len(times), self.graph.motion.shape[1]))
        jumps = joints(self.graph, nodes)
        for number in np.unique(place):
            frames = np.flatnonzero(place == number)
            start, end = spans[number]
            share = (held[frames] - start) / max(end - start, 1e-9)
            own = np.ones(len(frames))
            for piece in self._fades(int(number), nodes, spans, heard, jumps):
                weight = piece.weight[0] + share * (piece.weight[1] - piece.weight[0])
                result[frames] += weight[:, None] * self._shown(piece, held[frames])
                own -= weight
            if own.any():
                piece = self._warped(nodes[number], spans[number], heard[number], (1.0, 1.0))
                result[frames] += own[:, None] * self._shown(piece, held[frames])
        return result

    def _fades(
        self,
        number: int,
        nodes: Sequence[int] | Whole,
        spans: Sequence[tuple[float, float]],
        heard: Sequence[Floats | None],
        jumps: NDArray[np.bool_],
    ) -> Iterator[_Piece]:
        """What is faded into a phone from the joint at its start and from that at its end."""
        start, end = spans[number]
        for joint in (number - 1, number):
            if not 0 <= joint < len(jumps) or not jumps[joint]:
                continue
            before, after = int(nodes[joint]), int(nodes[joint + 1])
            lengths = [spans[k][1] - spans[k][0] for k in (joint, joint + 1)]
            helper = self.helper(before, after, (lengths[0], lengths[1]))
            late = joint < number  # the phone stands after the joint
            if helper is not None:
                yield self._warped(helper + int(late), spans[number], heard[number], (1.0, 0.0) if late else (0.0, 1.0))
                continue
            whole = max(sum(lengths), 1e-9)
            if late:  # what came after a in its recording, at its own pace
                over = float(self.graph.starts[before] + self.graph.durations[before])
                yield self._paced(before, (start, end), over, (lengths[1] / whole, 0.0))
            else:  # what came before b
                over = float(self.graph.starts[after]) - (end - start)
                yield self._paced(after, (start, end), over, (0.0, lengths[0] / whole))

    def _warped(self, node: int, span: tuple[float, float], said: Floats | None, weight: tuple[float, float]) -> _Piece:
        first = float(self.graph.starts[node])
        recorded = self.graph.features_of(node)
        ends = (first, first + float(self.graph.durations[node]))
        return _Piece(weight, int(node), *time_map(said, recorded, span, ends, self.evenness))

    def _paced(self, node: int, span: tuple[float, float], first: float, weight: tuple[float, float]) -> _Piece:
        return _Piece(weight, node, np.array(span), np.array([first, first + span[1] - span[0]]))

    def _shown(self, piece: _Piece, times: Floats) -> Floats:
        return self.motion.at(piece.node, np.interp(times, piece.said, piece.recorded))
