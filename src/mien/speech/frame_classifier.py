"""Which phone is being said, every 10 ms, from sound that is still coming in.

A small conformer (Gulati et al. 2020, "Conformer: convolution-augmented transformer for speech recognition"; no
positions are coded) judges frames of 20 ms, two rows at a time, from the rows of `streaming_features`. `FrameStream`
judges each frame anew while the sound after it comes in, until `FUTURE` frames have come: then what its blocks found is
kept for the frames after it, and is not computed again.

Plain numpy. Learned by ``tools/live_recogniser``, from the weights of hama's recogniser on (NOTICE).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import IO

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.speech.streaming_features import BANDS

__all__ = ["ROWS", "FrameClassifier", "FrameStream", "default_classifier"]

ROWS = 2
"""Rows in a frame."""
FUTURE, STEP, PAST = 10, 5, 100
"""Frames after a frame until it is settled; frames that are settled at once; settled frames that are attended to."""
_HEADS = 4

Single = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class FrameClassifier:
    """The network.

    Attributes
    ----------
    labels : tuple of str
        Phones and ``SIL``, in the order of the answers.
    weights : mapping of str to ndarray
        By name: ``sub`` makes a frame of rows, ``0.attn`` is the attention of the first block, ``head`` judges.
    log_share : ndarray, shape (labels,)
        Logarithm of how often each label was heard in learning.
    log_follow : ndarray, shape (labels, labels)
        Logarithm of how often the second label follows the first.
    """

    labels: tuple[str, ...]
    weights: Mapping[str, Single]
    log_share: Single
    log_follow: Single

    @property
    def blocks(self) -> int:
        """How many there are."""
        return sum(name.endswith(".attn.in_w") for name in self.weights)

    def log_posteriors(self, rows: Single) -> Single:
        """Logarithm of the probability of each label, all rows at once, shape (rows, labels).

        An odd last row has no frame yet: it is judged as the one before.
        """
        if len(rows) < ROWS:
            return np.tile(self.log_share, (len(rows), 1))
        found = _Window(self, len(rows) // ROWS).judge(_frames(self, rows, None))
        return np.concatenate([found, found[-1:]])[: len(rows)]

    def save(self, path: str) -> None:
        """Write it, weights in half precision and not packed, which would gain little; the same bytes each time."""
        kept = {name: values.astype(np.float16) for name, values in self.weights.items()}
        follow = {"log_share": self.log_share, "log_follow": self.log_follow}
        np.savez(path, labels=np.array(self.labels), **follow, **kept)  # type: ignore[arg-type]

    @classmethod
    def load(cls, file: str | IO[bytes]) -> FrameClassifier:
        """Read what `save` wrote, by path or from an open file."""
        with np.load(file, allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
        labels = tuple(str(label) for label in arrays.pop("labels"))
        share, follow = (arrays.pop(name) for name in ("log_share", "log_follow"))
        return cls(labels, {name: values.astype(np.float32) for name, values in arrays.items()}, share, follow)


@cache
def default_classifier() -> FrameClassifier:
    """The network that ships."""
    with asset("live/recogniser.npz").open("rb") as handle:
        return FrameClassifier.load(handle)


class FrameStream:
    """A network's answers to rows that come in pieces: the same however they are cut.

    Parameters
    ----------
    network : FrameClassifier
    future, step, past : int
        Frames, as `FUTURE`, `STEP`, `PAST`.
    """

    def __init__(self, network: FrameClassifier, future: int = FUTURE, step: int = STEP, past: int = PAST) -> None:
        self.network = network
        self.settled = 0
        """Rows that have had their last answer."""
        self._future, self._step = future, step
        self._window = _Window(network, past)
        self._before: Single | None = None
        self._rows = np.zeros((0, BANDS), np.float32)

    def push(self, rows: Single) -> Single:
        """Take rows and give the last answers that they allow, shape (rows, labels)."""
        self._rows = np.concatenate([self._rows, rows])
        found = []
        while len(self._rows) >= ROWS * (self._future + self._step):
            frames = _frames(self.network, self._rows[: ROWS * (self._future + self._step)], self._before)
            found.append(self._window.judge(frames, self._step)[: ROWS * self._step])
            self._before, self._rows = self._rows[ROWS * self._step - 1], self._rows[ROWS * self._step :]
            self.settled += ROWS * self._step
        return np.concatenate(found) if found else np.zeros((0, len(self.network.labels)), np.float32)

    def pending(self) -> Single:
        """Answers so far to the rows that are not settled, shape (rows, labels)."""
        if len(self._rows) < ROWS:
            return np.zeros((0, len(self.network.labels)), np.float32)
        return self._window.judge(_frames(self.network, self._rows, self._before))


def _frames(network: FrameClassifier, rows: Single, before: Single | None) -> Single:
    """What enters the first block, shape (rows // ROWS, width): each frame sees its two rows and the one before."""
    weights, bias = network.weights["sub_w"], network.weights["sub_b"]
    count = len(rows) // ROWS
    held = np.concatenate([np.zeros((1, BANDS), np.float32) if before is None else before[None], rows])
    seen = np.stack([held[place : place + ROWS * count : ROWS] for place in range(ROWS + 1)], axis=1)
    return _gelu(seen.reshape(count, -1) @ weights.reshape(-1, weights.shape[-1]) + bias)


@dataclass
class _Block:
    """What a block keeps of settled frames: keys and values, what its convolution sees, what the head sees."""

    attended: Single
    near: Single


@dataclass
class _Window:
    """Some frames after those that are settled."""

    network: FrameClassifier
    past: int
    kept: list[_Block] = field(init=False)
    head: Single = field(init=False)

    def __post_init__(self) -> None:
        weights = self.network.weights
        width = len(weights["sub_b"])
        reach = len(weights["0.conv.deep_w"]) // 2
        self.kept = [
            _Block(np.zeros((0, 2 * width), np.float32), np.zeros((reach, width), np.float32))
            for _ in range(self.network.blocks)
        ]
        self.head = np.zeros((len(weights["head.wide_w"]) // 2, len(weights["head.near_b"])), np.float32)

    def judge(self, frames: Single, settle: int = 0) -> Single:
        """Answers for the rows of some frames; the first ``settle`` are kept."""
        found = []
        for number, kept in enumerate(self.kept):
            frames = self._block(frames, f"{number}.", kept, settle)
            found.append(frames)
        weights = self.network.weights
        near = np.maximum(np.concatenate(found, axis=1) @ weights["head.near_w"] + weights["head.near_b"], 0)
        held = np.concatenate([self.head, near, np.zeros_like(self.head)])
        wide = np.lib.stride_tricks.sliding_window_view(held, len(weights["head.wide_w"]), axis=0).swapaxes(1, 2)
        wide = wide.reshape(len(near), -1) @ weights["head.wide_w"].reshape(-1, len(weights["head.wide_b"]))
        value = np.maximum(wide + weights["head.wide_b"], 0) @ weights["head.out_w"] + weights["head.out_b"]
        value = value.reshape(ROWS * len(near), -1)
        if settle:
            self.head = held[settle : settle + len(self.head)]
        value = value - value.max(axis=1, keepdims=True)
        return np.asarray(value - np.log(np.exp(value).sum(axis=1, keepdims=True)))

    def _block(self, x: Single, name: str, kept: _Block, settle: int) -> Single:
        weights = self.network.weights
        x = x + np.float32(0.5) * self._forward(x, f"{name}ffn1.")
        entering = self._into(x, f"{name}attn.")
        query, fresh = entering[:, : x.shape[1]], entering[:, x.shape[1] :]
        attended = np.concatenate([kept.attended, fresh])
        x = x + _attention(query, attended) @ weights[f"{name}attn.out_w"] + weights[f"{name}attn.out_b"]
        value, gate = np.split(self._into(x, f"{name}conv."), 2, axis=1)
        near = np.concatenate([kept.near, value * _sigmoid(gate), np.zeros_like(kept.near)])
        deep = weights[f"{name}conv.deep_w"]
        seen = np.lib.stride_tricks.sliding_window_view(near, len(deep), axis=0)
        value = np.einsum("tck,kc->tc", seen, deep) + weights[f"{name}conv.deep_b"]
        x = x + (value * _sigmoid(value)) @ weights[f"{name}conv.out_w"] + weights[f"{name}conv.out_b"]
        x = x + np.float32(0.5) * self._forward(x, f"{name}ffn2.")
        if settle:
            kept.attended = attended[: len(kept.attended) + settle][-self.past :]
            kept.near = near[settle : settle + len(kept.near)]
        return _normal(x, weights[f"{name}norm_w"], weights[f"{name}norm_b"])

    def _into(self, x: Single, name: str) -> Single:
        weights = self.network.weights
        normal = _normal(x, weights[f"{name}norm_w"], weights[f"{name}norm_b"])
        return np.asarray(normal @ weights[f"{name}in_w"] + weights[f"{name}in_b"])

    def _forward(self, x: Single, name: str) -> Single:
        value = self._into(x, name)
        return np.asarray(
            (value * _sigmoid(value)) @ self.network.weights[f"{name}out_w"] + self.network.weights[f"{name}out_b"]
        )


def _attention(query: Single, attended: Single) -> Single:
    """What each frame takes from the others, by four heads."""
    keys, values = np.split(attended, 2, axis=1)
    heads = [part.reshape(len(part), _HEADS, -1).swapaxes(0, 1) for part in (query, keys, values)]
    score = heads[0] @ heads[1].swapaxes(1, 2) / np.float32(np.sqrt(heads[0].shape[2]))
    score = np.exp(score - score.max(axis=2, keepdims=True))
    score /= score.sum(axis=2, keepdims=True)
    return np.asarray((score @ heads[2]).swapaxes(0, 1).reshape(len(query), -1))


def _normal(x: Single, scale: Single, shift: Single) -> Single:
    x = x - x.mean(axis=1, keepdims=True)
    return np.asarray(x / np.sqrt((x * x).mean(axis=1, keepdims=True) + np.float32(1e-5)) * scale + shift)


def _sigmoid(x: Single) -> Single:
    return np.asarray(1 / (1 + np.exp(-np.clip(x, -60, 60))))


def _gelu(x: Single) -> Single:
    return np.asarray(0.5 * x * (1 + np.tanh(np.float32(0.7978845608) * (x + np.float32(0.044715) * x**3))))
