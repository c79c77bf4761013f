"""`ExpressionSpace`: expressive motion without its words, as curves in three dimensions (Deng et al. 2006; A11, A12).

An expression is motion too, not a pose. What is left of an expressive recording once its words are taken out
(`mien.motion.expression.expression_motion`) is reduced to three dimensions by EM-PCA over all emotions together; each
emotion is a
bundle of curves there. New motion of any length is sampled from an emotion's curves in patches
(`mien.motion.expression.patch_sampling`).

What must move with the expression and is not part of the space is *carried*: the eyelids (the paper leaves them out,
but surprise without wide eyes is no surprise), and, where a face is driven by channels, those channels. It is sampled
with the same patches, so the three dimensions lose nothing of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, unknown_name
from mien.motion.em_pca import EMPCA
from mien.motion.expression.patch_sampling import Patches, PatchSettings, sample_patches

__all__ = ["RATE", "ExpressionSettings", "ExpressionSpace", "ExpressiveMotion", "SampledExpression"]

Floats = NDArray[np.float64]
RATE = 120.0
"""Samples per second of all curves: that of the paper's recordings, at which its patch sizes hold."""


@dataclass(frozen=True, eq=False)
class ExpressiveMotion:
    """An unbroken stretch of expressive motion, its words taken out, at `RATE`.

    Attributes
    ----------
    motion : ndarray, shape (samples, dimensions)
        How far each marker coordinate lies from neutral speech, mm; eyelid markers left out.
    carried : ndarray, shape (samples, carried)
        What moves with it (see above); may have no column.
    """

    motion: Floats
    carried: Floats


@dataclass(frozen=True)
class ExpressionSettings:
    """Settings of `ExpressionSpace`.

    Attributes
    ----------
    components : int
        Dimensions of the space; the paper's is 3.
    stride : int
        The axes are learned from one sample in so many: neighbours at `RATE` are nearly alike.
    patches : PatchSettings
    """

    components: int = 3
    stride: int = 6
    patches: PatchSettings = field(default_factory=PatchSettings)


@dataclass(frozen=True, eq=False)
class SampledExpression:
    """New expressive motion, at `RATE`.

    Attributes
    ----------
    patches : Patches
        Where it was taken from; tells how much was copied and where no patch fitted.
    curve_source, carried_source : ndarray, shape (rows, components or carried)
        What the patches are of.
    """

    patches: Patches
    curve_source: Floats
    carried_source: Floats

    @property
    def curve(self) -> Floats:
        """In the space, shape (samples, components)."""
        return self.patches.of(self.curve_source)

    @property
    def carried(self) -> Floats:
        """What moves with it, shape (samples, carried)."""
        return self.patches.of(self.carried_source)

    def carried_at(self, times: Floats) -> Floats:
        """What moves with it at some instants in seconds, rising, shape (times, carried); made for these alone."""
        places = times * RATE
        first = np.minimum(places.astype(np.int64), len(self.patches.share) - 2)
        share, low = (places - first)[:, None], int(first[0])
        carried = self.patches.of(self.carried_source, slice(low, int(first[-1]) + 2))
        return np.asarray((1 - share) * carried[first - low] + share * carried[first - low + 1])


class ExpressionSpace:
    """Curves of emotions in a space of few dimensions, and new curves like them.

    Parameters
    ----------
    settings : ExpressionSettings or None

    Attributes
    ----------
    space_ : EMPCA
        Over the motion of all emotions; ``space_.share_`` is the share of the variance that it keeps.
    curves_ : dict of str to tuple of ndarray, shape (samples, components)
        Source curves of each emotion.
    carried_ : dict of str to tuple of ndarray, shape (samples, carried)

    Examples
    --------
    >>> times = np.arange(600) / RATE
    >>> motion = np.stack([5 + np.sin(4 * times), np.cos(3 * times), 0.3 * np.sin(9 * times)], axis=1)
    >>> space = ExpressionSpace().fit({"happy": [ExpressiveMotion(motion, motion[:, :1])]})
    >>> new = space.sample("happy", 2.0, np.random.default_rng(1))
    >>> new.curve.shape, space.motion(new.curve).shape
    ((241, 3), (241, 3))
    """

    def __init__(self, settings: ExpressionSettings | None = None) -> None:
        self.settings = settings or ExpressionSettings()

    def fit(self, sources: Mapping[str, Sequence[ExpressiveMotion]]) -> Self:
        """Learn the space from the expressive motion of all emotions.

        Raises
        ------
        InputError
            If there is nothing to learn from, or stretches do not share their dimensions.
        """
        stretches = [stretch for emotion in sources.values() for stretch in emotion]
        if not stretches:
            raise InputError("no expressive motion to learn a space from")
        shapes = {(stretch.motion.shape[1], stretch.carried.shape[1]) for stretch in stretches}
        if len(shapes) > 1 or any(len(s.motion) != len(s.carried) for s in stretches):
            raise InputError(f"stretches of expressive motion differ in their dimensions: {sorted(shapes)}")
        rows = np.concatenate([stretch.motion[:: self.settings.stride] for stretch in stretches])
        self.space_ = EMPCA(self.settings.components).fit(rows)
        self.curves_ = {name: tuple(self.space_.encode(s.motion) for s in found) for name, found in sources.items()}
        self.carried_ = {name: tuple(s.carried for s in found) for name, found in sources.items()}
        return self

    def restore(self, curves: Mapping[str, tuple[Floats, ...]], carried: Mapping[str, tuple[Floats, ...]]) -> Self:
        """Take curves that were made before, and what they carry: enough to `sample`, not for `motion`."""
        self.curves_, self.carried_ = dict(curves), dict(carried)
        return self

    @property
    def emotions(self) -> tuple[str, ...]:
        """Emotions that have curves."""
        return tuple(sorted(self.curves_))

    def sample(self, emotion: str, seconds: float, random: np.random.Generator) -> SampledExpression:
        """New motion of an emotion: enough samples to interpolate at any instant from 0 to ``seconds``.

        Raises
        ------
        InputError
            If the emotion has no curve.
        """
        if emotion not in self.curves_:
            raise unknown_name("emotion", emotion, self.emotions)
        samples = int(np.ceil(max(seconds, 0.0) * RATE)) + 1
        patches = sample_patches(self.curves_[emotion], samples, random, self.settings.patches)
        sources = (np.concatenate(source[emotion]) for source in (self.curves_, self.carried_))
        return SampledExpression(patches, *sources)

    def motion(self, curve: Floats) -> Floats:
        """Marker displacements of a curve, shape (samples, dimensions), mm: what three dimensions hold of them."""
        return self.space_.decode(curve)
