"""Motion spoken in one emotion, as it would be in another (Cao et al. 2005, section 5).

Recordings of the same sentences in two emotions are coded in independent components. Components whose mean or whose
spread differs between the emotions are emotion components, the rest are speech; the speech parts are laid on each other
by dynamic time warping, and a map is learned from the frames that meet (`mien.motion.maps.emotion_component_maps`).

The paper maps the emotion components by radial basis functions through 250 cluster centres, as wide as the two closest
are apart: so narrow that frames between the centres keep their emotion. mien's map, the default, is an offset, a gain
on all components and a bend, chosen on sentences held out among maps that keep the motion as lively as the real one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.motion.drift import smooth_drift
from mien.motion.graph.motion_code import MotionCode
from mien.motion.maps.emotion_component_maps import (
    ComponentMap,
    LivelyMap,
    MeetingFrames,
    OffsetMap,
    PaperMap,
    SameMap,
    liveliness_of,
)
from mien.motion.warping import warping_path

__all__ = [
    "ComponentSplit",
    "EmotionMapping",
    "MappingScore",
    "Pair",
    "corpus_pairs",
    "leave_one_sentence_out",
    "meeting_frames",
    "score_mapping",
    "scores_table",
    "split_components",
]

Floats = NDArray[np.float64]
Pair = tuple[Floats, Floats]
"""The same sentence in two emotions: marker positions, shapes (frames, markers, 3) and (other frames, markers, 3)."""

_SHIFT = 0.5
_SPREAD = 1.25
_CHANCE = 0.01
_SHARE = 0.97
_MOST_FRAMES = 6000
"""Frames that the components are learned from, evenly spread."""


@dataclass(frozen=True)
class ComponentSplit:
    """Which independent components carry emotion, and why.

    Attributes
    ----------
    shift : tuple of float
        Mean over sentences of the difference between the emotions, in standard deviations of the component.
    significance : tuple of float
        p of that difference over sentences (t-test against 0; 1 where a single sentence leaves it open).
    spread : tuple of float
        How many times as far the component moves about its mean in the other emotion (geometric mean over sentences).
    spread_significance : tuple of float
        p of that over sentences (t-test of the logarithm).
    is_emotion : tuple of bool
    """

    shift: tuple[float, ...]
    significance: tuple[float, ...]
    spread: tuple[float, ...]
    spread_significance: tuple[float, ...]
    is_emotion: tuple[bool, ...]

    def __str__(self) -> str:
        columns = zip(
            self.shift, self.significance, self.spread, self.spread_significance, self.is_emotion, strict=True
        )
        rows = [
            f"{number:2}  {'emotion' if e else 'speech ':7}  shift {s:+.2f}  p {p:.3f}  spread x {w:.2f}  p {q:.3f}"
            for number, (s, p, w, q, e) in enumerate(columns)
        ]
        return "\n".join(rows)


class EmotionMapping:
    """From one emotion to another.

    Parameters
    ----------
    component_map : ComponentMap, optional
        `LivelyMap` unless given.
    share : float
        Of the variance that the components keep.
    seed : int

    Attributes
    ----------
    code_ : MotionCode
    split_ : ComponentSplit
    map_ : ComponentMap
    met_ : MeetingFrames
        What the map was learned from.
    wander_ : ndarray, shape (components, components)
        What the map leaves out of the real motion, as one deviation of independent wanderings in principal components:
        as much as is lacking until velocities spread as the real ones do.
    memory_ : float
        Frames after which it has lost two thirds of its memory.
    beside_ : ndarray, shape (dimensions,)
        Mean difference of what the components do not hold, mm; 0 where the map is the paper's or none.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> said = [np.cumsum(random.normal(size=(60, 4, 3)), axis=0) for _ in range(3)]
    >>> learned = EmotionMapping().fit([(motion, motion + [0.0, 5.0, 0.0]) for motion in said])
    >>> (learned.apply(said[0]) - said[0]).mean(axis=(0, 1)).round().astype(int).tolist()
    [0, 5, 0]
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
        rows = np.concatenate([_flat(motion) for pair in pairs for motion in pair])
        self.code_ = MotionCode(self.share, self.seed).fit(rows[:: -(-len(rows) // _MOST_FRAMES)])
        coded = [(self._components(a), self._components(b)) for a, b in pairs]
        self.split_ = split_components(coded)
        spoken = self._spoken()
        met = [meeting_frames(a @ spoken, b @ spoken) for a, b in coded]
        sentences = [(a, b, path) for (a, b), path in zip(coded, met, strict=True)]
        self.met_ = MeetingFrames(sentences, self.code_.mixing_, np.array(self.split_.is_emotion))
        left = [(self._left(a)[path[:, 0]], self._left(b)[path[:, 1]]) for (a, b), path in zip(pairs, met, strict=True)]
        self._beside = np.concatenate([b - a for a, b in left]).mean(axis=0)
        return self.learn_map(self.component_map or LivelyMap(seed=self.seed))

    def learn_map(self, component_map: ComponentMap) -> Self:
        """Learn another map from the same frames."""
        self.map_ = component_map.fit(self.met_)
        self.wander_, self.memory_ = _wander(self.met_, self.map_)
        self.beside_ = self._beside if isinstance(self.map_, OffsetMap | LivelyMap) else np.zeros_like(self._beside)
        return self

    def _components(self, motion: Floats) -> Floats:
        return self.code_.separate(self.code_.encode(_flat(motion)))

    def _left(self, motion: Floats) -> Floats:
        """What the components do not hold, shape (frames, dimensions)."""
        return _flat(motion) - self.code_.decode(self.code_.encode(_flat(motion)))

    def _spoken(self) -> Floats:
        """What tells where in the sentence a frame stands: the speech components, mm.

        Where words hardly move them, also those emotion components whose mean stays.
        """
        speech = ~np.array(self.split_.is_emotion)
        powers = (self.code_.mixing_**2).sum(axis=1)
        if powers[speech].sum() < 0.3 * powers.sum():
            speech |= np.abs(np.array(self.split_.shift)) < _SHIFT
        return np.asarray(self.code_.mixing_ * speech[:, None])

    def apply(self, motion: Floats, random: np.random.Generator | None = None) -> Floats:
        """The same speech in the other emotion; positions of shape (frames, markers, 3) in and out.

        Of what the components do not hold the mean difference is added: brows move little beside a jaw. With
        ``random``, what cannot be told from the source is drawn from what the recordings had of it, so that the motion
        is as lively as they were.
        """
        components = self._components(motion)
        change = self.code_.mix(self.map_.apply(components) - components)
        if random is not None and self.wander_.any():
            frames = np.arange(len(motion), dtype=np.float64)
            drawn = [smooth_drift(frames, self.memory_, random) for _ in range(len(self.wander_))]
            change = change + np.stack(drawn, axis=1) @ self.wander_
        return np.asarray(motion + (change @ self.code_.axes_ + self.beside_).reshape(motion.shape))


def _wander(met: MeetingFrames, learned: ComponentMap) -> tuple[Floats, float]:
    """What is lacking of the real motion, as deviations of drifts of deviation 1, and its memory in frames."""
    made, real, left, kept = 0.0, 0.0, [], []
    for source, target, path in met.sentences:
        mapped = learned.apply(source) @ met.mixing
        true = target @ met.mixing
        made += float((np.diff(mapped, axis=0) ** 2).sum(axis=1).mean())
        real += float((np.diff(true, axis=0) ** 2).sum(axis=1).mean())
        missed = true[path[:, 1]] - mapped[path[:, 0]]
        centred = missed - missed.mean(axis=0)
        left.append(centred)
        kept.append([float((centred[lag:] * centred[: len(centred) - lag]).sum()) for lag in range(min(len(path), 60))])
    rows = np.concatenate(left)
    longest = min(map(len, kept))
    decay = np.sum([k[:longest] for k in kept], axis=0)
    below = np.flatnonzero(decay < decay[0] / np.e) if decay[0] > 0 else np.zeros(0)
    memory = max(float(below[0]) if len(below) else float(longest), 2.0)
    covariance = rows.T @ rows / len(rows)
    # A drift of deviation 1 and memory m has velocities of about sqrt(2) * 0.7 / m a frame (Gaussian autocorrelation).
    speed = float(np.trace(covariance)) * 2.0 / memory**2
    size = np.sqrt(min(max(real - made, 0.0) / len(met.sentences) / max(speed, 1e-12), 1.0))
    powers, axes = np.linalg.eigh(covariance)
    return np.asarray(size * np.sqrt(np.maximum(powers, 0))[:, None] * axes.T), memory


def split_components(coded: Sequence[Pair]) -> ComponentSplit:
    """Tell emotion components from speech: those whose mean or spread differs between the emotions, over sentences.

    A component is an emotion component if it moves by half a standard deviation or more, or if its spread is 1.25 times
    as large or as small; with three sentences or more, only by more than chance (p < 0.01). If none is, the one that
    moves most is; if all are, the one that moves least is not.
    """
    centred = np.concatenate([np.concatenate([a - a.mean(axis=0), b - b.mean(axis=0)]) for a, b in coded])
    moved = np.array([b.mean(axis=0) - a.mean(axis=0) for a, b in coded]) / np.maximum(centred.std(axis=0), 1e-9)
    wider = np.array([np.log(np.maximum(b.std(axis=0), 1e-9) / np.maximum(a.std(axis=0), 1e-9)) for a, b in coded])
    (shift, chance), (spread, spread_chance) = (_over_sentences(values) for values in (moved, wider))
    few = len(coded) < 3
    is_emotion = (np.abs(shift) >= _SHIFT) & ((chance < _CHANCE) | few)
    is_emotion |= (np.abs(spread) >= np.log(_SPREAD)) & (spread_chance < _CHANCE)
    if not is_emotion.any():
        is_emotion[np.abs(shift).argmax()] = True
    if is_emotion.all() and len(is_emotion) > 1:
        is_emotion[np.abs(shift).argmin()] = False
    shift_, p, ratio, ratio_p = (tuple(column.tolist()) for column in (shift, chance, np.exp(spread), spread_chance))
    return ComponentSplit(shift_, p, ratio, ratio_p, tuple(is_emotion.tolist()))


def _over_sentences(values: Floats) -> tuple[Floats, Floats]:
    """Mean over sentences, and p of its being 0 (1 where there are fewer than three)."""
    from scipy.stats import ttest_1samp

    if len(values) < 3:
        return values.mean(axis=0), np.ones(values.shape[1])
    varies = values.std(axis=0) > 1e-9
    chance = np.where(np.abs(values.mean(axis=0)) > 1e-6, 0.0, 1.0)  # the same in every sentence: no chance
    chance[varies] = ttest_1samp(values[:, varies], 0.0, axis=0).pvalue
    return values.mean(axis=0), chance


def meeting_frames(a: Floats, b: Floats) -> NDArray[np.int64]:
    """Pairs of frames that say the same, shape (steps, 2): dynamic time warping of motion of one mean and spread."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return warping_path(a, b * float(np.sqrt((a**2).mean() / max((b**2).mean(), 1e-12))))


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

    ``mien, wandering`` is mien's map with what cannot be told from the source drawn at random: as lively as the
    recordings, and therefore further from any one of them.

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
        "mien": lambda: LivelyMap(seed=seed),
    }
    scores: dict[str, list[MappingScore]] = {name: [] for name in (*maps, "mien, wandering")}
    random = np.random.default_rng(seed)
    for number, pair in enumerate(pairs):
        known = [other for i, other in enumerate(pairs) if i != number]
        learned = EmotionMapping(SameMap(), seed=seed).fit(known)
        for name, make in maps.items():
            learned.learn_map(make())
            scores[name].append(score_mapping(learned, pair))
        scores["mien, wandering"].append(score_mapping(learned, pair, random))
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


def score_mapping(learned: EmotionMapping, pair: Pair, random: np.random.Generator | None = None) -> MappingScore:
    """Judge a map on one sentence, in the frames that meet; ``random`` as in `EmotionMapping.apply`."""
    source, target = pair
    spoken = learned._spoken()
    path = meeting_frames(*(learned._components(motion) @ spoken for motion in pair))
    changed = learned.apply(source, random)
    mapped, real, was = changed[path[:, 0]], target[path[:, 1]], source[path[:, 0]]
    side = float((target.max(axis=(0, 1)) - target.min(axis=(0, 1))).max())
    rms = float(np.sqrt(((mapped - real) ** 2).sum(axis=2).mean())) / max(side, 1e-9)
    wanted = real - was
    share = float(((mapped - was) * wanted).sum() / max((wanted**2).sum(), 1e-12))
    return MappingScore(rms, share, liveliness_of(changed, target))


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
