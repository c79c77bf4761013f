"""Which phone is being said, every 10 ms, from sound that is still coming in.

A small network of our own sees the rows of `streaming_features` about an instant, far into the past and as far into the
future as there is sound yet: it learned with the future cut off at random, so that one network serves every look-ahead.
Plain numpy. Learned by ``tools/live_recogniser`` from synthetic speech and recordings named in NOTICE.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.errors import InputError

__all__ = ["FrameClassifier", "Layer", "default_classifier"]

Single = NDArray[np.float32]
Layer = tuple[Single, Single]
"""Weights, shape (inputs, outputs), and biases."""


@dataclass(frozen=True, eq=False)
class FrameClassifier:
    """The network.

    Attributes
    ----------
    labels : tuple of str
        Phones and ``SIL``, in the order of the outputs.
    offsets : ndarray of int, shape (seen,)
        Rows that are seen, counted from the row that is judged.
    mean, spread : ndarray, shape (columns,)
        Of a row, over what was learned from.
    layers : tuple of Layer
        Rectified linear units between them. The first takes ``seen * columns`` numbers and one more for each offset:
        1 if there is no such row yet.
    log_share : ndarray, shape (labels,)
        Logarithm of how often each label was heard in learning.
    log_follow : ndarray, shape (labels, labels)
        Logarithm of how often the second label follows the first.
    """

    labels: tuple[str, ...]
    offsets: NDArray[np.int64]
    mean: Single
    spread: Single
    layers: tuple[Layer, ...]
    log_share: Single
    log_follow: Single

    @property
    def future(self) -> int:
        """Rows after the one that is judged which can change the answer."""
        return int(self.offsets.max())

    @property
    def past(self) -> int:
        """Rows before it which can."""
        return int(-self.offsets.min())

    def seen(self, rows: NDArray[np.floating], first: int, last: int) -> Single:
        """What the network sees of rows ``first`` to ``last`` (not included), shape (last - first, inputs).

        Before the first row that one is repeated; rows after the last one are missing.
        """
        places = np.arange(first, last)[:, None] + self.offsets
        missing = places >= len(rows)
        standard = ((np.asarray(rows, dtype=np.float32) - self.mean) / self.spread)[np.clip(places, 0, len(rows) - 1)]
        standard[missing] = 0.0
        return np.concatenate([standard.reshape(last - first, -1), missing.astype(np.float32)], axis=1)

    def log_posteriors(self, rows: NDArray[np.floating], first: int = 0, last: int | None = None) -> Single:
        """Logarithm of the probability of each label, shape (rows asked for, labels).

        Parameters
        ----------
        rows : ndarray, shape (rows, columns)
            All that was heard, or its end: from ``first - past`` on nothing is lost.
        first, last : int, int or None
            Rows to judge; None: to the end.

        Raises
        ------
        InputError
            If ``first`` or ``last`` is outside the rows.
        """
        last = len(rows) if last is None else last
        if not 0 <= first <= last <= len(rows):
            raise InputError(f"rows {first} to {last} are not all among {len(rows)}")
        if first == last:
            return np.zeros((0, len(self.labels)), np.float32)
        value = self.seen(rows, first, last)
        for number, (weights, bias) in enumerate(self.layers):
            value = value @ weights + bias
            if number < len(self.layers) - 1:
                value = np.maximum(value, 0)
        value = value - value.max(axis=1, keepdims=True)
        return np.asarray(value - np.log(np.exp(value).sum(axis=1, keepdims=True)))

    def save(self, path: str) -> None:
        """Write it, weights in half precision; the same bytes each time."""
        arrays: dict[str, Any] = {"labels": np.array(self.labels), "offsets": self.offsets, "log_share": self.log_share}
        arrays["log_follow"] = self.log_follow
        arrays |= {"mean": self.mean, "spread": self.spread}
        for number, (weights, bias) in enumerate(self.layers):
            arrays[f"weights{number}"], arrays[f"bias{number}"] = weights.astype(np.float16), bias
        np.savez_compressed(path, **arrays)

    @classmethod
    def load(cls, file: str | IO[bytes]) -> FrameClassifier:
        """Read what `save` wrote, by path or from an open file."""
        with np.load(file, allow_pickle=False) as kept:
            count = sum(name.startswith("weights") for name in kept.files)
            layers = tuple((kept[f"weights{n}"].astype(np.float32), kept[f"bias{n}"]) for n in range(count))
            return cls(
                tuple(str(label) for label in kept["labels"]),
                kept["offsets"],
                kept["mean"],
                kept["spread"],
                layers,
                kept["log_share"],
                kept["log_follow"],
            )


@cache
def default_classifier() -> FrameClassifier:
    """The network that ships."""
    with asset("live/recogniser.npz").open("rb") as handle:
        return FrameClassifier.load(handle)
