"""`SpeechMotion`: phones in, the mouth in motion out; the learned mouth that ships.

Influence curves (`influence`) carry the motion and can be looked at and edited; a small network (`correction`) adds a
share of the difference between its own answer and theirs; the motion is made as large and as quick as recorded
(`mien.motion.mouth.spread`); closures are then held (`lip_closure`). On words that were
never learned the two together are better than either alone (docs/results.md).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.corpus.take import Take
from mien.motion.em_pca import EMPCA
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.correction import Correction, CorrectionSettings
from mien.motion.mouth.coverage import Coverage, Evidence
from mien.motion.mouth.influence import REFERENCE_DURATION, InfluenceCurves, InfluenceSettings, describe_parts
from mien.motion.mouth.lip_closure import LipClosure
from mien.motion.mouth.mouth_space import MouthSpace, mouth_space_of
from mien.motion.mouth.recorded_mouths import RecordedMouth, recorded_mouths
from mien.motion.mouth.spread import RecordedSpread, instants_about
from mien.motion.mouth.starting_point import StartingPoint, joined_space

__all__ = ["SpeechMotion", "SpeechMotionSettings"]

MARGIN = 0.32
"""Seconds before and after speech that are learned with it: as far as the correction looks, so that it has seen frames
with nothing but silence about them and shuts the mouth in long pauses. (0.12 s scores 0.01 mm better on unseen takes
and leaves the lips 2 mm apart in a pause.)"""

SPREAD_TAKES = 200
"""Takes on which the size of the motion is measured, at most."""
BLOCK = 512
"""Frames that are synthesised at once, which bounds the memory."""
SIGHT = 2.0
"""Seconds within which phones count; the nearest ones count from farther away, too."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SpeechMotionSettings:
    """Settings of `SpeechMotion`.

    Attributes
    ----------
    components : int
        Dimensions of the pose space.
    correction_share : float
        Weight of the network against the influence curves, 0..1; 0 leaves the explicit curves alone.
    hold_closures : bool
        Whether the lips are drawn shut at bilabials after synthesis.
    as_recorded : bool
        Whether the motion is made as large and as quick as recorded (`mien.motion.mouth.spread`).
    learn_in : {"channels", "markers"} or None
        See `mien.motion.mouth.mouth_space.mouth_space_of`.
    influence : InfluenceSettings
    correction : CorrectionSettings
    """

    components: int = 12
    correction_share: float = 0.65
    hold_closures: bool = True
    as_recorded: bool = True
    learn_in: str | None = None
    influence: InfluenceSettings = field(default_factory=InfluenceSettings)
    correction: CorrectionSettings = field(default_factory=CorrectionSettings)


