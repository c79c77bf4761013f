"""Influence curves: the explicit half of the learned mouth.

Every part of speech (a phone, or half of a diphthong) pulls the mouth towards a target; how strongly it pulls at an
instant falls off with the time to its edges, faster or slower, differently before and after it and for each of a
few *strands* of the motion:

    g_ih(t) = a_ih - r_ih max(s_i - t, 0) - q_ih max(t - e_i, 0) + d_ih min(t - s_i, e_i - t, D)+    log of the pull
    w_ih(t) = exp g_ih(t) / Σ_j exp g_jh(t)                                                           influence
    z_h(t)  = Σ_i w_ih(t) T_ih                                                                        strand
    pose(t) = mean + Σ_h z_h(t) B_h

i runs over the parts about t, s_i and e_i are the start and end of part i. These are the dominance functions of Cohen
and Massaro 1993 with four changes: times count from the edges of a part, not from its middle; each strand has curves of
its own, so that lips may close while they stay round; targets T, strengths a and fall-offs r, q are linear in what the
mouth does in the part (`articulation`), in its duration (so that they depend on the speaking rate), and, held smaller,
in the phone itself; and all of it is learned together with the shapes B. A phone that was never recorded has targets
and curves all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.descent import Adam, going_on

__all__ = ["CURVES", "InfluenceCurves", "InfluenceSettings", "PartsInTime", "describe_parts"]

CURVES = ("target", "strength", "before", "after", "inside")
"""What a part has for each strand: T, a, log r, log q, d."""
DEEPEST = 0.06
"""Seconds (D): deeper inside a part its pull grows no further."""
REFERENCE_DURATION = 0.08
"""Seconds at which the logarithm of a duration is 0; durations count from 0.02 to 0.4 s."""
PAUSE_LENGTH = 0.4
"""Seconds of each pause that stands before the first part and after the last one."""
UNIT = 0.1
"""Seconds: fall-offs are per tenth of a second."""
_WITH_DURATION = ("pause", "vowel", "bilabial", "labiodental", "round")
_START_FALLOFF = 0.7

Floats = NDArray[np.float64]
Single = NDArray[np.float32]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class InfluenceSettings:
    """How influence curves are learned.

    Attributes
    ----------
    strands : int
        Curves per part.
    neighbours : int
        Parts to each side that pull on an instant.
    lead : float
        Seconds by which the mouth runs ahead of the sound.
    phone_weight : float
        Scale of what is learned for a phone itself beside its articulation; smaller carries more over to new contexts.
    shrinkage : float
        Pull of all weights towards nothing.
    epochs : int
        Passes through all frames.
    batch : int
        Frames per step.
    rate : float
        Size of the first steps; falls to 0 on a half cosine.
    seed : int
    """

    strands: int = 16
    neighbours: int = 4
    lead: float = 0.025
    phone_weight: float = 0.25
    shrinkage: float = 1e-3
    epochs: int = 8
    batch: int = 256
    rate: float = 0.02
    seed: int = 0


@dataclass(frozen=True, eq=False)
class PartsInTime:
    """Which parts pull on each instant, and how far away their edges are.

    Attributes
    ----------
    described : ndarray, shape (parts, descriptors)
    index : ndarray of int, shape (frames, pulls)
        Rows of ``described``.
    until, since, inside : ndarray, shape (frames, pulls)
        Tenths of a second until the part starts, since it ended, and from its nearer edge (0 to `DEEPEST`).
    """

    described: NDArray[np.floating]
    index: Whole
    until: NDArray[np.floating]
    since: NDArray[np.floating]
    inside: NDArray[np.floating]

    @classmethod
    def join(cls, pieces: Sequence[PartsInTime]) -> PartsInTime:
        """Several utterances as one, in single precision (for learning)."""
        offsets = np.cumsum([0] + [len(piece.described) for piece in pieces[:-1]])
        index = np.concatenate([piece.index + offset for piece, offset in zip(pieces, offsets, strict=True)])
        columns = [
            np.concatenate([getattr(piece, name) for piece in pieces]).astype(np.float32)
            for name in ("described", "until", "since", "inside")
        ]
        return cls(columns[0], index, *columns[1:])

    def frames(self, rows: Whole) -> PartsInTime:
        """Some of the instants, with the parts that they need."""
        used, index = np.unique(self.index[rows], return_inverse=True)
        index = index.reshape(len(rows), -1)
        return PartsInTime(self.described[used], index, self.until[rows], self.since[rows], self.inside[rows])


def describe_parts(symbols: Whole, durations: Floats, phone_weight: float) -> Floats:
    """What a part's target and curves are linear in, shape (parts, descriptors).

    One, the articulatory features, the logarithm of the duration alone and times some features, the symbol itself.
    """
    table = articulation_table()
    features = table.values[symbols]
    duration = np.log(np.clip(durations, 0.02, 0.4) / REFERENCE_DURATION)[:, None]
    scaled = duration * features[:, [table.features.index(name) for name in _WITH_DURATION]]
    one_of_n = np.eye(len(table.symbols))[symbols] * phone_weight
    return np.concatenate([np.ones((len(symbols), 1)), features, duration, scaled, one_of_n], axis=1)


class InfluenceCurves:
    """Targets and influence curves, learned by gradient descent on the squared error.

    Parameters
    ----------
    settings : InfluenceSettings

    Attributes
    ----------
    weights_ : ndarray, shape (descriptors, 5, strands)
        Of `CURVES`, on what `describe_parts` says of a part.
    shapes_ : ndarray, shape (strands, components)
        What a strand moves (B), in the components of the pose space.
    """

    def __init__(self, settings: InfluenceSettings | None = None) -> None:
        self.settings = settings or InfluenceSettings()
        self.weights_: NDArray[np.floating[Any]] = np.zeros((0, len(CURVES), 0))
        self.shapes_: NDArray[np.floating[Any]] = np.zeros((0, 0))

    def place(self, phones: Tier, times: Floats) -> PartsInTime:
        """Find the parts that pull on each instant."""
        reach = self.settings.neighbours
        parts = parts_of(phones)
        pause = articulation_table().parts[PAUSE][0]
        first, last = (parts.starts[0], parts.ends[-1]) if len(parts) else (0.0, 0.0)
        steps = np.arange(reach + 1) * PAUSE_LENGTH
        starts = np.concatenate([first - steps[:0:-1], parts.starts, last + steps[:-1]])
        ends = np.concatenate([first - steps[-2::-1], parts.ends, last + steps[1:]])
        symbols = np.concatenate([np.full(reach, pause), parts.symbols, np.full(reach, pause)])
        at = times + self.settings.lead
        here = np.clip(np.searchsorted(starts, at, side="right") - 1, reach, max(len(starts) - reach - 1, reach))
        index = np.clip(here[:, None] + np.arange(-reach, reach + 1), 0, len(starts) - 1)
        since_start, until_end = at[:, None] - starts[index], ends[index] - at[:, None]
        return PartsInTime(
            describe_parts(symbols, ends - starts, self.settings.phone_weight),
            index,
            np.maximum(-since_start, 0) / UNIT,
            np.maximum(-until_end, 0) / UNIT,
            np.clip(np.minimum(since_start, until_end), 0, DEEPEST) / UNIT,
        )

    def fit(
        self,
        parts: Sequence[PartsInTime],
        components: Floats,
        after_epoch: Callable[[], None] = lambda: None,
        start: InfluenceCurves | None = None,
    ) -> Self:
        """Learn from placed utterances and the components of their frames, shape (all frames, components).

        ``start``: curves from which to go on, and to which they are held (`mien.motion.mouth.descent.going_on`).
        """
        settings = self.settings
        random = np.random.default_rng(settings.seed)
        everything = PartsInTime.join(parts)
        self._scale = float(components.std(axis=0).max()) or 1.0
        wanted = (components / self._scale).astype(np.float32)
        passes, rate, pulls = 1, settings.rate, (settings.shrinkage, settings.shrinkage / 10)
        if start is None:
            self._begin(everything.described.shape[1], wanted.shape[1], random)
            anchors = [self.weights_.copy(), np.zeros_like(self.shapes_)]
            anchors[0][1:], anchors[0][:, [0, 1, 4]] = 0, 0  # fall-offs are pulled to where they began, all else to 0
        else:
            self.weights_ = start.weights_.astype(np.float32)
            self.shapes_ = (start.shapes_ / self._scale).astype(np.float32)
            anchors = [self.weights_.copy(), self.shapes_.copy()]
            passes, rate, pull = going_on(len(wanted), settings.batch, settings.epochs, settings.rate)
            pulls = (pull, pull)
        steps = settings.epochs * passes * -(-len(wanted) // settings.batch)
        adam = Adam([self.weights_, self.shapes_], rate, steps)
        for _ in range(settings.epochs):
            for _ in range(passes):
                order = random.permutation(len(wanted))
                for rows in np.split(order, range(settings.batch, len(order), settings.batch)):
                    slopes = self._slopes(everything.frames(rows), wanted[rows])
                    slopes[0] += np.float32(pulls[0]) * (self.weights_ - anchors[0])
                    slopes[1] += np.float32(pulls[1]) * (self.shapes_ - anchors[1])
                    adam.step(slopes)
            after_epoch()
        self.weights_ = self.weights_.astype(np.float64)  # still exact in single precision: files keep every bit
        self.shapes_ = (self.shapes_ * np.float32(self._scale)).astype(np.float64)
        return self

    def _begin(self, descriptors: int, components: int, random: np.random.Generator) -> None:
        strands = self.settings.strands
        spread = np.array([0.1, 0.05, 0.02, 0.02, 0.0])[:, None]
        weights = random.standard_normal((descriptors, len(CURVES), strands)) * spread
        weights[0, 2:4] += _START_FALLOFF
        shapes = random.standard_normal((strands, components)) / np.sqrt(strands)
        shapes[np.arange(min(strands, components)), np.arange(min(strands, components))] += 1.0
        self.weights_, self.shapes_ = weights.astype(np.float32), shapes.astype(np.float32)

    def _slopes(self, parts: PartsInTime, wanted: Single) -> list[Single]:
        """Slopes of half the mean squared error on weights and shapes."""
        curves = self.curves(parts.described)
        influence = influence_of(curves, parts)
        targets = curves[:, 0][parts.index]
        strands = (influence * targets).sum(axis=1)
        error = (strands @ self.shapes_ - wanted) / np.float32(len(wanted))
        on_strand = (error @ self.shapes_.T)[:, None]
        on_target = influence * on_strand
        on_pull = on_target * (targets - strands[:, None])
        gathered = _sum_by_part(
            [on_target, on_pull, on_pull * -parts.until[..., None], on_pull * -parts.since[..., None],
             on_pull * parts.inside[..., None]],
            parts.index, len(parts.described),
        )  # fmt: skip
        gathered[:, 2:4] *= curves[:, 2:4]  # r = exp(log r)
        on_weights = np.tensordot(parts.described.T, gathered, axes=1)
        return [on_weights.astype(np.float32), (strands.T @ error).astype(np.float32)]

    def curves(self, described: NDArray[np.floating]) -> NDArray[np.floating]:
        """Target, strength, fall-offs before and after (per `UNIT`), growth inside: shape (parts, 5, strands)."""
        found = np.tensordot(described, self.weights_, axes=1)
        found[:, 2:4] = np.exp(np.clip(found[:, 2:4], -4, 4))
        return np.asarray(found)

    def components(self, parts: PartsInTime, target_offsets: Floats | None = None) -> Floats:
        """Components of the pose at each instant, shape (frames, components).

        Parameters
        ----------
        parts : PartsInTime
        target_offsets : ndarray, shape (parts, strands), or None
            Added to the targets: how an edited key shape enters.
        """
        curves = self.curves(parts.described)
        targets = curves[:, 0] if target_offsets is None else curves[:, 0] + target_offsets
        strands = (influence_of(curves, parts) * targets[parts.index]).sum(axis=1)
        return np.asarray(strands @ self.shapes_)


def influence_of(curves: NDArray[np.floating], parts: PartsInTime) -> NDArray[np.floating]:
    """Influence of each part on each strand at each instant, shape (frames, pulls, strands); sums to 1 over pulls."""
    at = curves[parts.index]
    pull = at[:, :, 1] - at[:, :, 2] * parts.until[..., None] - at[:, :, 3] * parts.since[..., None]
    pull += at[:, :, 4] * parts.inside[..., None]
    pull -= pull.max(axis=1, keepdims=True)
    influence = np.exp(pull)
    influence /= influence.sum(axis=1, keepdims=True)
    return np.asarray(influence)


def _sum_by_part(slopes: Sequence[NDArray[np.floating]], index: Whole, parts: int) -> NDArray[np.floating]:
    """Add up what falls on each part, shape (parts, kinds, strands)."""
    from scipy.sparse import csr_array

    flat = index.ravel()
    gather = csr_array((np.ones(len(flat), np.float32), (flat, np.arange(len(flat)))), shape=(parts, len(flat)))
    stacked = np.stack(slopes, axis=2).reshape(len(flat), -1)
    return np.asarray(gather @ stacked).reshape(parts, len(slopes), -1)
