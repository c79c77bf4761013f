"""Motion spoken in one emotion, as it would be in another (SPEC B7; Cao et al. 2005, section 5).

Recordings of the same sentences in two emotions are coded in independent components. Components that differ between
the emotions are emotion components, the rest are speech; the speech parts are laid on each other by dynamic time
warping, and the map of the emotion components is learned from the frames that meet.

Two maps are here. `PaperMap` is the paper's: radial basis functions through 250 cluster centres, as wide as the two
closest are apart. That is so narrow that frames between the centres keep their emotion. `EmotionMapping` uses, by
default, an offset and a gain drawn towards "no change but the offset", with wide radial functions on what is left where
they help; all of it is chosen on sentences held out, among maps that keep the motion as lively as the real one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from mien.corpus.corpus import Corpus
from mien.corpus.take import Take
from mien.errors import InputError, Note
from mien.models.anime_graph.audio_distance import warping_path
from mien.models.anime_graph.motion_code import MotionCode

__all__ = [
    "ComponentSplit",
    "EmotionMapping",
    "MappingScore",
    "PaperMap",
    "SteadyMap",
    "corpus_pairs",
    "leave_one_sentence_out",
    "scores_table",
]

Floats = NDArray[np.float64]
Pair = tuple[Floats, Floats]
"""The same sentence in two emotions: marker positions, shapes (frames, markers, 3) and (other frames, markers, 3)."""
Width = Literal["exponential", "gaussian"]

CENTRES = 250
LIVELY = (0.8, 1.2)
"""Spread of velocities that a map may have, as a share of the real one's."""
_PENALTIES = (0.01, 0.1, 1.0, 10.0, 1e3)
_WIDTHS = (1.0, 2.0, 4.0)
_FEW_CENTRES = 40
_SHIFT = 0.5
_SHARE = 0.97


class ComponentMap(Protocol):
    """Emotion components of one emotion in, those of another out; shape (frames, components)."""

    def fit(self, source: Floats, target: Floats, groups: NDArray[np.int64]) -> Self:
        """Learn from frames that meet; ``groups`` says which sentence each is of."""

    def apply(self, source: Floats) -> Floats:
        """Map any frames."""


class SameMap:
    """No change: what every map has to beat."""

    def fit(self, source: Floats, target: Floats, groups: NDArray[np.int64]) -> Self:
        """Nothing to learn."""
        return self

    def apply(self, source: Floats) -> Floats:
        """The same."""
        return source


class OffsetMap:
    """The mean difference, added to every frame."""

    def fit(self, source: Floats, target: Floats, groups: NDArray[np.int64]) -> Self:
        """Learn the difference."""
        self.offset_ = target.mean(axis=0) - source.mean(axis=0)
        return self

    def apply(self, source: Floats) -> Floats:
        """Add it."""
        return np.asarray(source + self.offset_)


class PaperMap:
    """The paper's radial basis functions (Eq. 10, 11): interpolates 250 centres, by LU.

    Parameters
    ----------
    kernel : {"exponential", "gaussian"}
        φ(x) = exp(-x/d) or exp(-x²/d), d the distance of the two closest centres.
    seed : int
        Of k-means.
    """

    def __init__(self, kernel: Width = "exponential", seed: int = 0) -> None:
        self.kernel, self.seed = kernel, seed

    def fit(self, source: Floats, target: Floats, groups: NDArray[np.int64]) -> Self:
        """Cluster the source frames; a centre's target is the mean of its frames' targets."""
        from scipy.linalg import lu_factor, lu_solve

        self.centres_, goals = _clustered(source, target, CENTRES, self.seed)
        apart = _distances(self.centres_, self.centres_)
        others = apart[~np.eye(len(apart), dtype=bool)]
        closest = float(others.min()) if len(others) else 1.0
        self.width_ = max(closest, 1e-9)
        self.weights_ = lu_solve(lu_factor(self._phi(self.centres_)), goals - self.centres_)
        return self

    def _phi(self, frames: Floats) -> Floats:
        x = _distances(frames, self.centres_)
        return np.asarray(np.exp(-(x if self.kernel == "exponential" else x**2) / self.width_))

    def apply(self, source: Floats) -> Floats:
        """e_j = e_i + Σ c_r φ(|e_i - e_i,r|)."""
        return np.asarray(source + self._phi(source) @ self.weights_)


