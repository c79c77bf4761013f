"""What a way through the Anime Graph costs (Cao et al. 2005, Eq. 2 to 5; B4).

For phones 1..n and nodes a_1..a_n::

    cost = jump · (number of jumps)
         + join · Σ RMS(exit pose of a_i, entry pose of a_i+1)      mm, over the jumps
         + audio · Σ audio distance of a_i                          `audio_distance`
         + duration · Σ |ln(length of a_i / length asked for)|
         + emotion · (number of nodes with another emotion than asked for)

A jump is any pair where a_i+1 is not the recorded successor of a_i. The paper has the first three terms, with weights
100, 1 and 0.01; its prose counts the second at jumps, its Eq. 4 over all pairs (`SearchWeights.join_everywhere`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mien.errors import InputError
from mien.models.anime_graph.audio_distance import distances_to
from mien.models.anime_graph.graph import AnimeGraph
from mien.models.anime_graph.query import SpokenPhones
from mien.speech.utterance import PAUSE

__all__ = ["SHORTEST", "PathCost", "SearchWeights", "path_cost"]

SHORTEST = 0.005
"""Seconds; shorter phones count as this long when lengths are compared."""

Whole = NDArray[np.int64]


@dataclass(frozen=True)
class SearchWeights:
    """Weights of the terms; none may be below 0. The defaults are the paper's.

    Attributes
    ----------
    jump, join, audio, duration, emotion : float
        See the module. `emotion` is a soft cost: it counts only where `emotion_is_filter` is False.
    pause_audio : float
        Share of the audio weight that counts in pauses, 0..1. At 0 what a pause sounds like is not compared.
    join_everywhere : bool
        True: the join term over all pairs, recorded ones too (the paper's Eq. 4, literally).
    emotion_is_filter : bool
        True: where the graph has the phone in the emotion asked for, no other is taken.

    Raises
    ------
    InputError
        If a weight is not a number from 0 up.
    """

    jump: float = 100.0
    join: float = 1.0
    audio: float = 0.01
    duration: float = 0.0
    emotion: float = 0.0
    pause_audio: float = 1.0
    join_everywhere: bool = False
    emotion_is_filter: bool = True

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"the search weight {field.name!r} is a number from 0 up, not {value}")
        if self.pause_audio > 1:
            raise InputError(f"the share of the audio weight in pauses is 0..1, not {self.pause_audio}")

    def audio_of(self, phone: str) -> float:
        """Weight of the audio distance of a phone."""
        return self.audio * self.pause_audio if phone == PAUSE else self.audio


@dataclass(frozen=True)
class PathCost:
    """Cost of a way through the graph, by term, before the weights.

    Attributes
    ----------
    total : float
        With the weights.
    jumps : int
    join : float
        Sum, mm.
    audio : float
        Sum of audio distances (pauses in full, whatever their weight).
    duration : float
        Sum of absolute log ratios.
    other_emotion : int
        Nodes with another emotion than asked for.
    """

    total: float
    jumps: int
    join: float
    audio: float
    duration: float
    other_emotion: int


def path_cost(graph: AnimeGraph, asked: SpokenPhones, weights: SearchWeights, nodes: Whole) -> PathCost:
    """Cost of given nodes, term by term.

    Raises
    ------
    InputError
        If there are not as many nodes as phones.
    """
    if len(nodes) != len(asked):
        raise InputError(f"{len(asked)} phones need as many nodes, not {len(nodes)}")
    chosen = [int(node) for node in nodes]
    jump = [bool(b != a + 1 or graph.chains[a] != graph.chains[b]) for a, b in pairwise(chosen)]
    apart = [graph.exits[a].astype(np.float64) - graph.entries[b] for a, b in pairwise(chosen)]
    rms = [float(np.sqrt((step**2).sum() / graph.markers)) for step in apart]
    join = sum(step for step, counts in zip(rms, jump, strict=True) if counts or weights.join_everywhere)
    heard = [_heard(graph, rows, node) for rows, node in zip(asked.features, chosen, strict=True)]
    audio = sum(weights.audio_of(phone) * value for phone, value in zip(asked.phones, heard, strict=True))
    lengths = np.maximum(graph.durations[chosen].astype(np.float64), SHORTEST)
    duration = float(np.abs(np.log(lengths / np.maximum(asked.durations, SHORTEST))).sum())
    wanted = asked.emotions or tuple(graph.emotion_names[graph.emotions[node]] for node in chosen)
    other = sum(graph.emotion_names[graph.emotions[node]] != name for node, name in zip(chosen, wanted, strict=True))
    soft = 0.0 if weights.emotion_is_filter else weights.emotion
    total = weights.jump * sum(jump) + weights.join * join + audio + weights.duration * duration + soft * other
    return PathCost(float(total), sum(jump), float(join), float(sum(heard)), duration, other)


def _heard(graph: AnimeGraph, rows: NDArray[np.float32], node: int) -> float:
    distance = np.empty(1)
    rows = np.ascontiguousarray(rows, dtype=np.float32)
    distances_to(rows, graph.features, graph.feature_starts, graph.feature_counts, np.array([node], np.int32), distance)
    return float(distance[0])
