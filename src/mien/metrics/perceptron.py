"""A perceptron with one hidden layer, in plain numpy: a baseline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.corpus.take import Take
from mien.metrics.baselines import learned_frames
from mien.metrics.context import PhoneContext

__all__ = ["Perceptron"]

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


class Perceptron:
    """One hidden layer of rectified units from the phones about a frame to the markers.

    Trained with Adam (Kingma, Ba 2015) on the mean squared error, weights drawn as in Glorot, Bengio 2010.

    Parameters
    ----------
    units : int
        Of the hidden layer.
    reach : float
        Seconds of context to each side.
    epochs, batch : int
        Passes over the frames, and frames in a step.
    rate : float
        Step size at the start; it falls to zero in a straight line.
    decay : float
        Penalty on the squared weights.
    seed : int
        Of the first weights and of the order of frames.
    """

    def __init__(
        self,
        units: int = 256,
        reach: float = 0.32,
        epochs: int = 30,
        batch: int = 200,
        rate: float = 1e-3,
        decay: float = 1e-4,
        seed: int = 0,
    ) -> None:
        self.units, self.reach, self.epochs, self.batch = units, reach, epochs, batch
        self.rate, self.decay, self.seed = rate, decay, seed

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn the weights."""
        self.context_ = PhoneContext(self.reach).fit([take.phones for take in takes])
        times, flat = learned_frames(takes)
        code = np.concatenate([self.context_.encode(k.phones, t) for k, t in zip(takes, times, strict=True)])
        self.mean_, self.scale_ = flat.mean(axis=0), float(flat.std(axis=0).mean()) or 1.0
        targets = ((flat - self.mean_) / self.scale_).astype(np.float32)
        random = np.random.default_rng(self.seed)
        self.layers_ = self._first_layers(random, targets.shape[1])
        self._train(random, code, targets)
        return self

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """Positions at the given times."""
        hidden, _ = self._hidden(self._sparse(self.context_.encode(phones, times)))
        scaled: Array = (hidden @ self.layers_[2] + self.layers_[3]).astype(np.float64)
        flat: Array = scaled * self.scale_ + self.mean_
        return flat.reshape(len(times), -1, 3)

    def _first_layers(self, random: np.random.Generator, outputs: int) -> list[Floats]:
        sizes = ((self.context_.width, self.units), (self.units, outputs))
        layers: list[Floats] = []
        for rows, columns in sizes:
            bound = np.sqrt(6.0 / (rows + columns))
            layers += [
                random.uniform(-bound, bound, (rows, columns)).astype(np.float32),
                np.zeros(columns, dtype=np.float32),
            ]
        return layers

    def _sparse(self, code: NDArray[np.int64]) -> Any:
        from scipy.sparse import csr_array

        known = code >= 0
        ends = np.concatenate([[0], np.cumsum(known.sum(axis=1))])
        shape = (len(code), self.context_.width)
        return csr_array((np.ones(int(known.sum()), dtype=np.float32), code[known], ends), shape=shape)

    def _hidden(self, inputs: Any) -> tuple[Floats, NDArray[np.bool_]]:
        before = inputs @ self.layers_[0] + self.layers_[1]
        return np.maximum(before, 0.0), before > 0

    def _gradients(self, inputs: Any, targets: Floats) -> list[Floats]:
        hidden, active = self._hidden(inputs)
        error = (hidden @ self.layers_[2] + self.layers_[3] - targets) / len(targets)
        back = (error @ self.layers_[2].T) * active
        share = np.float32(self.decay / len(targets))
        return [
            inputs.T @ back + share * self.layers_[0],
            back.sum(axis=0),
            hidden.T @ error + share * self.layers_[2],
            error.sum(axis=0),
        ]

    def _train(self, random: np.random.Generator, code: NDArray[np.int64], targets: Floats) -> None:
        inputs = self._sparse(code)
        first = [np.zeros_like(layer) for layer in self.layers_]
        second = [np.zeros_like(layer) for layer in self.layers_]
        steps, step = self.epochs * -(-len(code) // self.batch), 0
        for _ in range(self.epochs):
            order = random.permutation(len(code))
            for start in range(0, len(code), self.batch):
                rows = order[start : start + self.batch]
                step += 1
                size = self.rate * (1 - (step - 1) / steps) * np.sqrt(1 - 0.999**step) / (1 - 0.9**step)
                for place, gradient in enumerate(self._gradients(inputs[rows], targets[rows])):
                    first[place] += np.float32(0.1) * (gradient - first[place])
                    second[place] += np.float32(0.001) * (gradient * gradient - second[place])
                    self.layers_[place] -= np.float32(size) * first[place] / (np.sqrt(second[place]) + np.float32(1e-8))
