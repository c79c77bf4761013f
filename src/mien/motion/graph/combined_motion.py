"""`CombinedMotion`: learned curves where nothing like it was recorded, recordings where something was.

`SpeechMotion` carries the motion; the Anime Graph adds what it recorded beside it (`recorded_residuals`), as far as
what is said was recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import Tier
from mien.corpus.take import Take
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.graph_motion import GraphMotion, GraphMotionSettings, covering, trimmed
from mien.motion.graph.recorded_residuals import RecordedResiduals
from mien.motion.graph.sound import heard_features
from mien.motion.mouth.mouth_space import MouthSpace
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.mouth.spread import APART, instants_about

__all__ = ["CombinedMotion", "CombinedMotionSettings", "learned_residuals", "residuals_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CombinedMotionSettings:
    """Settings of `CombinedMotion`.

    Attributes
    ----------
    speech : SpeechMotionSettings
        Whether closures are held is told by its ``hold_closures``.
    graph : GraphMotionSettings
        Its weights are for `GraphMotion` alone; by default they are not learned here.
    seed : int
        Of the nodes on which weights are tried.
    """

    speech: SpeechMotionSettings = field(default_factory=SpeechMotionSettings)
    graph: GraphMotionSettings = field(default_factory=GraphMotionSettings.of_the_paper)
    seed: int = 0


class CombinedMotion:
    """Mouth motion from phones and sound, by learned curves and recorded residuals.

    Parameters
    ----------
    settings : CombinedMotionSettings

    Attributes
    ----------
    speech_ : SpeechMotion
    residuals_ : RecordedResiduals
    """

    def __init__(self, settings: CombinedMotionSettings | None = None) -> None:
        self.settings = settings or CombinedMotionSettings()

    @property
    def mouth_(self) -> MouthSpace:
        """What `synthesise` returns: channels or markers of the mouth."""
        return self.speech_.mouth_

    def fit(self, takes: Sequence[Take], after_epoch: Callable[[], None] = lambda: None) -> Self:
        """Learn from takes; what does not belong to the mouth is left out.

        Raises
        ------
        InputError
            If there is no take, the takes do not share their markers, or none has a frame with speech.
        """
        speech = SpeechMotion(self.settings.speech).fit(takes, after_epoch)
        graph = GraphMotion(self.settings.graph).fit(takes).graph_
        return self.restore(speech, learned_residuals(speech, graph, takes, self.settings.seed))

    def restore(self, speech: SpeechMotion, residuals: RecordedResiduals) -> Self:
        """Take parts that were made before."""
        self.speech_, self.residuals_ = speech, residuals
        return self

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """The mouth by phones and their lengths alone; as `SpeechMotion.synthesise`."""
        return self._performed(phones, times, None)

    def synthesise_heard(self, phones: Tier, times: Floats, audio: Audio, felt: Tier | None = None) -> Floats:
        """The same by what is heard too; ``felt``: where which emotion is asked for."""
        return self._performed(phones, times, heard_features(audio, phones), felt)

    def _performed(self, phones: Tier, times: Floats, features: Floats | None, felt: Tier | None = None) -> Floats:
        times = np.asarray(times, dtype=np.float64)
        if not len(times):
            return self.speech_.synthesise(phones, times)
        return self.speech_.finished(self._answer(phones, times, features, felt), phones, times)

    def _answer(
        self, phones: Tier, times: Floats, features: Floats | None, felt: Tier | None
    ) -> Callable[[Floats], Floats]:
        """What gives components at instants about some times; held by none but who finishes them."""
        said = covering(phones, float(times.min()) - APART, float(times.max()) + APART)
        about = instants_about(times) if self.speech_.spread_ is not None else times
        beside = self.residuals_.curve(said, float(about.min()), float(about.max()), features, felt)
        return lambda instants: self.speech_.components(phones, instants) + beside(instants)


def learned_residuals(
    speech: SpeechMotion, graph: AnimeGraph, takes: Sequence[Take], seed: int = 0
) -> RecordedResiduals:
    """Residuals of a graph beside a model's prediction, and what tells which fit; the takes are those of the graph."""
    residuals = RecordedResiduals(graph)
    return residuals.fit(residuals_of(speech, residuals, takes), seed)


def residuals_of(speech: SpeechMotion, residuals: RecordedResiduals, takes: Sequence[Take]) -> Floats:
    """What the nodes of a graph did beside a model's prediction, shape (nodes, 5, components of its space).

    The takes are those of the graph, in its order.
    """
    graph, instants = residuals.graph, residuals.instants()
    found = np.zeros((*instants.shape, speech.settings.components))
    for number, take in enumerate(takes):
        nodes = np.flatnonzero(graph.take_of == number)
        if not len(nodes):
            continue
        take = trimmed(take)
        rows = speech.mouth_.rows_of(take)
        seen = np.isfinite(rows).all(axis=1)
        times = take.markers.rate.times(len(rows))[seen]
        beside = speech.space_.encode(rows[seen]) - speech.components(take.phones, times)
        at = instants[nodes].ravel()
        columns = [np.interp(at, times, column) for column in beside.T]
        found[nodes] = np.stack(columns, axis=1).reshape(len(nodes), instants.shape[1], -1)
    return found
