"""What recordings know beyond a smooth model: its residuals, averaged over the nodes of the graph that fit best.

A smooth model of the mouth (`SpeechMotion`) is predicted from phones and their lengths; what each recorded phone did
beside that prediction is its *residual*. For a phone that is said, the residuals of all nodes of that phone are
averaged, each weighed by how well it fits::

    w_j = exp(-d_j / 2)
    d_j = audio² · mean squared difference of the audio features at five points of the phone
        + duration² · (ln of the ratio of the lengths)²
        + near · (neighbours that differ) + far · (neighbours of neighbours that differ)
    residual = Σ w_j r_j / (Σ w_j + doubt)

Averaging over many nodes, not taking the one that fits best, keeps what repetitions share and drops what was chance
(a kernel regression, Nadaraya 1964, Watson 1964). Where the stretch was recorded the weights are large and the
recordings speak; where it was not they are small against ``doubt`` and the smooth model is left alone. Which weights
are best is learned: each take is told from the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.graph.compact import snapped, steps_for
from mien.motion.graph.felt_takes import NEUTRAL, labels_of
from mien.motion.graph.graph import AnimeGraph, frame_spans
from mien.motion.graph.smoothing import low_passed
from mien.motion.graph.sound import SOUND_RATE

__all__ = ["POINTS", "FitWeights", "RecordedResiduals"]

POINTS = np.linspace(0.0, 1.0, 5)
"""Where in a phone residuals and sound are looked at, as shares of its length."""
LATE = 0.02
"""Seconds by which features come late (`mien.speech.rasta_plp`)."""
SHORTEST = 0.02
SAMPLE = 1000
"""Nodes on which weights are tried in learning."""
GRID_RATE = 100.0
CUT_OFF = 10.0
"""Hz: the averaged residual is smoothed, as its points are joined by straight lines."""

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Floats32 = NDArray[np.float32]


@dataclass(frozen=True)
class FitWeights:
    """How much each difference counts against a node; see the module. None is below 0.

    Attributes
    ----------
    audio, duration, near, far, doubt : float
    """

    audio: float = 2.0
    duration: float = 2.0
    near: float = 3.0
    far: float = 0.7
    doubt: float = 1.0


_TRIED = {
    "audio": (0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0),
    "duration": (0.5, 1.0, 2.0, 4.0),
    "near": (0.5, 1.0, 2.0, 3.0, 5.0),
    "far": (0.0, 0.5, 1.0, 2.0),
    "doubt": (0.1, 0.3, 1.0, 3.0, 10.0),
}


@dataclass(frozen=True, eq=False)
class _Apart:
    """How nodes differ from a phone that is said, before the weights: arrays of one entry for each."""

    nodes: Whole
    audio: Floats
    duration: Floats
    near: Whole
    far: Whole


@dataclass(frozen=True, eq=False)
class _Said:
    """A phone as it is looked for."""

    phone: str
    company: NDArray[np.int64]
    log_length: float
    heard: Floats | None
    emotion: int


class RecordedResiduals:
    """Residuals of the nodes of a graph.

    Parameters
    ----------
    graph : AnimeGraph

    Attributes
    ----------
    residuals_ : ndarray of float32, shape (nodes, 5, components)
        Snapped to small steps (`compact`).
    steps_ : ndarray of float32, shape (components,)
    weights_, deaf_weights_ : FitWeights
        Where there is sound, and where there is none.
    """

    def __init__(self, graph: AnimeGraph) -> None:
        self.graph = graph
        self._nodes = {symbol: np.flatnonzero(graph.phones == k) for k, symbol in enumerate(graph.symbols)}
        self._numbers = {symbol: k for k, symbol in enumerate(graph.symbols)}
        self._company = _company(graph.phones.astype(np.int64), graph.take_of)
        self._log_lengths = np.log(np.maximum(graph.durations.astype(np.float64), SHORTEST))
        lengths = graph.durations.astype(np.float64)
        rows = np.rint((lengths[:, None] * POINTS + LATE) * graph.feature_rate).astype(np.int64)
        self._sound_rows = np.minimum(graph.feature_starts[:, None] + rows, len(graph.features) - 1)

    def instants(self) -> Floats:
        """Seconds of each node's take at which residuals are wanted, shape (nodes, 5)."""
        graph = self.graph
        return np.asarray(graph.starts[:, None] + POINTS * graph.durations[:, None], dtype=np.float64)

    def restore(self, residuals: Floats32, steps: Floats32, weights: FitWeights, deaf_weights: FitWeights) -> Self:
        """Take residuals at `instants`, shape (nodes, 5, components), and weights that were made before."""
        self.residuals_, self.steps_, self.weights_, self.deaf_weights_ = residuals, steps, weights, deaf_weights
        return self

    def fit(self, residuals: Floats, seed: int = 0) -> Self:
        """Learn which weights tell the residuals of a take best from those of the others, with sound and without."""
        steps = steps_for(residuals, np.int8)
        self.restore(snapped(residuals, steps, np.int8), steps, FitWeights(), FitWeights(audio=0.0))
        spoken = np.flatnonzero(self.graph.phones != self._numbers.get(PAUSE, -1))
        if not len(spoken) or len(self.graph.takes) < 2:
            return self
        random = np.random.default_rng(seed)
        sample = np.sort(random.choice(spoken, min(SAMPLE, len(spoken)), replace=False))
        apart = [self._apart_from_others(int(node)) for node in sample]

        def left_over(weights: FitWeights) -> float:
            told = [self._averaged(differences, weights) for differences in apart]
            return float(np.mean((self.residuals_[sample] - told) ** 2))

        self.weights_ = _descended(self.weights_, left_over, tuple(_TRIED))
        without = replace(self.weights_, audio=0.0)
        self.deaf_weights_ = _descended(without, left_over, tuple(name for name in _TRIED if name != "audio"))
        return self

    def _apart_from_others(self, node: int) -> _Apart:
        """How a node differs from the nodes of its phone in the other takes."""
        said = _Said(
            self.graph.symbols[self.graph.phones[node]],
            self._company[node],
            float(self._log_lengths[node]),
            self.graph.features[self._sound_rows[node]].astype(np.float64),
            int(self.graph.emotions[node]),
        )
        nodes = self._nodes_for(said)
        return self._apart(said, nodes[self.graph.take_of[nodes] != self.graph.take_of[node]])

    def _apart(self, said: _Said, nodes: Whole) -> _Apart:
        differ = self._company[nodes] != said.company
        squares = np.zeros(len(nodes))
        if said.heard is not None:
            heard = self.graph.features[self._sound_rows[nodes]]
            squares = ((heard - said.heard) ** 2).mean(axis=(1, 2))
        lengths = (self._log_lengths[nodes] - said.log_length) ** 2
        return _Apart(nodes, squares, lengths, differ[:, 1:3].sum(axis=1), differ[:, [0, 3]].sum(axis=1))

    def _averaged(self, apart: _Apart, weights: FitWeights) -> Floats:
        """Averaged residual of one phone, shape (5, components)."""
        distance = weights.audio**2 * apart.audio + weights.duration**2 * apart.duration
        fits = np.exp(-(distance + weights.near * apart.near + weights.far * apart.far) / 2)
        return np.asarray(np.tensordot(fits, self.residuals_[apart.nodes], axes=1) / (fits.sum() + weights.doubt))

    def _nodes_for(self, said: _Said) -> Whole:
        """Nodes of a phone in the emotion asked for; where it was not recorded so, neutral ones."""
        nodes = self._nodes.get(said.phone, np.zeros(0, dtype=np.int64))
        if len(self.graph.emotion_names) < 2:
            return nodes
        felt = self.graph.emotions[nodes]
        if not (felt == said.emotion).any() and NEUTRAL in self.graph.emotion_names:
            return np.asarray(nodes[felt == self.graph.emotion_names.index(NEUTRAL)])
        return np.asarray(nodes[felt == said.emotion])

    def at(self, phones: Tier, times: Floats, features: Floats | None, felt: Tier | None = None) -> Floats:
        """Averaged residual at given times, shape (frames, components).

        Parameters
        ----------
        phones : Tier
            Without gaps, covering the times.
        times : ndarray, shape (frames,)
            Seconds.
        features : ndarray, shape (feature frames, coefficients), or None
            Audio features of the utterance; None leaves the sound out.
        felt : Tier or None
            Where which emotion is asked for.
        """
        return self.curve(phones, float(times.min()), float(times.max()), features, felt)(times)

    def curve(
        self, phones: Tier, first: float, last: float, features: Floats | None, felt: Tier | None = None
    ) -> Callable[[Floats], Floats]:
        """`at` for any times from ``first`` to ``last``: what is looked for is found once."""
        weights = self.weights_ if features is not None else self.deaf_weights_
        knots, values = [], []
        for said, phone in zip(self._asked(phones, features, felt), phones, strict=True):
            knots.append(phone.start + POINTS * phone.duration)
            values.append(self._averaged(self._apart(said, self._nodes_for(said)), weights))
        curve = np.array(values)
        values.clear()
        middle = (curve[1:, 0] + curve[:-1, -1]) / 2  # where phones meet their two answers are averaged
        curve[1:, 0], curve[:-1, -1] = middle, middle
        begin = np.floor(first * GRID_RATE)
        grid = (begin + np.arange(np.ceil(last * GRID_RATE) - begin + 1)) / GRID_RATE
        at, flat = np.concatenate(knots), curve.reshape(-1, curve.shape[2])
        joined = np.empty((len(grid), flat.shape[1]))
        for number, column in enumerate(flat.T):  # an hour is not held many times over
            joined[:, number] = np.interp(grid, at, column)
        del curve, flat
        smooth = low_passed(joined, GRID_RATE, np.full(joined.shape[1], CUT_OFF))
        return lambda times: np.stack([np.interp(times, grid, column) for column in smooth.T], axis=1)

    def _asked(self, phones: Tier, features: Floats | None, felt: Tier | None) -> list[_Said]:
        names = self.graph.emotion_names
        emotions = labels_of(phones, felt, names) or (names[0],) * len(phones)
        numbers = np.array([self._numbers.get(phone.label, -2) for phone in phones])
        company = _company(numbers, np.zeros(len(numbers), dtype=np.int32))
        starts = frame_spans(phones, SOUND_RATE, len(features))[:, 0] if features is not None else None
        asked = []
        for place, phone in enumerate(phones):
            heard = None
            if features is not None and starts is not None:
                rows = starts[place] + np.rint((phone.duration * POINTS + LATE) * SOUND_RATE.fps).astype(np.int64)
                heard = features[np.minimum(rows, len(features) - 1)]
            length = float(np.log(max(phone.duration, SHORTEST)))
            asked.append(_Said(phone.label, company[place], length, heard, names.index(emotions[place])))
        return asked


def _descended(start: FitWeights, left_over: Callable[[FitWeights], float], names: Sequence[str]) -> FitWeights:
    """The weights that leave least over, one weight at a time, twice through all."""
    best, least = start, left_over(start)
    for _ in range(2):
        for name in names:
            for value in _TRIED[name]:
                tried = replace(best, **{name: value})
                if tried != best and (error := left_over(tried)) < least:
                    best, least = tried, error
    return best


def _company(phones: NDArray[np.int64], takes: NDArray[np.int32]) -> NDArray[np.int64]:
    """Phones two before, before, after and two after each, shape (nodes, 4); -1 where the take has none."""
    result = np.full((len(phones), 4), -1, dtype=np.int64)
    for column, step in enumerate((-2, -1, 1, 2)):
        places = np.arange(len(phones)) + step
        there = (places >= 0) & (places < len(phones))
        there[there] = takes[places[there]] == takes[np.flatnonzero(there)]
        result[there, column] = phones[places[there]]
    return result
