"""A small network beside the influence curves: what they miss, learned from the articulation about each instant.

It sees how much of each articulatory feature (and, held small, of each phone) falls into fifteen spans of time, narrow
about the instant and wide away from it, and gives the components of the pose. Several networks
that differ only in their seed are averaged.
Plain numpy: nothing else is needed to run or to train it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.descent import Adam, going_on

__all__ = ["SPANS", "Correction", "CorrectionSettings", "articulation_about"]

SPANS = (-0.32, -0.2, -0.14, -0.1, -0.07, -0.05, -0.03, -0.01, 0.01, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.32)
"""Seconds from the instant: the borders of the spans."""

Floats = NDArray[np.float64]
Array = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class CorrectionSettings:
    """How the correction is learned.

    Attributes
    ----------
    hidden : tuple of int
        Units in each hidden layer.
    networks : int
        How many are averaged.
    lead : float
        Seconds by which the mouth runs ahead of the sound.
    phone_weight : float
        Scale at which a phone itself is seen beside its articulation; 0 hides it.
    dropout : float
        Share of hidden units left out in each step of learning.
    decay : float
        Pull of the weights towards 0.
    epochs, batch, rate, seed
        As in `InfluenceSettings`.
    """

    hidden: tuple[int, ...] = (192, 96)
    networks: int = 2
    lead: float = 0.02
    phone_weight: float = 0.25
    dropout: float = 0.25
    decay: float = 1e-4
    epochs: int = 14
    batch: int = 512
    rate: float = 2e-3
    seed: int = 0


def articulation_about(phones: Tier, times: Floats, phone_weight: float) -> Floats:
    """Mean of each feature in each span about each instant, shape (frames, spans * columns).

    Columns are the articulatory features, then one for each part's symbol, times ``phone_weight`` (left out at 0).
    Before the first phone and after the last one there is a pause.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> seen = articulation_about(Tier("phones", (Interval(0.0, 1.0, "M"),)), np.array([0.5]), 0.0)
    >>> table = articulation_table()
    >>> bool(np.allclose(seen.reshape(len(SPANS) - 1, -1), table.values[table.parts["M"][0]]))
    True
    """
    table = articulation_table()
    values = table.values
    if phone_weight:
        values = np.concatenate([values, np.eye(len(table.symbols)) * phone_weight], axis=1)
    parts = parts_of(phones)
    pause = table.parts[PAUSE][0]
    first, last = (parts.starts[0], parts.ends[-1]) if len(parts) else (0.0, 0.0)
    early = min(first, float(times.min(initial=first)) + SPANS[0]) - 1.0
    late = max(last, float(times.max(initial=last)) + SPANS[-1]) + 1.0
    borders = np.concatenate([[early], parts.starts, [last, late]])
    held = values[np.concatenate([[pause], parts.symbols, [pause]])]
    total = np.concatenate([np.zeros((1, held.shape[1])), np.cumsum(held * np.diff(borders)[:, None], axis=0)])
    at = times[:, None] + np.array(SPANS)
    place = np.clip(np.searchsorted(borders, at, side="right") - 1, 0, len(held) - 1)
    reached = total[place] + held[place] * (at - borders[place])[..., None]  # integral of the features up to there
    mean = np.diff(reached, axis=1) / np.diff(SPANS)[:, None]
    return np.asarray(mean.reshape(len(times), mean.shape[1] * mean.shape[2]))


class Correction:
    """Networks from the articulation about an instant to the components of the pose there.

    Parameters
    ----------
    settings : CorrectionSettings

    Attributes
    ----------
    layers_ : list of list of (weights, bias)
        For each network its layers; weights of shape (inputs, outputs).
    """

    def __init__(self, settings: CorrectionSettings | None = None) -> None:
        self.settings = settings or CorrectionSettings()

    def describe(self, phones: Tier, times: Floats) -> Floats:
        """What the networks see, shape (frames, inputs)."""
        return articulation_about(phones, times + self.settings.lead, self.settings.phone_weight)

    def fit(
        self,
        seen: Floats,
        components: Floats,
        after_epoch: Callable[[], None] = lambda: None,
        start: Correction | None = None,
    ) -> Self:
        """Learn from `describe` and the components of the same frames.

        ``start``: networks from which to go on, and to which they are held (`mien.motion.mouth.descent.going_on`).
        """
        scale = float(components.std(axis=0).max()) or 1.0
        inputs, wanted = seen.astype(np.float32), (components / scale).astype(np.float32)
        self.layers_: list[list[tuple[Array, Array]]] = []
        for number in range(self.settings.networks):
            random = np.random.default_rng([self.settings.seed, number])
            begun = None
            if start is not None:
                begun = [(w.astype(np.float32), b.astype(np.float32)) for w, b in start.layers_[number]]
                begun[-1] = (begun[-1][0] / np.float32(scale), begun[-1][1] / np.float32(scale))
            layers = self._train(inputs, wanted, random, after_epoch, begun)
            layers[-1] = (layers[-1][0] * np.float32(scale), layers[-1][1] * np.float32(scale))
            self.layers_.append([(w.astype(np.float64), b.astype(np.float64)) for w, b in layers])
        return self

    def components(self, seen: Floats) -> Floats:
        """Mean answer of the networks, shape (frames, components)."""
        answers = [_forward(layers, seen)[-1] for layers in self.layers_]
        return np.asarray(np.mean(answers, axis=0))

    def _train(
        self,
        inputs: Array,
        wanted: Array,
        random: np.random.Generator,
        after_epoch: Callable[[], None],
        begun: list[tuple[Array, Array]] | None,
    ) -> list[tuple[Array, Array]]:
        sizes = [inputs.shape[1], *self.settings.hidden, wanted.shape[1]]
        layers: list[tuple[Array, Array]] = list(begun or ())
        for entering, leaving in pairwise(sizes if begun is None else ()):
            spread = np.sqrt(2 / entering) * (0.3 if leaving == sizes[-1] else 1.0)
            weights = (random.standard_normal((entering, leaving)) * spread).astype(np.float32)
            layers.append((weights, np.zeros(leaving, np.float32)))
        batch, epochs = self.settings.batch, self.settings.epochs
        weights_and_biases = [array for layer in layers for array in layer]
        anchors = [array.copy() for array in weights_and_biases]
        passes, rate, pull = 1, self.settings.rate, 0.0
        if begun is not None:
            passes, rate, pull = going_on(len(inputs), batch, epochs, rate)
        adam = Adam(weights_and_biases, rate, epochs * passes * -(-len(inputs) // batch))
        for _ in range(epochs):
            for _ in range(passes):
                order = random.permutation(len(inputs))
                for rows in np.split(order, range(batch, len(order), batch)):
                    slopes = self._slopes(layers, inputs[rows], wanted[rows], random)
                    if begun is not None:
                        for slope, now, then in zip(slopes, weights_and_biases, anchors, strict=True):
                            slope += np.float32(pull) * (now - then)
                    adam.step(slopes)
            after_epoch()
        return layers

    def _slopes(
        self, layers: list[tuple[Array, Array]], inputs: Array, wanted: Array, random: np.random.Generator
    ) -> list[Array]:
        """Slopes of half the mean squared error on weights and biases, in order."""
        dropout = self.settings.dropout
        kept = [
            (random.random((len(inputs), len(bias)), dtype=np.float32) >= dropout) / np.float32(1 - dropout)
            for _, bias in layers[:-1]
        ]
        passed = _forward(layers, inputs, kept)
        back: Array = (passed[-1] - wanted) / np.float32(len(wanted))
        slopes: list[Array] = []
        for place in range(len(layers) - 1, -1, -1):
            weights, _ = layers[place]
            slopes[:0] = [passed[place].T @ back + np.float32(self.settings.decay) * weights, back.sum(axis=0)]
            if place:
                back = (back @ weights.T) * kept[place - 1] * (passed[place] > 0)
        return slopes


def _forward(layers: Sequence[tuple[Array, Array]], inputs: Array, kept: Sequence[Array] | None = None) -> list[Array]:
    """What enters each layer, and at the end what comes out."""
    passed = [inputs]
    for place, (weights, bias) in enumerate(layers):
        value = passed[-1] @ weights + bias
        if place < len(layers) - 1:
            value = np.maximum(value, 0)
            if kept is not None:
                value = value * kept[place]
        passed.append(value)
    return passed
