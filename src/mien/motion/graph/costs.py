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

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.utterance import PAUSE
from mien.motion.graph.audio_distance import hear_all
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.query import SpokenPhones

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
    nodes = np.asarray(nodes, dtype=np.int64)
    before, after = nodes[:-1], nodes[1:]
    jumps = (after != before + 1) | (graph.chains[before] != graph.chains[after])
    apart = graph.exits[before].astype(np.float64) - graph.entries[after]
    rms = np.sqrt((apart**2).sum(axis=1) / graph.markers)
    join = float(rms.sum() if weights.join_everywhere else rms[jumps].sum())
    heard = _heard(graph, asked, nodes)
    audio = float((heard * [weights.audio_of(phone) for phone in asked.phones]).sum())
    lengths = np.maximum(graph.durations[nodes].astype(np.float64), SHORTEST)
    duration = float(np.abs(np.log(lengths / np.maximum(asked.durations, SHORTEST))).sum())
    felt = [graph.emotion_names[number] for number in graph.emotions[nodes]]
    other = sum(name != wanted for name, wanted in zip(felt, asked.emotions or felt, strict=True))
    soft = 0.0 if weights.emotion_is_filter else weights.emotion
    total = weights.jump * int(jumps.sum()) + weights.join * join + audio + weights.duration * duration + soft * other
    return PathCost(float(total), int(jumps.sum()), join, float(heard.sum()), duration, other)


def _heard(graph: AnimeGraph, asked: SpokenPhones, nodes: Whole) -> NDArray[np.float64]:
    """Audio distance of each node from its phone."""
    distances = np.zeros(len(nodes))
    ends = np.cumsum([0, *(len(rows) for rows in asked.features)])
    hear_all(
        np.concatenate(asked.features), ends, np.ones(len(nodes)),
        graph.features, graph.feature_starts, graph.feature_counts,
        nodes.astype(np.int32), np.arange(len(nodes) + 1), distances,
    )  # fmt: skip
    return distances
