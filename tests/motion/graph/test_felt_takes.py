from dataclasses import replace

import numpy as np
import pytest

from mien.core.timeline import Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.recordings import Corpus
from mien.motion.graph.felt_takes import felt_over, labels_of, levelled
from mien.motion.learning import LearningSettings, learn, learn_corpus
from mien.motion.mouth.coarticulation import CoarticulationSettings
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.mouth_space import mouth_space_of
from mien.motion.mouth.speech_model import synthesise
from mien.motion.mouth.speech_motion import SpeechMotionSettings
from mien.motion.performer_file import load_learned, save_learned
from mien.text.score import EmotionSpan, Score
from tests.motion.speaking import NAMES, takes

SMALL = LearningSettings(
    SpeechMotionSettings(
        components=3,
        influence=InfluenceSettings(strands=4, epochs=4, batch=128),
        correction=CorrectionSettings(hidden=(16,), networks=1, epochs=2, batch=128),
    ),
    CoarticulationSettings(components=3),
)
LARGER = 1.6


def opening(positions):
    """Height of the upper lip's middle over the lower one's, mm."""
    return positions[:, 0, 1] - positions[:, 1, 1]


def angrily(take):
    """The same words with a mouth that moves further, and corners that are 6 mm lower all the time."""
    mean = take.markers.positions.mean(axis=0)
    positions = mean + LARGER * (take.markers.positions - mean)
    positions[:, 4:6, 1] -= 6.0
    return replace(
        take, name=f"angry-{take.name}", emotion="angry", markers=MarkerTrack(NAMES, positions, take.markers.rate)
    )


@pytest.fixture(scope="module")
def neutral():
    return takes(24, noise=0.0)


@pytest.fixture(scope="module")
def learned(neutral, tmp_path_factory):
    path = tmp_path_factory.mktemp("felt") / "felt.mien"
    save_learned(learn(neutral, SMALL, felt=[angrily(take) for take in neutral]), path)
    return load_learned(path)


def test_expressive_takes_speak_about_the_same_mean_mouth(neutral):
    angry = [angrily(take) for take in neutral[:6]]
    space = mouth_space_of(neutral)
    moved = levelled(angry, neutral, space)
    both = [np.concatenate([t.markers.positions for t in some]) for some in (moved, neutral)]
    assert np.abs(both[0].mean(axis=0) - both[1].mean(axis=0)).max() < 1.5
    ratio = opening(moved[0].markers.positions).std() / opening(neutral[0].markers.positions).std()
    assert ratio == pytest.approx(LARGER, rel=0.1)


@pytest.mark.parametrize("model", ["graph", "both"])
def test_the_way_of_speaking_is_that_of_the_emotion_asked_for(learned, model):
    assert learned.recorded.emotions == ("angry", "neutral")
    new = takes(3, seed=91, noise=0.0)
    ratios = []
    for said in new:
        times = said.markers.rate.times(len(said.markers))
        always = Tier("felt", (Interval(0.0, said.duration, "angry"),))
        plain, felt = (synthesise(learned.model(model), said.phones, times, said.audio, t) for t in (None, always))
        assert np.corrcoef(opening(plain), opening(said.markers.positions))[0, 1] > 0.85
        ratios.append(opening(felt).std() / opening(plain).std())
        # Corners that are 6 mm lower all the time are the expression's: less than half of that may reach the speech,
        # from a network that has learned for two epochs.
        assert abs(felt[:, 4:6, 1].mean() - plain[:, 4:6, 1].mean()) < 3.0
    assert np.mean(ratios) == pytest.approx(LARGER, rel=0.25)


def test_a_corpus_without_neutral_takes_is_learned_too(neutral, tmp_path):
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218", "licence": "CC0"})
    for take in neutral[:6]:
        corpus.add(angrily(take))
    made = learn_corpus(corpus, SMALL)
    assert len(made.trained_on) == 6
    assert made.recorded.emotions == ("angry",)
    assert np.isfinite(made.model().synthesise(neutral[0].phones, np.arange(0, 1, 0.04))).all()


def test_what_a_score_asks_for_over_time():
    score = Score((EmotionSpan("angry", 0.9, 0.5, 1.0), EmotionSpan("sad", 1.0), EmotionSpan("bored", 1.0, 1.5)))
    felt = felt_over(score, 2.0, ("angry", "bored", "neutral"))
    assert [(span.label, round(span.start, 1), round(span.end, 1)) for span in felt] == [
        ("angry", 0.5, 1.0), ("bored", 1.5, 2.0),
    ]  # fmt: skip
    weak = Score((EmotionSpan("angry", 0.3),))
    assert len(felt_over(weak, 2.0, ("angry", "neutral"))) == 0
    said = Tier("phones", (Interval(0.4, 0.5, "M"), Interval(0.5, 0.8, "AA")))
    assert labels_of(said, felt, ("angry", "bored", "neutral")) == ("neutral", "angry")
    assert labels_of(said, felt, ("neutral",)) is None
