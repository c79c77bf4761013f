"""Learned co-articulation as Deng et al. 2006 have it: weighting curves between key shapes.

Learning: markers to principal components (`em_pca`), a sample in the middle of each phone (`phone_samples`), weights
of the samples in the frames between them and polynomials through the weights (`curves`), key shapes (`key_visemes`).
Synthesis: Algorithm 1, here computed for all frames at once; `coarticulation_reference` does the same one frame
at a time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.em_pca import EMPCA
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.influence_curves import Curves, WeightPairs, fit_curves, pool, weights_of
from mien.motion.mouth.key_visemes import key_shapes
from mien.motion.mouth.mouth_space import MouthSpace, mouth_space_of
from mien.motion.mouth.phone_samples import SampledUtterance, areas, sample_phones
from mien.motion.mouth.recorded_mouths import recorded_mouths

__all__ = ["Coarticulation", "CoarticulationSettings", "Source", "Step", "blend_weight", "plan"]

MARGIN = 0.5
"""Seconds before and after speech that are learned with it: the way out of a pause and back into one."""

Floats = NDArray[np.float64]
Labels = tuple[str, ...]
Source = Literal["triphone", "diphone", "class", "cosine"]
"""What the motion between two phones was made from."""


@dataclass(frozen=True)
class CoarticulationSettings:
    """Settings of `Coarticulation`; the defaults are the paper's.

    Attributes
    ----------
    components : int
        Dimensions of the pose space.
    degree : int
        Of the polynomials.
    least_pairs : int
        Time-weight pairs that a curve needs; a sequence with fewer counts as unknown.
    blend_mu, blend_n : float
        Of the blend of two triphones (Eq. 10): 0 < mu < 1, n >= 0.
    triphones : bool
        Whether triphones are learned and used.
    key_per_phone : bool
        A key shape per phone in place of one per viseme class.
    class_back_off : bool
        Whether an unknown diphone is made with the curves of its pair of viseme classes, before cosine interpolation
        (past the paper).
    steadiness : float
        How far weights are drawn to those of cosine interpolation (see `weights_of`; past the paper).
    learn_in : {"channels", "markers"} or None
        See `mien.motion.mouth.mouth_space.mouth_space_of`.
    """

    components: int = 5
    degree: int = 3
    least_pairs: int = 12
    blend_mu: float = 0.5
    blend_n: float = 1.0
    triphones: bool = True
    key_per_phone: bool = False
    class_back_off: bool = False
    steadiness: float = 0.0
    learn_in: str | None = None

    def __post_init__(self) -> None:
        if not (0 < self.blend_mu < 1 and self.blend_n >= 0):
            raise InputError(f"blending needs 0 < mu < 1 and n >= 0, not mu {self.blend_mu:g} and n {self.blend_n:g}")


@dataclass(frozen=True)
class Step:
    """What makes the motion between phone ``i`` and phone ``i + 1``.

    Attributes
    ----------
    source : Source
    earlier, later : int or None
        First phone of the triphones that cover it; both where two overlap and are blended.
    """

    source: Source
    earlier: int | None = None
    later: int | None = None


def blend_weight(times: Floats, mu: float, n: float) -> Floats:
    """Weight of the earlier of two overlapping triphones (Eq. 10): 1 at 0, 0 at 1.

    Examples
    --------
    >>> blend_weight(np.array([0.0, 0.5, 1.0]), 0.5, 1.0).tolist()
    [1.0, 0.5, 0.0]
    """
    falling, rising = mu * (1 - times) ** (n + 1), (1 - mu) * times ** (n + 1)
    return np.asarray(falling / (falling + rising))


def plan(labels: Sequence[str], known: Mapping[Labels, object], known_classes: Mapping[Labels, object]) -> list[Step]:
    """Algorithm 1: what is used between each phone and the next.

    Parameters
    ----------
    labels : sequence of str
        Phones.
    known, known_classes : mapping
        Learned diphones and triphones, and pairs of viseme classes.

    Examples
    --------
    >>> [step.source for step in plan(["B", "AA", "T", "S"], {("B", "AA", "T"): 1}, {})]
    ['triphone', 'triphone', 'cosine']
    """
    steps: list[Step] = []
    before: int | None = None  # the triphone that began at the phone before, if there was one
    for place in range(len(labels) - 1):
        if place + 2 < len(labels) and tuple(labels[place : place + 3]) in known:
            steps.append(Step("triphone", before, place))
            before = place
        elif before is not None:
            steps.append(Step("triphone", before))
            before = None
        else:
            steps.append(Step(_of_pair(labels[place], labels[place + 1], known, known_classes)))
    return steps


def _of_pair(start: str, end: str, known: Mapping[Labels, object], classes: Mapping[Labels, object]) -> Source:
    if (start, end) in known:
        return "diphone"
    viseme = articulation_table().viseme_of
    return "class" if (viseme(start), viseme(end)) in classes else "cosine"


@dataclass(frozen=True, eq=False)
class _Learned:
    """Curves by phones."""

    sequences: dict[Labels, Curves] = field(default_factory=dict)
    classes: dict[Labels, Curves] = field(default_factory=dict)


class Coarticulation:
    """Diphone and triphone curves between key shapes.

    Parameters
    ----------
    settings : CoarticulationSettings
    keys : mapping of str to ndarray, or None
        Key shapes by viseme class that were made by hand: markers (markers, 3) in mm, or weights (channels,); the
        others are taken from the recordings.

    Attributes
    ----------
    mouth_ : MouthSpace
        In what it was learned.
    space_ : EMPCA
    keys_ : dict of str to ndarray, shape (components,)
        By phone.
    curves_ : dict of tuple of str to Curves
        Learned diphones and triphones.
    class_curves_ : dict of tuple of str to Curves
        Learned pairs of viseme classes; empty without ``class_back_off``.
    pairs_ : tuple of dict of tuple of str to WeightPairs
        Of all diphones and all triphones, for `fitting_cost` and figures.
    """

    def __init__(
        self, settings: CoarticulationSettings | None = None, keys: Mapping[str, Floats] | None = None
    ) -> None:
        self.settings = settings or CoarticulationSettings()
        self.given_keys = dict(keys or {})

    def fit(self, takes: Sequence[Take]) -> Self:
        """Learn from takes; what does not belong to the mouth is left out.

        Raises
        ------
        InputError
            If there is no take, the takes do not share their markers, or none has a frame with speech.
        """
        self.mouth_: MouthSpace = mouth_space_of(takes, self.settings.learn_in)
        mouths = recorded_mouths(takes, MARGIN, self.mouth_)
        frame_time = 1 / takes[0].markers.rate.fps
        self.space_ = EMPCA(self.settings.components).fit(np.concatenate([mouth.rows for mouth in mouths]))
        said = [sample_phones(mouth, self.space_.encode(mouth.rows), frame_time) for mouth in mouths]
        given = {
            name: self.space_.encode(self.mouth_.rows_from(shape[None]))[0] for name, shape in self.given_keys.items()
        }
        self.keys_ = key_shapes(said, self.settings.key_per_phone, given=given)
        self._fit_curves(said)
        return self

    def _fit_curves(self, said: Sequence[SampledUtterance]) -> None:
        steadiness = self.settings.steadiness
        lengths = (2, 3) if self.settings.triphones else (2,)
        found = [[(a.phones, a.times, weights_of(a, steadiness)) for a in areas(said, count)] for count in lengths]
        self.pairs_ = tuple(pool(instances) for instances in found)
        self.curves_ = {phones: curves for group in self.pairs_ for phones, curves in self._enough(group).items()}
        self.class_curves_: dict[Labels, Curves] = {}
        if self.settings.class_back_off:
            viseme = articulation_table().viseme_of
            by_class = pool((tuple(viseme(phone) for phone in phones), t, w) for phones, t, w in found[0])
            self.class_curves_ = self._enough(by_class)

    def _enough(self, group: Mapping[Labels, WeightPairs]) -> dict[Labels, Curves]:
        least = max(self.settings.least_pairs, self.settings.degree + 1)
        return {
            phones: fit_curves(pairs, self.settings.degree)
            for phones, pairs in group.items()
            if len(pairs.times) >= least
        }

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """The mouth (Algorithm 1): positions of its markers, mm, or weights of its channels, as it was learned.

        Before the first phone's middle and after the last one's its key shape is held.

        Raises
        ------
        InputError
            If a label is no phone.
        """
        times = np.asarray(times, dtype=np.float64)
        labels, middles = [phone.label for phone in phones], np.array([phone.middle for phone in phones])
        if not labels:
            labels, middles = [PAUSE], np.zeros(1)
        _check_labels(labels)
        keys = np.array([self.keys_[label] for label in labels])
        poses = np.empty((len(times), self.settings.components))
        poses[times < middles[0]], poses[times >= middles[-1]] = keys[0], keys[-1]
        for place, step in enumerate(plan(labels, self.curves_, self.class_curves_)):
            inside = (times >= middles[place]) & (times < middles[place + 1])
            if inside.any():
                poses[inside] = self._between(step, place, labels, middles, keys, times[inside])
        return self.mouth_.motion_of(self.space_.decode(poses))

    def _between(
        self, step: Step, place: int, labels: Sequence[str], middles: Floats, keys: Floats, times: Floats
    ) -> Floats:
        """Poses between the middles of phone ``place`` and the next, shape (times, components)."""
        local = (times - middles[place]) / (middles[place + 1] - middles[place])
        if step.source == "triphone":
            made = [
                self._triphone(first, labels, middles, keys, times)
                for first in (step.earlier, step.later)
                if first is not None
            ]
            if len(made) == 1:
                return made[0]
            weight = blend_weight(local, self.settings.blend_mu, self.settings.blend_n)[:, None]
            return np.asarray(weight * made[0] + (1 - weight) * made[1])
        if step.source == "cosine":
            rising = ((1 - np.cos(np.pi * local)) / 2)[:, None]
            return np.asarray((1 - rising) * keys[place] + rising * keys[place + 1])
        pair = (labels[place], labels[place + 1])
        viseme = articulation_table().viseme_of
        curves = (
            self.curves_[pair] if step.source == "diphone" else self.class_curves_[viseme(pair[0]), viseme(pair[1])]
        )
        weights = curves.at(local)
        return np.asarray(weights[:, :1] * keys[place] + weights[:, 1:] * keys[place + 1])

    def _triphone(self, first: int, labels: Sequence[str], middles: Floats, keys: Floats, times: Floats) -> Floats:
        span = middles[first + 2] - middles[first]
        weights = self.curves_[tuple(labels[first : first + 3])].at((times - middles[first]) / span)
        parts = [weights[:, k : k + 1] * keys[first + k] for k in range(3)]
        return np.asarray(parts[0] + parts[1] + parts[2])

    def evidence(self, phones: Tier) -> tuple[Source, ...]:
        """What makes the motion between each phone and the next."""
        return tuple(step.source for step in plan([p.label for p in phones], self.curves_, self.class_curves_))


def _check_labels(labels: Sequence[str]) -> None:
    """Refuse labels that are no phone and no pause."""
    viseme = articulation_table().viseme_of
    for label in set(labels):
        viseme(label)
