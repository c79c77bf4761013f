from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import channels
from mien.core.timeline import FrameRate, Interval, Tier
from mien.motion.effort import DECIBELS, MeanMouth, articulate, effort_gains, mean_mouth
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.mouth.mouth_space import ChannelSpace
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.effort_spans import EffortCurve, EffortSpan
from mien.text.score import EmotionSpan, Score
from tests.utterances import utterance

RATE = FrameRate.of(60)
LINE = utterance(
    ("SIL", 0.3), ("M", 0.08), ("AA", 0.16), ("P", 0.09), ("IY", 0.12), ("F", 0.1), ("OW", 0.2), ("SIL", 0.5)
)
JAW = channels.ALL.index("jawOpen")


@pytest.fixture(params=["default", "hand-made"])
def performer(request: pytest.FixtureRequest):  # type: ignore[no-untyped-def]
    return load_performer(request.param)


def spoken(performer, *spans: EffortSpan, emotion: str = "") -> np.ndarray:  # type: ignore[no-untyped-def, type-arg]
    emotions = (EmotionSpan(emotion),) if emotion else ()
    return perform(LINE, Score(emotions, efforts=spans), performer, RATE).channels.values


def test_more_effort_opens_the_jaw_further_and_one_leaves_every_bit(performer) -> None:  # type: ignore[no-untyped-def]
    plain = spoken(performer)
    means = [spoken(performer, EffortSpan(level))[:, JAW].mean() for level in (0.0, 0.5, 1.0, 1.4, 2.0)]
    assert np.diff(means).min() > 0.05 * means[2]
    assert (spoken(performer, EffortSpan(1.0)) == plain).all()


@pytest.mark.parametrize("level", [0.0, 0.4, 1.7, 2.0])
def test_closures_stay_as_they_are_and_weights_in_range(performer, level: float) -> None:  # type: ignore[no-untyped-def]
    seal = performer.mouth.perform(LINE, RATE).seal
    plain, changed = spoken(performer), spoken(performer, EffortSpan(level))
    shut = seal > 1 - 1e-9
    assert shut.sum() > 5  # of /m p f/
    mouth = [channels.ALL.index(name) for name in channels.MOUTH]
    assert np.abs(changed - plain)[shut][:, mouth].max() < 1e-9
    weights = changed[:, : len(channels.WEIGHTS)]
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert np.abs(changed - plain)[seal < 0.1][:, mouth].max() > 0.01


@pytest.mark.parametrize("level", [0.4, 1.8])
def test_lips_that_a_learned_mouth_shuts_stay_shut(level: float) -> None:
    performer = load_performer("mandarin")
    names = [name for name in channels.MOUTH if name in channels.WEIGHTS]
    space, columns = ChannelSpace.of(names), [channels.ALL.index(name) for name in names]
    times = RATE.times(RATE.frames_covering(LINE.duration))

    def least(values):  # type: ignore[no-untyped-def]
        opening = space.opening_of(space.rows_from(values[:, columns]))
        shut = [(p.start - 0.04, p.end + 0.04) for p in LINE.phones if p.label in "MP"]
        return [opening[(times > start) & (times < end)].min() for start, end in shut]

    plain, changed = least(spoken(performer)), least(spoken(performer, EffortSpan(level)))
    assert max(plain) < 1.0
    assert np.abs(np.subtract(changed, plain)).max() < 0.4


def test_the_ceiling_is_soft() -> None:
    performer = load_performer("hand-made")
    mouth = performer.mouth.perform(LINE, RATE)
    wide = replace(mouth, values=np.clip(2.0 * mouth.values, 0, 0.95), seal=np.zeros(len(mouth.values)))
    effort = np.full(len(wide.values), 2.0)
    said = [(p.start, p.end) for p in LINE.phones if p.label != "SIL"]
    vowel = Tier("phones", (Interval(said[0][0], said[-1][1], "AA"),))
    jaw = articulate(wide, effort, vowel, RATE, mean_mouth(performer.mouth)).values[:, JAW]
    speech = (RATE.times(len(jaw)) >= said[0][0]) & (RATE.times(len(jaw)) <= said[-1][1])
    before, after = wide.values[speech, JAW], jaw[speech]
    assert after.max() < 1
    assert (after >= before).all()  # what was wide already is not narrowed
    assert (np.diff(after[np.argsort(before)]) > -1e-9).all()  # and what was wider stays wider


