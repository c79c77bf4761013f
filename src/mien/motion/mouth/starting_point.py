"""A mouth that starts from another performer's: a few takes say how a person differs, not how speech moves.

What the other performer would do with the phones of the takes, ``c(t)`` in its own components, is laid on what was
recorded:

    row(t) = m + c(t) A

m and A are found by least squares, held to the other performer's own mean and axes by a ridge, as if `FRAMES_HELD`
frames had shown them: this is how far this person opens, rounds and spreads, and in which proportions. A is then
written as the axes of the pose space that lie nearest to it, so that a component keeps its meaning, times a small
matrix, which goes into the curves and networks. From there they go on learning, held to where they started as if
`FRAMES_HELD` frames more said so: with many takes little of the start is left.

Lips may come later than the other performer's, or earlier, while the jaw does not: each component may be answered a
little later or earlier, ``c_k(t - d_k)``, where that leaves less of what was recorded (`DELAYS`).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.errors import InputError
from mien.corpus.take import Take
from mien.motion.em_pca import EMPCA
from mien.motion.mouth.correction import Correction
from mien.motion.mouth.influence import InfluenceCurves
from mien.motion.mouth.lip_closure import LipClosure
from mien.motion.mouth.mouth_space import ChannelSpace, mouth_space_of
from mien.motion.mouth.recorded_mouths import RecordedMouth

if TYPE_CHECKING:
    from mien.motion.mouth.speech_motion import SpeechMotion

__all__ = ["StartingPoint", "joined_space"]

FRAMES_HELD = 60
"""Frames that the other performer's axes count as."""
MEAN_SHARE = 1 / 6
"""Of that, what its mean counts as: people differ more at rest than in how they move."""

DELAYS = np.arange(-4, 5) * 0.02
"""Seconds (d) that are tried."""
LEAST_GAIN = 0.01
"""Share of what is left of the recorded motion that a delay has to take away."""
DELAY_TAKES = 40
"""Takes in which delays are looked for, at most."""

Floats = NDArray[np.float64]


def joined_space(prior: SpeechMotion, takes: Sequence[Take]) -> ChannelSpace:
    """Channels that move in the takes or in the other performer.

    Raises
    ------
    InputError
        If takes have no channels, or the other performer learned in markers.
    """
    space = mouth_space_of(takes, ChannelSpace.kind)
    if not isinstance(prior.mouth_, ChannelSpace):
        raise InputError("a performer that learned in markers is nothing to start from: choose one that has channels")
    known = {*prior.mouth_.names, *space.names}
    return ChannelSpace.of([name for name in channels.MOUTH if name in known])


@dataclass(frozen=True, eq=False)
class StartingPoint:
    """Another performer's mouth as this person would move it.

    Attributes
    ----------
    space : EMPCA
        Pose space of the person.
    curves : InfluenceCurves
    correction : Correction or None
    edits : ndarray, shape (frames, components)
        What key shapes of the other performer that were changed add in the frames of the takes.
    closure : LipClosure
    delays : ndarray, shape (components,)
        Seconds by which each component comes later than curves and networks answer.
    """

    space: EMPCA
    curves: InfluenceCurves
    correction: Correction | None
    edits: Floats
    closure: LipClosure
    delays: Floats

    @classmethod
    def of(cls, prior: SpeechMotion, mouths: Sequence[RecordedMouth], space: ChannelSpace) -> StartingPoint:
        """Lay a performer's motion on recorded mouths."""
        count = len(prior.space_.axes_)
        poses = _in_space(prior, space, prior.space_.decode(np.concatenate([np.zeros((1, count)), np.eye(count)])))
        mean, axes = poses[0], poses[1:] - poses[0]
        later = copy(prior)
        later.delays_ = prior.delays_ + _delays(prior, mouths, mean, axes)
        rows = np.concatenate([mouth.rows for mouth in mouths])
        answered = np.concatenate([later.components(mouth.phones, mouth.times) for mouth in mouths])
        mean, axes, _ = _laid(prior, rows, answered, mean, axes)
        poses_space = _nearest_axes(mean, axes, rows)
        way = axes @ poses_space.axes_.T
        curves = InfluenceCurves(prior.curves_.settings)
        curves.weights_, curves.shapes_ = prior.curves_.weights_, prior.curves_.shapes_ @ way
        correction = None
        if prior.correction_ is not None:
            correction = Correction(prior.correction_.settings)
            correction.layers_ = [
                [*layers[:-1], (layers[-1][0] @ way, layers[-1][1] @ way)] for layers in prior.correction_.layers_
            ]
        plain = np.concatenate([later.unedited(mouth.phones, mouth.times) for mouth in mouths])
        edits = (answered - plain) @ way
        return cls(poses_space, curves, correction, edits, _closure_in(prior, space), later.delays_)


