"""Maps of the components of motion from one emotion to another (Cao et al. 2005): the paper's, plain ones, and mien's.

A map learns from `MeetingFrames`: the components of sentences that were said in both emotions, and which frames of the
two say the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "LIVELY",
    "ComponentMap",
    "LivelyMap",
    "MeetingFrames",
    "OffsetMap",
    "PaperMap",
    "SameMap",
    "liveliness_of",
]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Kernel = Literal["exponential", "gaussian"]

CENTRES = 250
LIVELY = (0.8, 1.2)
"""Spread of velocities that a map may have, as a share of the real one's."""
_ASKED = (0.86, 1.14)
"""The same on the sentences that it is chosen on: narrower, as others will differ."""
_PENALTIES = (0.001, 0.01, 0.1, 1.0)
_BLENDS = (0.0, 0.25, 0.5, 0.75, 1.0)
_WIDTHS = (1.0, 2.0)
_BENDINGS = (0.03, 0.3)
_FEW_CENTRES = 60
_FOLDS = 6
_GAIN = 0.995  # a richer map is taken where its error on sentences held out is below this share of the plainer one's


@dataclass(frozen=True, eq=False)
class MeetingFrames:
    """What a map is learned from.

    Attributes
    ----------
    sentences : sequence of (source, target, path)
        Independent components in both emotions, shapes (frames, components) and (other frames, components), and the
        pairs of frames that say the same, shape (steps, 2).
    mixing : ndarray, shape (components, components)
        Turns independent components into principal ones, mm.
    is_emotion : ndarray of bool, shape (components,)
    """

    sentences: Sequence[tuple[Floats, Floats, Whole]]
    mixing: Floats
    is_emotion: NDArray[np.bool_]

    def met(self) -> tuple[Floats, Floats]:
        """Components of the frames that say the same, one below the other."""
        return (
            np.concatenate([source[path[:, 0]] for source, _, path in self.sentences]),
            np.concatenate([target[path[:, 1]] for _, target, path in self.sentences]),
        )


class ComponentMap(Protocol):
    """Independent components of motion in one emotion in, those in the other out; shape (frames, components)."""

    def fit(self, met: MeetingFrames) -> Self:
        """Learn from frames that meet."""

    def apply(self, source: Floats) -> Floats:
        """Map the frames of one stretch, in order."""


class SameMap:
    """No change: what every map has to beat."""

    def fit(self, met: MeetingFrames) -> Self:
        """Nothing to learn."""
        return self

    def apply(self, source: Floats) -> Floats:
        """The same."""
        return source


class OffsetMap:
    """The mean difference of all components, added to every frame."""

    def fit(self, met: MeetingFrames) -> Self:
        """Learn the difference."""
        source, target = met.met()
        self.offset_ = target.mean(axis=0) - source.mean(axis=0)
        return self

    def apply(self, source: Floats) -> Floats:
        """Add it."""
        return np.asarray(source + self.offset_)


class PaperMap:
    """The paper's radial basis functions (Eq. 10, 11) on the emotion components: interpolates 250 centres, by LU.

    Parameters
    ----------
    kernel : {"exponential", "gaussian"}
        φ(x) = exp(-x/d) or exp(-x²/d), d the distance of the two closest centres.
    seed : int
        Of k-means.
    """

    def __init__(self, kernel: Kernel = "exponential", seed: int = 0) -> None:
        self.kernel, self.seed = kernel, seed

    def fit(self, met: MeetingFrames) -> Self:
        """Cluster the source frames; a centre's target is the mean of its frames' targets."""
        from scipy.linalg import lu_factor, lu_solve

        self.is_emotion_ = met.is_emotion
        source, target = (part[:, met.is_emotion] for part in met.met())
        labels = _clusters(source, CENTRES, self.seed)
        used = np.unique(labels)
        self.centres_ = np.array([source[labels == one].mean(axis=0) for one in used])
        goals = np.array([target[labels == one].mean(axis=0) for one in used])
        apart = _distances(self.centres_, self.centres_)
        others = apart[~np.eye(len(apart), dtype=bool)]
        self.width_ = max(float(others.min()) if len(others) else 1.0, 1e-9)
        self.weights_ = lu_solve(lu_factor(self._phi(self.centres_)), goals - self.centres_)
        return self

    def _phi(self, frames: Floats) -> Floats:
        x = _distances(frames, self.centres_)
        return np.asarray(np.exp(-(x if self.kernel == "exponential" else x**2) / self.width_))

    def apply(self, source: Floats) -> Floats:
        """e_j = e_i + Σ c_r φ(|e_i - e_i,r|)."""
        changed = source.copy()
        changed[:, self.is_emotion_] += self._phi(source[:, self.is_emotion_]) @ self.weights_
        return np.asarray(changed)


