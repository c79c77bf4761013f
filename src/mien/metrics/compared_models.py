"""The rows of a table of scores: baselines and learned models, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from mien.core.errors import unknown_name
from mien.metrics.baselines import Cosine, MeanPose, Model, Ridge
from mien.metrics.dominance import Dominance
from mien.metrics.perceptron import Perceptron
from mien.motion.graph.combined_motion import CombinedMotion, CombinedMotionSettings
from mien.motion.graph.graph_motion import GraphMotion, GraphMotionSettings
from mien.motion.mouth.coarticulation import Coarticulation, CoarticulationSettings
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings

__all__ = ["contenders"]

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
    every: dict[str, Callable[[], Model]] = {
        "mean pose": MeanPose,
        "cosine": Cosine,
        "dominance": Dominance,
        "ridge": lambda: Ridge(reach),
        "perceptron": lambda: Perceptron(reach=reach),
        "diphones": lambda: Coarticulation(replace(paper, triphones=False)),
        "triphones": lambda: Coarticulation(paper),
        "influence curves": lambda: SpeechMotion(SpeechMotionSettings(correction_share=0.0)),
        "speech motion": SpeechMotion,
        "paper's graph": lambda: GraphMotion(replace(GraphMotionSettings.of_the_paper(), learn_in=_MARKERS)),
        "graph": GraphMotion,
        "both in markers": lambda: CombinedMotion(_in_markers()),
        "both": CombinedMotion,
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