def _laid(
    prior: SpeechMotion, rows: Floats, answered: Floats, mean: Floats, axes: Floats
) -> tuple[Floats, Floats, float]:
    """Mean and axes that lay what is answered on rows, held to those given; the squares of what is left."""
    seen = np.concatenate([np.ones((len(rows), 1)), answered], axis=1)
    held = FRAMES_HELD * np.concatenate([[MEAN_SHARE], np.maximum(prior.space_.variances_, 1e-9)])
    away = rows - mean - answered @ axes
    change = np.linalg.solve(seen.T @ seen + np.diag(held), seen.T @ away)
    left = float(((away - seen @ change) ** 2).sum())
    return mean + change[0], axes + change[1:], left


def _delays(prior: SpeechMotion, mouths: Sequence[RecordedMouth], mean: Floats, axes: Floats) -> Floats:
    """Seconds by which each component comes later in recorded mouths than it is answered, shape (components,)."""
    chosen = mouths[:: -(-len(mouths) // DELAY_TAKES)]
    rows = np.concatenate([mouth.rows for mouth in chosen])
    tried = [np.concatenate([prior.components(m.phones, m.times - delay) for m in chosen]) for delay in DELAYS]
    now = len(DELAYS) // 2
    answered, places = tried[now].copy(), np.full(len(axes), now)
    least = _laid(prior, rows, answered, mean, axes)[2]
    for component in np.argsort(-prior.space_.variances_, kind="stable"):
        before = answered[:, component].copy()
        left = []
        for one in tried:
            answered[:, component] = one[:, component]
            left.append(_laid(prior, rows, answered, mean, axes)[2])
        best = int(np.argmin(left))
        if left[best] < (1 - LEAST_GAIN) * least:
            places[component], least = best, left[best]
            answered[:, component] = tried[best][:, component]
        else:
            answered[:, component] = before
    return np.asarray(DELAYS[places])


def _in_space(prior: SpeechMotion, space: ChannelSpace, rows: Floats) -> Floats:
    """Rows of another performer, or differences of them, in a space that has its channels too."""
    weights = np.zeros((len(rows), len(space.names)))
    weights[:, [space.names.index(name) for name in prior.mouth_.names]] = prior.mouth_.differences_of(rows)
    return space.rows_from(weights)


def _closure_in(prior: SpeechMotion, space: ChannelSpace) -> LipClosure:
    """The other performer's closures, along a way that parts the lips by a millimetre as they are here."""
    closure = LipClosure(space)
    closure.apart_, closure.delay_ = prior.closure_.apart_, prior.closure_.delay_
    way = _in_space(prior, space, prior.closure_.closing_[None])
    closure.closing_ = way[0] / (space.opening_of(way)[0] - space.opening_of(0 * way)[0])
    return closure


def _nearest_axes(mean: Floats, axes: Floats, rows: Floats) -> EMPCA:
    """The pose space whose orthonormal axes lie nearest to those given (the polar factor)."""
    left, _, right = np.linalg.svd(axes, full_matrices=False)
    space = EMPCA(len(axes))
    space.mean_, space.weights_, space.axes_, space.steps_ = mean, np.ones(len(mean)), left @ right, 0
    space.variances_ = space.encode(rows).var(axis=0)
    total = float(((rows - rows.mean(axis=0)) ** 2).sum(axis=1).mean())
    space.share_ = min(float(space.variances_.sum()) / total, 1.0) if total > 0 else 1.0
    return space
