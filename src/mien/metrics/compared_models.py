"""The rows of a table of scores: baselines and learned models, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Self

from mien.core.errors import unknown_name
from mien.corpus.take import Take
from mien.metrics.baselines import Cosine, MeanPose, Model, Ridge
from mien.metrics.dominance import Dominance
from mien.metrics.perceptron import Perceptron
from mien.motion.graph.combined_motion import CombinedMotion, CombinedMotionSettings, learned_residuals
from mien.motion.graph.graph_motion import GraphMotion, GraphMotionSettings
from mien.motion.mouth.coarticulation import Coarticulation, CoarticulationSettings
from mien.motion.mouth.speech_motion import SpeechMotion

__all__ = ["OF_ONE_LEARNING", "contenders"]

OF_ONE_LEARNING = ("influence curves", "speech motion", "both")
"""Rows that are learned at once: the second has the first in it, the third the second."""

_MARKERS = "markers"


def contenders(names: Sequence[str] | None = None, *, unseen_words: bool = False) -> dict[str, Callable[[], Model]]:
    """Makers of untrained models, in the order of the table: baselines, then what mien learns.

    ``diphones`` and ``triphones`` are Deng et al.'s model with a key shape for each phone; ``influence curves`` are
    the explicit part of ``speech motion``. The last three hear the sound of the take: ``graph`` is recorded motion,
    searched and joined (Cao et al.), with the paper's weights and with weights learned from the training takes;
    ``both`` is ``speech motion`` corrected by what was recorded. Where takes have captured channels, mien learns in
    them; the papers' models learn markers as the papers do, and so does ``both in markers``, for comparison.

    Parameters
    ----------
    names : sequence of str or None
        Only these; None takes all.
    unseen_words : bool
        Ridge and perceptron see less context (0.16 s in place of 0.32 s to each side), as does them good there.

    Raises
    ------
    InputError
        If a name is not known.

    Examples
    --------
    >>> list(contenders(["ridge", "cosine"]))
    ['cosine', 'ridge']
    """
    reach = 0.16 if unseen_words else 0.32
    paper = CoarticulationSettings(key_per_phone=True, learn_in=_MARKERS)
    once = _Once()
    every: dict[str, Callable[[], Model]] = {
        "mean pose": MeanPose,
        "cosine": Cosine,
        "dominance": Dominance,
        "ridge": lambda: Ridge(reach),
        "perceptron": lambda: Perceptron(reach=reach),
        "diphones": lambda: Coarticulation(replace(paper, triphones=False)),
        "triphones": lambda: Coarticulation(paper),
        "influence curves": lambda: _InfluenceCurves(once),
        "speech motion": lambda: _SpeechMotion(once),
        "paper's graph": lambda: GraphMotion(replace(GraphMotionSettings.of_the_paper(), learn_in=_MARKERS)),
        "graph": GraphMotion,
        "both in markers": lambda: CombinedMotion(_in_markers()),
        "both": lambda: _Both(once),
    }
    if names is None:
        return every
    for name in names:
        if name not in every:
            raise unknown_name("model", name, every)
    return {name: make for name, make in every.items() if name in names}


def _in_markers() -> CombinedMotionSettings:
    settings = CombinedMotionSettings()
    return replace(
        settings,
        speech=replace(settings.speech, learn_in=_MARKERS),
        graph=replace(settings.graph, learn_in=_MARKERS),
    )


class _Once:
    """The speech motion of some takes, learned when it is first asked for and kept until other takes come."""

    def __init__(self) -> None:
        self._takes: tuple[int, ...] = ()

    def of(self, takes: Sequence[Take]) -> SpeechMotion:
        asked = tuple(id(take) for take in takes)
        if asked != self._takes:
            self._takes, self._kept, self._learned = asked, tuple(takes), SpeechMotion().fit(takes)
        return self._learned


class _SpeechMotion(SpeechMotion):
    def __init__(self, once: _Once) -> None:
        super().__init__()
        self._once = once

    def fit(
        self, takes: Sequence[Take], after_epoch: Callable[[], None] = lambda: None, prior: SpeechMotion | None = None
    ) -> Self:
        vars(self).update(vars(self._once.of(takes)))
        return self


class _InfluenceCurves(_SpeechMotion):
    def fit(
        self, takes: Sequence[Take], after_epoch: Callable[[], None] = lambda: None, prior: SpeechMotion | None = None
    ) -> Self:
        vars(self).update(vars(self._once.of(takes).explicit(takes)))
        return self


class _Both(CombinedMotion):
    def __init__(self, once: _Once) -> None:
        super().__init__()
        self._once = once

    def fit(self, takes: Sequence[Take], after_epoch: Callable[[], None] = lambda: None) -> Self:
        speech = self._once.of(takes)
        graph = GraphMotion(self.settings.graph).fit(takes).graph_
        return self.restore(speech, learned_residuals(speech, graph, takes, self.settings.seed))