def test_pauses_are_rest_whatever_the_effort(performer) -> None:  # type: ignore[no-untyped-def]
    still = RATE.times(len(spoken(performer))) > LINE.duration - 0.25
    mouth = [channels.ALL.index(name) for name in channels.MOUTH]
    plain, idle = spoken(performer)[still][:, mouth], spoken(performer, EffortSpan(0.0))[still][:, mouth]
    assert np.abs(plain - idle).max() < 1e-9


def test_effort_changes_over_time() -> None:
    performer = load_performer("hand-made")
    curve = EffortCurve((0.3, 1.0), (0.2, 2.0), "linear")
    ratio = spoken(performer, EffortSpan(curve))[:, JAW] / np.maximum(spoken(performer)[:, JAW], 1e-9)
    times = RATE.times(len(ratio))
    open_ = spoken(performer)[:, JAW] > 0.1
    early, late = ratio[open_ & (times < 0.5)].mean(), ratio[open_ & (times > 0.8)].mean()
    assert early < 0.8 < 1.2 < late


def test_an_emotion_carries_effort_in_proportion_to_its_intensity_and_off_takes_it_away() -> None:
    performer = load_performer("hand-made")
    times = RATE.times(5)
    efforts = {name: performer.expression.effort(Score((EmotionSpan(name),)), times)[0] for name in ("angry", "sad")}
    assert efforts["angry"] > 1.1
    assert efforts["sad"] < 1
    half = performer.expression.effort(Score((EmotionSpan("angry", 0.5),)), times)[0]
    assert half - 1 == pytest.approx((efforts["angry"] - 1) / 2)
    felt = spoken(performer, emotion="angry")
    plain = spoken(performer, EffortSpan(1.0, source="off"), emotion="angry")
    assert felt[:, JAW].mean() > 1.03 * plain[:, JAW].mean()


def test_brows_and_nods_on_accents_go_with_the_effort() -> None:
    class Nods:
        def perform(self, spoken, words, rate, random):  # type: ignore[no-untyped-def]
            values = np.zeros((rate.frames_covering(spoken.duration), len(channels.ALL)))
            values[:, channels.ALL.index("browInnerUp")] = 0.2
            return values

    class Still:
        def perform(self, spoken, rate, random, score=None):  # type: ignore[no-untyped-def]
            return np.zeros((rate.frames_covering(spoken.duration), len(channels.ALL)))

    performer = replace(load_performer("hand-made"), prosody=Nods(), idle=Still())
    brow = channels.ALL.index("browInnerUp")
    rest, half, plain = (spoken(performer, EffortSpan(level))[:, brow] for level in (0.0, 0.5, 1.0))
    assert plain - half == pytest.approx(half - rest)
    assert (plain - rest).mean() == pytest.approx(0.2)


def test_the_gains_are_those_of_the_shipped_table() -> None:
    jaw, lips = effort_gains().at(np.array([0.5, 1.0, 1.5]))
    assert jaw[1] == lips[1] == 1
    assert jaw[0] < lips[0] < 1 < lips[2] < jaw[2]
    per_decibel = (jaw[2] - 1) / (0.5 * DECIBELS)
    assert 0.02 < per_decibel < 0.06  # facegood-mandarin: .028 among vowels of one kind, .047 among its loudest frames


def test_a_hiss_keeps_its_narrow_gap_while_vowels_open() -> None:
    said = utterance(("SIL", 0.2), ("AA", 0.3), ("S", 0.3), ("AA", 0.3), ("SIL", 0.2))
    rate = FrameRate.of(60)
    mouth = HandMadeMouth().perform(said, rate)
    loud = articulate(mouth, np.full(len(mouth.values), 2.0), said.phones, rate, MeanMouth(mouth.values.mean(axis=0)))
    jaw = channels.ALL.index("jawOpen")
    grown = loud.values[:, jaw] - mouth.values[:, jaw]
    vowel, hiss = grown[round(0.35 * 60)], grown[round(0.65 * 60)]
    assert vowel > 0.1
    assert hiss < 0.35 * vowel