class SteadyMap:
    """Offset, a gain drawn towards the identity, and wide radial functions on what is left.

    Parameters
    ----------
    seed : int

    Attributes
    ----------
    penalty_ : float
        How strongly the gain is drawn to the identity: 1000 is a constant offset in all but name.
    width_ : float
        Width of the radial functions in units of the source's spread; 0: none.
    liveliness_ : float
        Spread of velocities against the real one's, on sentences held out.
    """

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed

    def fit(self, source: Floats, target: Floats, groups: NDArray[np.int64]) -> Self:
        """Choose penalty and width on sentences held out (halves of one, if there is but one), then learn from all."""
        if len(np.unique(groups)) < 2:
            groups = (np.arange(len(source)) >= len(source) // 2).astype(np.int64)
        plain = [(*self._judge(source, target, groups, p, 0.0), (p, 0.0)) for p in _PENALTIES]
        # Where no map is as lively as the real motion, the offset alone leaves it as lively as it was.
        best = min([entry for entry in plain if _is_lively(entry[1])], default=plain[-1])
        bent = [(*self._judge(source, target, groups, best[2][0], w), (best[2][0], w)) for w in _WIDTHS]
        _, self.liveliness_, (self.penalty_, self.width_) = min([best, *(e for e in bent if _is_lively(e[1]))])
        return self._learn(source, target, self.penalty_, self.width_)

    def _judge(
        self, source: Floats, target: Floats, groups: NDArray[np.int64], penalty: float, width: float
    ) -> tuple[float, float]:
        """Mean square error and liveliness on sentences held out."""
        errors, made, real = [], [], []
        for group in np.unique(groups):
            out = groups == group
            mapped = SteadyMap(self.seed)._learn(source[~out], target[~out], penalty, width).apply(source[out])
            errors.append(((mapped - target[out]) ** 2).sum(axis=1))
            made.append(np.diff(mapped, axis=0))
            real.append(np.diff(target[out], axis=0))
        speed = np.sqrt((np.concatenate(made) ** 2).mean() / max((np.concatenate(real) ** 2).mean(), 1e-12))
        return float(np.concatenate(errors).mean()), float(speed)

    def _learn(self, source: Floats, target: Floats, penalty: float, width: float) -> Self:
        self.from_, self.to_ = np.asarray(source.mean(axis=0)), np.asarray(target.mean(axis=0))
        centred, wanted = source - self.from_, target - self.to_
        identity = np.eye(source.shape[1])
        # Ridge towards the identity: min |X G - Y|² + penalty·n |G - I|²
        gram = centred.T @ centred / len(source)
        scale = penalty * max(float(np.trace(gram)) / len(gram), 1e-12)
        cross = centred.T @ wanted / len(source)
        self.gain_ = np.linalg.solve(gram + scale * identity, cross + scale * identity)
        self.width = width * float(np.sqrt((centred**2).sum(axis=1).mean()))
        self.centres_: Floats = np.zeros((0, source.shape[1]))
        self.weights_: Floats = np.zeros((0, source.shape[1]))
        if width:
            left = wanted - centred @ self.gain_
            self.centres_, goals = _clustered(centred, left, min(_FEW_CENTRES, max(2, len(source) // 20)), self.seed)
            phi = self._phi(self.centres_)
            self.weights_ = np.asarray(np.linalg.solve(phi + np.eye(len(phi)), goals), dtype=np.float64)
        return self

    def _phi(self, centred: Floats) -> Floats:
        return np.asarray(np.exp(-0.5 * (_distances(centred, self.centres_) / max(self.width, 1e-9)) ** 2))

    def apply(self, source: Floats) -> Floats:
        """Map frames."""
        centred = source - self.from_
        mapped = self.to_ + centred @ self.gain_
        return np.asarray(mapped + self._phi(centred) @ self.weights_ if len(self.centres_) else mapped)


def _is_lively(spread: float) -> bool:
    return LIVELY[0] <= spread <= LIVELY[1]


def _clustered(source: Floats, target: Floats, count: int, seed: int) -> tuple[Floats, Floats]:
    from sklearn.cluster import KMeans

    count = min(count, len(np.unique(source, axis=0)))
    labels = KMeans(count, n_init=1, random_state=seed).fit(source).labels_
    used = np.unique(labels)
    return (
        np.array([source[labels == one].mean(axis=0) for one in used]),
        np.array([target[labels == one].mean(axis=0) for one in used]),
    )


def _distances(a: Floats, b: Floats) -> Floats:
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    return np.asarray(np.sqrt(np.maximum(squares, 0)))


@dataclass(frozen=True)
class ComponentSplit:
    """Which independent components carry emotion, and why.

    Attributes
    ----------
    shift : tuple of float
        Mean over sentences of the difference between the emotions, in standard deviations of the component.
    significance : tuple of float
        p of that difference over sentences (t-test against 0; 1 where a single sentence leaves it open).
    is_emotion : tuple of bool
    """

    shift: tuple[float, ...]
    significance: tuple[float, ...]
    is_emotion: tuple[bool, ...]

    def __str__(self) -> str:
        rows = [
            f"{number:2}  {'emotion' if e else 'speech ':7}  shift {s:+.2f}  p {p:.3f}"
            for number, (s, p, e) in enumerate(zip(self.shift, self.significance, self.is_emotion, strict=True))
        ]
        return "\n".join(rows)


class EmotionMapping:
    """From one emotion to another.

    Parameters
    ----------
    component_map : ComponentMap, optional
        `SteadyMap` unless given.
    share : float
        Of the variance that the components keep.
    seed : int

    Attributes
    ----------
    code_ : MotionCode
    split_ : ComponentSplit
    map_ : ComponentMap
    met_ : tuple of ndarray
        Emotion components of the frames that meet, and the sentence of each: what the map was learned from.
    """

    def __init__(self, component_map: ComponentMap | None = None, share: float = _SHARE, seed: int = 0) -> None:
        self.component_map, self.share, self.seed = component_map, share, seed

    def fit(self, pairs: Sequence[Pair]) -> Self:
        """Learn from sentences that were spoken in both emotions.

        Raises
        ------
        InputError
            If there is no pair, or shapes or numbers do not fit.
        """
        _check(pairs)
        self.code_ = MotionCode(self.share, self.seed).fit(np.concatenate([_flat(m) for pair in pairs for m in pair]))
        coded = [(self._components(a), self._components(b)) for a, b in pairs]
        self.split_ = split_components(coded)
        emotion = np.array(self.split_.is_emotion)
        met = [meeting_frames(a[:, ~emotion], b[:, ~emotion]) for a, b in coded]
        source = np.concatenate([a[:, emotion][path[:, 0]] for (a, _), path in zip(coded, met, strict=True)])
        target = np.concatenate([b[:, emotion][path[:, 1]] for (_, b), path in zip(coded, met, strict=True)])
        groups = np.concatenate([np.full(len(path), i) for i, path in enumerate(met)])
        self.met_ = (source, target, groups)
        self.map_ = (self.component_map or SteadyMap(self.seed)).fit(*self.met_)
        return self

    def _components(self, motion: Floats) -> Floats:
        return self.code_.separate(self.code_.encode(_flat(motion)))

    def apply(self, motion: Floats) -> Floats:
        """The same speech in the other emotion; positions of shape (frames, markers, 3) in and out.

        What the components do not hold stays as it was.
        """
        components = self._components(motion)
        emotion = np.array(self.split_.is_emotion)
        changed = components.copy()
        changed[:, emotion] = self.map_.apply(components[:, emotion])
        difference = self.code_.mix(changed - components) @ self.code_.axes_
        return np.asarray(motion + difference.reshape(motion.shape))


def split_components(coded: Sequence[Pair]) -> ComponentSplit:
    """Tell emotion components from speech: those whose mean differs between the emotions, over sentences.

    A component is an emotion component if it moves by half a standard deviation or more, and, with three sentences or
    more, by more than chance (p < 0.01). If none does, the one that moves most is.
    """
    from scipy.stats import ttest_1samp

    spread = np.concatenate([np.concatenate([a - a.mean(axis=0), b - b.mean(axis=0)]) for a, b in coded]).std(axis=0)
    moved = np.array([b.mean(axis=0) - a.mean(axis=0) for a, b in coded]) / np.maximum(spread, 1e-9)
    shift = moved.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        chance = ttest_1samp(moved, 0.0, axis=0).pvalue if len(coded) >= 3 else np.ones(len(shift))
    chance = np.nan_to_num(np.asarray(chance), nan=1.0)
    is_emotion = (np.abs(shift) >= _SHIFT) & ((chance < 0.01) | (len(coded) < 3))
    if not is_emotion.any():
        is_emotion[np.abs(shift).argmax()] = True
    if is_emotion.all() and len(is_emotion) > 1:
        is_emotion[np.abs(shift).argmin()] = False
    return ComponentSplit(tuple(shift.tolist()), tuple(chance.tolist()), tuple(is_emotion.tolist()))


def meeting_frames(a: Floats, b: Floats) -> NDArray[np.int64]:
    """Pairs of frames that say the same, shape (steps, 2): dynamic time warping of centred components."""
    return warping_path(a - a.mean(axis=0), b - b.mean(axis=0))


@dataclass(frozen=True)
class MappingScore:
    """How near a map comes to the real recording of a sentence it did not learn from.

    Attributes
    ----------
    rms : float
        Root of the mean square distance of markers after both are scaled into the unit cube.
    share : float
        Share of the true change that the map makes: its change along the true one. 0: none, 1: all of it.
    liveliness : float
        Spread of velocities against the real one's.
    """

    rms: float
    share: float
    liveliness: float


def leave_one_sentence_out(pairs: Sequence[Pair], seed: int = 0) -> dict[str, MappingScore]:
    """Each map learned without one sentence and judged on it, averaged; beside identity and mean offset.

    Raises
    ------
    InputError
        If there are fewer than two sentences.
    """
    if len(pairs) < 2:
        raise InputError("leaving a sentence out takes at least two sentences")
    maps: dict[str, Callable[[], ComponentMap]] = {
        "no change": SameMap,
        "mean offset": OffsetMap,
        "Cao et al. 2005, exponential": lambda: PaperMap("exponential", seed),
        "Cao et al. 2005, gaussian": lambda: PaperMap("gaussian", seed),
        "mien": lambda: SteadyMap(seed),
    }
    scores: dict[str, list[MappingScore]] = {name: [] for name in maps}
    for number, pair in enumerate(pairs):
        known = [other for i, other in enumerate(pairs) if i != number]
        learned = EmotionMapping(SameMap(), seed=seed).fit(known)
        for name, make in maps.items():
            learned.map_ = make().fit(*learned.met_)
            scores[name].append(score_mapping(learned, pair))
    return {
        name: MappingScore(*(float(np.mean([getattr(s, k) for s in found])) for k in ("rms", "share", "liveliness")))
        for name, found in scores.items()
    }


def scores_table(scores: Mapping[str, MappingScore]) -> str:
    """The scores as a table in Markdown."""
    lines = ["| map | RMS in the unit cube | share of the true change | liveliness |", "| --- | ---: | ---: | ---: |"]
    lines += [f"| {name} | {s.rms:.4f} | {s.share:.2f} | {s.liveliness:.2f} |" for name, s in scores.items()]
    return "\n".join(lines)


def corpus_pairs(corpus: Corpus, source: str, target: str) -> tuple[list[Pair], tuple[Note, ...]]:
    """Takes of a corpus that say the same sentence in two emotions.

    Of several takes of a sentence in one emotion the first counts. A pair with a marker missing in some frame is left
    out, with a note.

    Raises
    ------
    InputError
        If no sentence was recorded in both emotions.
    """
    found: dict[tuple[str, str], dict[str, Take]] = {}
    for name in corpus.names:
        take = corpus.take(name)
        if take.sentence and take.emotion in (source, target):
            found.setdefault((take.speaker, take.sentence), {}).setdefault(take.emotion, take)
    both = [(e[source].markers, e[target].markers) for e in found.values() if source in e and target in e]
    whole = [(a, b) for a, b in both if np.isfinite(a.positions).all() and np.isfinite(b.positions).all()]
    if not whole:
        raise InputError(
            f"{corpus.folder}: no sentence was recorded both in {source!r} and in {target!r}, with all markers seen "
            "(takes of one sentence share a value in the manifest's column 'sentence')"
        )
    left = len(both) - len(whole)
    notes = (Note("warning", f"{left} sentences are left out: a marker is missing in some frame"),) if left else ()
    return [(a.positions, b.positions) for a, b in whole], notes


def score_mapping(learned: EmotionMapping, pair: Pair) -> MappingScore:
    """Judge a map on one sentence, in the frames that meet."""
    source, target = pair
    emotion = np.array(learned.split_.is_emotion)
    a, b = (learned._components(motion)[:, ~emotion] for motion in pair)
    path = meeting_frames(a, b)
    mapped, real, was = learned.apply(source)[path[:, 0]], target[path[:, 1]], source[path[:, 0]]
    side = float((target.max(axis=(0, 1)) - target.min(axis=(0, 1))).max())
    rms = float(np.sqrt(((mapped - real) ** 2).sum(axis=2).mean())) / max(side, 1e-9)
    wanted = real - was
    share = float(((mapped - was) * wanted).sum() / max((wanted**2).sum(), 1e-12))
    made, true = np.diff(learned.apply(source), axis=0), np.diff(target, axis=0)
    return MappingScore(rms, share, float(np.sqrt((made**2).mean() / max((true**2).mean(), 1e-12))))


def _flat(motion: Floats) -> Floats:
    return np.asarray(motion, dtype=np.float64).reshape(len(motion), -1)


def _check(pairs: Sequence[Pair]) -> None:
    if not pairs:
        raise InputError("a map between emotions is learned from sentences spoken in both; there is none")
    for number, pair in enumerate(pairs):
        for motion in pair:
            if motion.ndim != 3 or motion.shape[1:] != pairs[0][0].shape[1:] or len(motion) < 3:
                raise InputError(
                    f"sentence {number}: expected (frames, markers, 3) as in the first, got {motion.shape}"
                )
            if not np.isfinite(motion).all():
                raise InputError(f"sentence {number}: a marker is missing in some frame: clean the recording first")