class LivelyMap:
    """Offset, gains on all components, and what depends on the place; never less lively than the real motion.

    Least squares alone would freeze motion: what cannot be told from the source is left out, so the mapped motion moves
    less than the real one. Here the least-squares gain (a ridge drawn to "no change but the offset", seeing some frames
    before and after) is blended with the *spread-keeping* gain: the linear map that carries the spread of the source's
    motion onto the target's (optimal transport between Gaussians). Wide radial functions (another ridge) may then bend
    it, which is how an offset that differs between phones gets in. Every strength is chosen on sentences held out: the
    least error among maps that are as lively as the real motion, the plainer one where they are equal.

    Parameters
    ----------
    context : int
        Frames before and after that the gain sees, beside the frame itself.
    seed : int
        Of the radial functions' centres.

    Attributes
    ----------
    penalty_ : float
        How strongly the gain is drawn to the identity; infinite: an offset alone.
    blend_ : float
        Share of the spread-keeping gain.
    width_, bending_ : float
        Width of the radial functions in units of the source's spread, and their penalty; 0: none.
    liveliness_ : float
        Spread of velocities against the real one's, on sentences held out.
    error_, offset_error_ : float
        Mean square distance, mm², of this map and of the mean offset on sentences held out.
    from_, to_ : ndarray, shape (components,)
        Means in both emotions, principal components.
    gain_ : ndarray, shape (3 * components, components)
        Of the frame, and of how the motion before and after it differs from it.
    centres_, weights_ : ndarray, shape (centres, components)
        Of the radial functions.
    reach_ : float
        Their width, mm.
    mixing_ : ndarray, shape (components, components)
    """

    def __init__(self, context: int = 2, seed: int = 0) -> None:
        self.context, self.seed = context, seed

    def fit(self, met: MeetingFrames) -> Self:
        """Choose on sentences held out (halves of one, if there is but one), then learn from all."""
        self.mixing_ = met.mixing
        sentences = [(source @ met.mixing, target @ met.mixing, path) for source, target, path in met.sentences]
        folds = _folds(sentences)
        judged = [_Fold(self, known, out) for known, out in folds]

        def judge(penalty: float, blend: float, width: float, bending: float) -> tuple[float, float]:
            squares, made, real = np.sum([one.judge(penalty, blend, width, bending) for one in judged], axis=0)
            return float(squares), float(np.sqrt(made / max(real, 1e-12)))

        frames = sum(len(path) for _, _, path in sentences)
        plain = (np.inf, 0.0, 0.0, 0.0)
        error, lively = judge(*plain)
        self.offset_error_ = error / frames
        best = (error, lively, plain)
        floor = min(_ASKED[0], lively)  # where even an offset is less lively, no map may be less so
        for choice in [(p, b, 0.0, 0.0) for p in _PENALTIES for b in _BLENDS]:
            best = _better(best, (*judge(*choice), choice), floor)
        start = best[2]
        for choice in [(start[0], start[1], w, r) for w in _WIDTHS for r in _BENDINGS]:
            best = _better(best, (*judge(*choice), choice), floor)
        self.error_, self.liveliness_ = best[0] / frames, best[1]
        self.penalty_, self.blend_, self.width_, self.bending_ = best[2]
        learned = _Learned(self, sentences)
        self.from_, self.to_ = learned.source_mean, learned.target_mean
        self.gain_ = learned.gain(self.penalty_, self.blend_)
        self.centres_, self.weights_, self.reach_ = learned.bend(self.gain_, self.width_, self.bending_)
        return self

    def __str__(self) -> str:
        missed, offset = (float(np.sqrt(error)) for error in (self.error_, self.offset_error_))
        return f"{missed:.2f} of {offset:.2f} mm over all markers, liveliness {self.liveliness_:.2f}"

    def restore(self, **learned: Floats | float) -> Self:
        """Take what was learned before, by the names of the attributes."""
        for name, value in learned.items():
            setattr(self, name, value)
        return self

    def apply(self, source: Floats) -> Floats:
        """Map the frames of one stretch, in order."""
        centred = source @ self.mixing_ - self.from_
        mapped = self.to_ + surroundings(centred, self.context) @ self.gain_
        if len(self.centres_):
            mapped = mapped + _bumps(centred, self.centres_, self.reach_) @ self.weights_
        return np.asarray(np.linalg.solve(self.mixing_.T, mapped.T).T)


