"""What a model must beat: mean pose, cosine between keys, ridge regression.

Each stores its settings, learns in ``fit(takes)`` and returns itself; ``synthesise(phones, times)`` gives the markers
of the takes in millimetres, shape (frames, markers, 3). The dominance functions and the
perceptron stand in files of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.corpus.take import Take
from mien.metrics.context import PhoneContext, mouth_frames, speech_frames

__all__ = ["Cosine", "MeanPose", "Model", "Ridge", "learned_frames"]

Array = NDArray[np.float64]


class Model(Protocol):
    """Anything that can be evaluated."""

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn from takes that all have the same markers."""

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """Positions of those markers at the given times, shape (frames, markers, 3), mm."""


def learned_frames(takes: Sequence[Take]) -> tuple[list[Array], Array]:
    """Times of each take's speech, and the flat positions of all, shape (frames, markers * 3)."""
    pairs = [speech_frames(take) for take in takes]
    flat = np.concatenate([positions for _, positions in pairs]) if pairs else np.zeros((0, 0))
    if not len(flat):
        raise InputError(f"none of the {len(takes)} takes to learn from has a frame with speech and every marker seen")
    return [times for times, _ in pairs], flat


class MeanPose:
    """The mean of all frames, speech and pauses, whatever is said.

    Attributes
    ----------
    mean_ : ndarray, shape (markers, 3)
    """

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn the mean."""
        frames = [mouth_frames(take)[1] for take in takes]
        if not sum(len(flat) for flat in frames):
            raise InputError(f"none of the {len(takes)} takes to learn from has a frame with every marker seen")
        self.mean_ = np.concatenate(frames).mean(axis=0).reshape(-1, 3)
        return self

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """The mean at every time."""
        return np.tile(self.mean_, (len(times), 1, 1))


class Cosine:
    """One key shape for each phone, reached in its middle; half a cosine wave from each to the next.

    The key is the mean of what was recorded at the middles of that phone. A phone never met takes the mean key.

    Attributes
    ----------
    keys_ : dict of str to ndarray, shape (markers * 3,)
    """

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn the keys."""
        met: dict[str, list[Array]] = {}
        for take in takes:
            times, flat = mouth_frames(take)
            for phone in take.phones:
                if len(times) and times[0] <= phone.middle <= times[-1]:
                    met.setdefault(phone.label, []).append(flat[np.abs(times - phone.middle).argmin()])
        if not met:
            raise InputError(f"none of the {len(takes)} takes to learn from has a phone with every marker seen")
        self.keys_: dict[str, Array] = {label: np.mean(shapes, axis=0) for label, shapes in met.items()}
        self.other_: Array = np.mean(list(self.keys_.values()), axis=0)
        return self

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """Positions at the given times; before the first middle and after the last one the key is held."""
        if not len(phones):
            return np.tile(self.other_.reshape(-1, 3), (len(times), 1, 1))
        keys = np.array([self.keys_.get(phone.label, self.other_) for phone in phones])
        place = np.interp(times, [phone.middle for phone in phones], np.arange(len(phones), dtype=float))
        before = np.minimum(place.astype(int), max(len(phones) - 2, 0))
        after = np.minimum(before + 1, len(phones) - 1)
        share = (1 - np.cos(np.pi * (place - before)))[:, None] / 2
        flat: Array = (1 - share) * keys[before] + share * keys[after]
        return flat.reshape(len(times), -1, 3)


class Ridge:
    """Linear least squares from the phones about a frame to the markers, weights held small (ridge regression).

    Parameters
    ----------
    reach : float
        Seconds of context to each side.
    penalty : float
        On the squared weights, for one standard deviation of noise in a frame.

    Attributes
    ----------
    weights_ : ndarray, shape (columns, markers * 3)
    mean_ : ndarray, shape (markers * 3,)
    """

    def __init__(self, reach: float = 0.32, penalty: float = 10.0) -> None:
        self.reach, self.penalty = reach, penalty

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn the weights."""
        self.context_ = PhoneContext(self.reach).fit([take.phones for take in takes])
        times, flat = learned_frames(takes)
        inputs = self._inputs([self.context_.encode(k.phones, t) for k, t in zip(takes, times, strict=True)])
        self.mean_ = flat.mean(axis=0)
        self.centre_ = inputs.mean(axis=0)
        centred = inputs - self.centre_
        gram = centred.T @ centred + self.penalty * np.eye(self.context_.width)
        self.weights_ = np.linalg.solve(gram, centred.T @ (flat - self.mean_))
        return self

    def synthesise(self, phones: Tier, times: Array) -> Array:
        """Positions at the given times."""
        inputs = self._inputs([self.context_.encode(phones, times)])
        flat: Array = (inputs - self.centre_) @ self.weights_ + self.mean_
        return flat.reshape(len(times), -1, 3)

    def _inputs(self, codes: Sequence[NDArray[np.int64]]) -> Array:
        code = np.concatenate(codes)
        inputs = np.zeros((len(code), self.context_.width + 1))
        np.put_along_axis(inputs, code, 1.0, axis=1)  # an unknown phone (-1) marks the spare last column
        return inputs[:, :-1]