class SpeechMotion:
    """Mouth motion from phones, learned from recorded takes.

    Parameters
    ----------
    settings : SpeechMotionSettings

    Attributes
    ----------
    mouth_ : MouthSpace
        What `synthesise` returns: channels or markers of the mouth.
    space_ : EMPCA
    curves_ : InfluenceCurves
    correction_ : Correction or None
        None if its share is 0.
    spread_ : RecordedSpread or None
        None if the motion is left as the models answer.
    closure_ : LipClosure
    coverage_ : Coverage
    edits_ : dict of str to ndarray, shape (parts, strands)
        What `with_key_shape` added to the targets of a phone.
    delays_ : ndarray, shape (components,)
        Seconds by which components come later than the models answer (`mien.motion.mouth.starting_point`).
    """

    def __init__(self, settings: SpeechMotionSettings | None = None) -> None:
        self.settings = settings or SpeechMotionSettings()
        self.edits_: dict[str, Floats] = {}
        self.delays_: Floats = np.zeros(self.settings.components)

    @property
    def epochs(self) -> int:
        """Passes through the frames that `fit` makes in all."""
        correction = self.settings.correction
        networks = correction.networks if self.settings.correction_share > 0 else 0
        return self.settings.influence.epochs + networks * correction.epochs

    def fit(
        self, takes: Sequence[Take], after_epoch: Callable[[], None] = lambda: None, prior: SpeechMotion | None = None
    ) -> Self:
        """Learn from takes; what does not belong to the mouth is left out.

        Parameters
        ----------
        takes : sequence of Take
        after_epoch : callable
            Called `epochs` times, to show progress.
        prior : SpeechMotion or None
            Of somebody else, to start from (`mien.motion.mouth.starting_point`): the settings are its own then.

        Raises
        ------
        InputError
            If there is no take, the takes do not share their markers, or none has a frame with speech.
        """
        self.mouth_: MouthSpace
        if prior is None:
            self.mouth_ = mouth_space_of(takes, self.settings.learn_in)
            mouths, start = recorded_mouths(takes, MARGIN, self.mouth_), None
        else:
            self.settings, space = prior.settings, joined_space(prior, takes)
            mouths = recorded_mouths(takes, MARGIN, space)
            self.mouth_, start = space, StartingPoint.of(prior, mouths, space)
            self.edits_, self.delays_ = dict(prior.edits_), start.delays
        rows = np.concatenate([mouth.rows for mouth in mouths])
        emphasis = self.mouth_.emphasis()
        self.space_ = EMPCA(self.settings.components).fit(rows, emphasis) if start is None else start.space
        components = self.space_.encode(rows) if start is None else self._undelayed(rows, mouths, start.edits)
        curves = InfluenceCurves(self.settings.influence)
        placed = [curves.place(mouth.phones, mouth.times) for mouth in mouths]
        self.curves_ = curves.fit(placed, components, after_epoch, None if start is None else start.curves)
        self.correction_: Correction | None = None
        if self.settings.correction_share > 0:
            correction = Correction(self.settings.correction)
            seen = np.concatenate([correction.describe(m.phones, m.times).astype(np.float32) for m in mouths])
            self.correction_ = correction.fit(
                seen, components, after_epoch, None if start is None else start.correction
            )
        self.spread_ = self._spread_of(mouths) if self.settings.as_recorded else None
        self.closure_ = LipClosure(self.mouth_).fit(mouths, None if start is None else start.closure)
        self.coverage_ = Coverage().fit([mouth.phones for mouth in mouths])
        if prior is not None:
            self.coverage_ = self.coverage_.joined(prior.coverage_)
        return self

    def _undelayed(self, rows: Floats, mouths: Sequence[RecordedMouth], edits: Floats) -> Floats:
        """Components that curves and networks have to answer: without edits, and as early as they are."""
        components = self.space_.encode(rows) - edits
        begin = 0
        for mouth in mouths:
            own = slice(begin, begin + len(mouth.times))
            begin = own.stop
            for number in np.flatnonzero(self.delays_):
                later = mouth.times + self.delays_[number]
                components[own, number] = np.interp(later, mouth.times, components[own, number])
        return components

    def explicit(self, takes: Sequence[Take]) -> SpeechMotion:
        """The influence curves of this model alone, as if they had been learned from the same takes without network."""
        alone = copy(self)
        alone.settings, alone.correction_ = replace(self.settings, correction_share=0.0), None
        if self.settings.as_recorded:
            alone.spread_ = alone._spread_of(recorded_mouths(takes, MARGIN, self.mouth_))
        return alone

    def _spread_of(self, mouths: Sequence[RecordedMouth]) -> RecordedSpread:
        """Gain and sharpness, from no more than `SPREAD_TAKES` takes."""
        chosen = mouths[:: -(-len(mouths) // SPREAD_TAKES)]
        recorded = [self.space_.encode(mouth.rows) for mouth in chosen]
        answered = [self.components(mouth.phones, instants_about(mouth.times)) for mouth in chosen]
        rest = self.mouth_.rest()
        return RecordedSpread().fit(recorded, answered, None if rest is None else self.space_.encode(rest[None])[0])

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """The mouth in motion.

        Parameters
        ----------
        phones : Tier
            ARPAbet phones without stress, pauses as ``SIL``; outside it there is silence.
        times : ndarray, shape (frames,)
            Seconds.

        Returns
        -------
        ndarray, shape (frames, channels) or (frames, markers, 3)
            Weights 0..1, or millimetres in the axes of the takes (`mouth_`).

        Raises
        ------
        InputError
            If a label is no phone.
        """
        times = np.asarray(times, dtype=np.float64)
        return self.finished(lambda instants: self.components(phones, instants), phones, times)

    def finished(
        self,
        answer: Callable[[Floats], Floats],
        phones: Tier,
        times: Floats,
        spread: RecordedSpread | None = None,
    ) -> Floats:
        """From components to the mouth in motion: as large and as quick as recorded, closures held.

        Parameters
        ----------
        answer : callable
            Components at given instants.
        phones, times
            As in `synthesise`.
        spread : RecordedSpread or None
            None takes the model's own.
        """
        spread = spread or self.spread_
        components = answer(times) if spread is None else spread.of(answer, times)
        del answer  # it may hold much
        rows = self.space_.decode(components)
        del components
        return self.mouth_.motion_of(self.closure_.hold(rows, phones, times) if self.settings.hold_closures else rows)

    def components(self, phones: Tier, times: Floats) -> Floats:
        """Components of the pose in `space_`, closures not held, shape (frames, components)."""
        if len(times) > BLOCK:
            blocks = [times[first : first + BLOCK] for first in range(0, len(times), BLOCK)]
            return np.concatenate([self.components(self._about(phones, block), block) for block in blocks])
        answer = np.empty((len(times), len(self.delays_)))
        for delay in np.unique(self.delays_):
            answer[:, self.delays_ == delay] = self._answered(phones, times - delay)[:, self.delays_ == delay]
        return answer

    def _about(self, phones: Tier, times: Floats) -> Tier:
        """The phones that can be seen from some instants: all of an hour would be looked through for every block."""
        more = self.settings.influence.neighbours + 1
        first = bisect_left(phones.intervals, times.min() - SIGHT, key=lambda phone: phone.end) - more
        after = bisect_right(phones.intervals, times.max() + SIGHT, key=lambda phone: phone.start) + more
        whole = first <= 0 and after >= len(phones)
        return phones if whole else Tier(phones.name, phones.intervals[max(first, 0) : after])

    def _answered(self, phones: Tier, times: Floats) -> Floats:
        """What curves and networks answer."""
        parts = self.curves_.place(phones, times)
        learned = self.curves_.components(parts)
        share = self.settings.correction_share
        answer = learned
        if self.correction_ is not None:
            seen = self.correction_.describe(phones, times)
            answer = learned + share * (self.correction_.components(seen) - learned)
        if self.edits_:
            answer = answer + self.curves_.components(parts, self._offsets(phones, len(parts.described))) - learned
        return answer

    def unedited(self, phones: Tier, times: Floats) -> Floats:
        """`components` without what edits of key shapes add."""
        plain = copy(self)
        plain.edits_ = {}
        return plain.components(phones, times)

    def _offsets(self, phones: Tier, described: int) -> Floats:
        """Edits of each part that pulls, shape (parts, strands)."""
        offsets = np.zeros((described, self.settings.influence.strands))
        table, parts = articulation_table(), parts_of(phones)
        ahead = self.settings.influence.neighbours
        for place, (symbol, phone) in enumerate(zip(parts.symbols, parts.phones, strict=True)):
            label = phones.intervals[phone].label if phone >= 0 else ""
            if label in self.edits_:
                offsets[ahead + place] = self.edits_[label][table.parts[label].index(int(symbol))]
        return offsets

    def evidence(self, phones: Tier) -> tuple[Evidence, ...]:
        """For each pair of neighbouring phones, what was heard of it in learning."""
        return self.coverage_.of_pairs([phone.label for phone in phones])

    def key_shapes(self, phone: str, duration: float = REFERENCE_DURATION) -> Floats:
        """Where a phone pulls the mouth: for each of its parts a frame as `synthesise` gives them."""
        symbols = np.array(articulation_table().parts[phone])
        described = describe_parts(symbols, np.full(len(symbols), duration), self.settings.influence.phone_weight)
        targets = self.curves_.curves(described)[:, 0]
        if phone in self.edits_:
            targets = targets + self.edits_[phone]
        return self.mouth_.motion_of(self.space_.decode(targets @ self.curves_.shapes_))

    def with_key_shape(self, phone: str, shapes: Floats) -> SpeechMotion:
        """The same model with the target of a phone moved to given shapes, as `key_shapes` gives them.

        What lies outside the pose space is lost; the influence curves stay as they are.
        """
        wanted = np.asarray(shapes, dtype=np.float64)
        now = self.key_shapes(phone)
        if wanted.shape != now.shape:
            raise InputError(f"the key shapes of {phone} have shape {now.shape}, not {wanted.shape}")
        flat = [self.space_.encode(self.mouth_.rows_from(shapes)) for shapes in (wanted, now)]
        change = (flat[0] - flat[1]) @ np.linalg.pinv(self.curves_.shapes_)
        edited = copy(self)
        edited.edits_ = self.edits_ | {phone: self.edits_.get(phone, 0.0) + change}
        return edited