_Choice = tuple[float, float, tuple[float, float, float, float]]


def _better(best: _Choice, other: _Choice, floor: float) -> _Choice:
    """The other choice, if it is lively and clearly nearer to the truth, or if the best so far is not lively."""
    is_lively = floor <= other[1] <= _ASKED[1]
    was_lively = _ASKED[0] <= best[1] <= _ASKED[1]
    if is_lively and (other[0] < _GAIN * best[0] or (not was_lively and other[1] >= _ASKED[0] and other[0] < best[0])):
        return other
    return best


def _folds(
    sentences: Sequence[tuple[Floats, Floats, Whole]],
) -> list[tuple[list[tuple[Floats, Floats, Whole]], list[tuple[Floats, Floats, Whole]]]]:
    """What is known and what is held out: sentences, or the halves of one."""
    if len(sentences) == 1:
        source, target, path = sentences[0]
        middle = len(path) // 2
        halves = [(source, target, path[:middle]), (source, target, path[middle:])]
        return [([halves[1]], [halves[0]]), ([halves[0]], [halves[1]])]
    count = min(_FOLDS, len(sentences))
    return [
        ([s for i, s in enumerate(sentences) if i % count != fold], list(sentences[fold::count]))
        for fold in range(count)
    ]


class _Learned:
    """Moments of the frames that meet: every gain follows from them."""

    def __init__(self, settings: LivelyMap, sentences: Sequence[tuple[Floats, Floats, Whole]]) -> None:
        self.settings = settings
        source = np.concatenate([a[path[:, 0]] for a, _, path in sentences])
        self.target = np.concatenate([b[path[:, 1]] for _, b, path in sentences])
        self.source_mean, self.target_mean = source.mean(axis=0), self.target.mean(axis=0)
        self.source = source - self.source_mean
        self.wanted = self.target - self.target_mean
        seen = [surroundings(a - self.source_mean, settings.context)[path[:, 0]] for a, _, path in sentences]
        self.seen = np.concatenate(seen)
        self.gram = self.seen.T @ self.seen / len(source)
        self.cross = self.seen.T @ self.wanted / len(source)
        size = source.shape[1]
        self.scale = max(float(np.trace(self.gram[:size, :size])) / size, 1e-12)
        self.transport = _transport(self.gram[:size, :size], self.wanted.T @ self.wanted / len(source))
        self._centres: Floats | None = None
        self._squares: dict[float, Floats] = {}

    @property
    def centres(self) -> Floats:
        """Centres of clusters of the source's frames."""
        if self._centres is None:
            count = min(_FEW_CENTRES, max(2, len(self.source) // 20))
            labels = _clusters(self.source, count, self.settings.seed)
            self._centres = np.array([self.source[labels == one].mean(axis=0) for one in np.unique(labels)])
        return self._centres

    def gain(self, penalty: float, blend: float) -> Floats:
        """Ridge towards the identity, min |S G - Y|² + penalty |G - I|², blended with the spread-keeping gain."""
        size, same = self.source.shape[1], np.zeros_like(self.cross)
        same[:size] = np.eye(size)
        if not np.isfinite(penalty):
            return np.asarray(same)
        if penalty not in self._squares:
            drawn = penalty * self.scale
            gram = self.gram + drawn * np.eye(len(self.gram))
            self._squares[penalty] = np.linalg.solve(gram, self.cross + drawn * same)
        squares = self._squares[penalty]
        keeping = np.zeros_like(squares)
        keeping[:size] = self.transport
        return np.asarray((1 - blend) * squares + blend * keeping)

    def bend(self, gain: Floats, width: float, bending: float) -> tuple[Floats, Floats, float]:
        """Centres, weights and reach of radial functions on what the gain leaves."""
        size = self.source.shape[1]
        if not width:
            return np.zeros((0, size)), np.zeros((0, size)), 1.0
        reach = width * float(np.sqrt((self.source**2).sum(axis=1).mean()))
        centres = self.centres
        bumps = _bumps(self.source, centres, reach)
        left = self.wanted - self.seen @ gain
        drawn = bending * len(bumps) * float((bumps**2).mean())
        weights = np.linalg.solve(bumps.T @ bumps + drawn * np.eye(len(centres)), bumps.T @ left)
        return centres, np.asarray(weights), reach


class _Fold:
    """Sentences held out, and what the others teach."""

    def __init__(
        self,
        settings: LivelyMap,
        known: Sequence[tuple[Floats, Floats, Whole]],
        out: Sequence[tuple[Floats, Floats, Whole]],
    ) -> None:
        self.learned, self.out, self.settings = _Learned(settings, known), out, settings

    def judge(self, penalty: float, blend: float, width: float, bending: float) -> tuple[float, float, float]:
        """Sum of squares of what is missed, and of velocities made and real."""
        learned, squares, made, real = self.learned, 0.0, 0.0, 0.0
        gain = learned.gain(penalty, blend)
        centres, weights, reach = learned.bend(gain, width, bending)
        for source, target, path in self.out:
            centred = source - learned.source_mean
            mapped = learned.target_mean + surroundings(centred, self.settings.context) @ gain
            if len(centres):
                mapped = mapped + _bumps(centred, centres, reach) @ weights
            squares += float(((mapped[path[:, 0]] - target[path[:, 1]]) ** 2).sum())
            made += float((np.diff(mapped, axis=0) ** 2).sum()) / max(len(mapped) - 1, 1)
            real += float((np.diff(target, axis=0) ** 2).sum()) / max(len(target) - 1, 1)
        return squares, made, real


def surroundings(frames: Floats, context: int) -> Floats:
    """Each frame, how it differs from what was some frames before, and from what comes; (frames, 3 * components)."""
    places = np.arange(len(frames))
    before = frames[np.maximum(places - context, 0)] - frames
    after = frames[np.minimum(places + context, len(frames) - 1)] - frames
    return np.concatenate([frames, before, after], axis=1)


def _transport(source: Floats, target: Floats) -> Floats:
    """The symmetric matrix that carries one covariance onto another, moving frames as little as can be.

    T = Σx^-½ (Σx^½ Σy Σx^½)^½ Σx^-½ (optimal transport between Gaussians; Dowson & Landau 1982).
    """
    powers, axes = np.linalg.eigh(source)
    powers = np.maximum(powers, max(1e-6 * float(powers.max()), 1e-12))
    root, inverse = (axes * np.sqrt(powers)) @ axes.T, (axes / np.sqrt(powers)) @ axes.T
    inner, turned = np.linalg.eigh(root @ target @ root)
    middle = (turned * np.sqrt(np.maximum(inner, 0))) @ turned.T
    return np.asarray(inverse @ middle @ inverse)


def liveliness_of(made: Floats, real: Floats) -> float:
    """Spread of velocities against the real one's; both of shape (frames, ...)."""
    return float(np.sqrt((np.diff(made, axis=0) ** 2).mean() / max((np.diff(real, axis=0) ** 2).mean(), 1e-12)))


def _clusters(frames: Floats, count: int, seed: int) -> NDArray[np.int32]:
    from sklearn.cluster import KMeans

    count = min(count, len(np.unique(frames, axis=0)))
    labels: NDArray[np.int32] = KMeans(count, n_init=1, random_state=seed).fit(frames).labels_
    return labels


def _bumps(frames: Floats, centres: Floats, reach: float) -> Floats:
    return np.asarray(np.exp(-0.5 * (_distances(frames, centres) / max(reach, 1e-9)) ** 2))


def _distances(a: Floats, b: Floats) -> Floats:
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    return np.asarray(np.sqrt(np.maximum(squares, 0)))
