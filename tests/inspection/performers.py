"""A small performer learned from made-up recordings, and one whose curves are known."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cache

import numpy as np

from mien.motion.graph.graph_motion import GraphMotionSettings
from mien.motion.graph.search import SearchWeights
from mien.motion.learning import LearningSettings, learn
from mien.motion.mouth.coarticulation import CoarticulationSettings
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.coverage import Coverage
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.influence_curves import Curves
from mien.motion.mouth.speech_motion import SpeechMotionSettings
from mien.motion.performer_file import LearnedSpeech
from tests.motion.speaking import takes

SMALL = SpeechMotionSettings(
    components=3,
    correction_share=0.5,
    influence=InfluenceSettings(strands=4, epochs=4, batch=128),
    correction=CorrectionSettings(hidden=(16,), networks=1, epochs=2, batch=128),
)
LINE = Curves(np.array([[1.0, 0.0], [-1.0, 1.0]]), pairs=40, error=0.8)
"""F_s = 1 - t, F_e = t; the root of the mean square error is 0.1."""
THREE = Curves(np.array([[1.0, 0.0, 0.0], [-1.0, 0.5, 1.0]]), pairs=30, error=0.0)


@cache
def small_performer() -> LearnedSpeech:
    """Thirty strings of phones; OY and ZH are never said."""
    graph = GraphMotionSettings(weights=SearchWeights(), evenness=0.5)  # how they are learned is tested elsewhere
    settings = LearningSettings(SMALL, CoarticulationSettings(components=3, class_back_off=True), graph)
    return learn(takes(30), settings, name="small", about={"licence": "CC0 1.0"})


@cache
def known_performer() -> LearnedSpeech:
    """The small one as if it had met one triphone, two diphones and one pair of classes."""
    small = small_performer()
    paper, motion = copy(small.coarticulation), copy(small.motion)
    paper.curves_ = {("SIL", "B", "L"): THREE, ("L", "UW"): LINE, ("P", "AA"): LINE}
    paper.class_curves_ = {("closed", "tongue_on_ridge"): LINE}
    motion.coverage_ = Coverage(least=3).restore(
        {("SIL", "B", "L"): 3}, {("SIL", "B"): 3, ("B", "L"): 3, ("L", "UW"): 5000, ("UW", "AA"): 1}
    )
    return replace(small, coarticulation=paper, motion=motion)
