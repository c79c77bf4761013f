"""Recorded motion as a speech model, alone and with the learned curves."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.motion.graph.combined_motion import CombinedMotion, CombinedMotionSettings
from mien.motion.graph.graph_motion import PAPER_WEIGHTS, GraphMotion, GraphMotionSettings, trimmed
from mien.motion.graph.recorded_residuals import FitWeights, RecordedResiduals
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.speech_model import HearingModel, synthesise
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from tests.motion.speaking import take, takes, tier

PAPER = GraphMotionSettings.of_the_paper()
SMALL = SpeechMotionSettings(
    components=3,
    influence=InfluenceSettings(strands=4, epochs=6, batch=128),
    correction=CorrectionSettings(hidden=(24,), networks=1, epochs=4, batch=128),
)


@pytest.fixture(scope="module")
def recorded():
    return takes(40)


@pytest.fixture(scope="module")
def graph(recorded):
    return GraphMotion(replace(PAPER, share=0.999)).fit(recorded)


@pytest.fixture(scope="module")
def both(recorded):
    return CombinedMotion(CombinedMotionSettings(speech=SMALL)).fit(recorded)


def rms(made, said):
    return float(np.sqrt(((made - said.markers.positions) ** 2).sum(axis=2).mean()))


def test_what_was_recorded_is_found_and_comes_back(graph, recorded):
    for said in recorded[:3]:
        times = said.markers.rate.times(len(said.markers))
        silence = graph.synthesise(said.phones, times)
        assert rms(silence, said) < 0.6  # no jump, its own recording; the filter and held closures move it a little


def test_new_sentences_move_as_their_speaker_would(graph, both):
    for said in takes(4, seed=50, noise=0.0):
        times = said.markers.rate.times(len(said.markers))
        assert rms(graph.synthesise(said.phones, times), said) < 2.5
        assert rms(both.synthesise(said.phones, times), said) < 1.5


def test_models_that_listen_get_the_sound_and_others_are_asked_as_ever(graph, both, recorded):
    said = recorded[0]
    times = np.arange(0, 1, 0.04)
    assert isinstance(graph, HearingModel)
    assert isinstance(both, HearingModel)
    assert not isinstance(both.speech_, HearingModel)
    heard = []

    class Listening(GraphMotion):
        def synthesise_heard(self, phones, times, audio, felt=None):
            heard.append(audio)
            return graph.synthesise(phones, times)

    synthesise(Listening(), said.phones, times, said.audio)
    assert heard == [said.audio]
    deaf = synthesise(graph, said.phones, times, None)
    assert np.array_equal(deaf, graph.synthesise(said.phones, times))
    assert np.array_equal(
        synthesise(both.speech_, said.phones, times, said.audio), both.speech_.synthesise(said.phones, times)
    )


def test_phones_never_recorded_pauses_and_gaps_are_met(graph, both):
    said = Tier("phones", (Interval(0.3, 0.4, "OY"), Interval(0.4, 0.5, "ZH"), Interval(0.8, 0.8, "M")))
    times = np.arange(-0.2, 1.5, 0.05)
    for model in (graph, both):
        for phones in (said, Tier("phones", ()), tier(["SIL"], 1.0)):
            made = model.synthesise(phones, times)
            assert made.shape == (len(times), 12, 3)
            assert np.isfinite(made).all()
        assert model.synthesise(said, np.zeros(0)).shape == (0, 12, 3)


def test_the_paper_s_settings_are_the_paper_s(graph):
    assert (PAPER_WEIGHTS.jump, PAPER_WEIGHTS.join, PAPER_WEIGHTS.audio) == (100, 1, 0.01)
    assert (graph.weights_, graph.evenness_) == (PAPER_WEIGHTS, 0.0)
    assert GraphMotionSettings().share == 0.95


def test_weights_are_learned_from_takes_held_out_of_the_graph(recorded):
    told = []
    learned = GraphMotion().fit(recorded[:20], lambda: told.append(1))
    from mien.motion.graph.weight_learning import TRIALS

    assert len(told) == TRIALS
    assert learned.weights_.join == 1.0  # only ratios matter
    assert 0 <= learned.evenness_ <= 1
    fixed = GraphMotion(GraphMotionSettings(weights=PAPER_WEIGHTS)).fit(recorded[:20])
    assert fixed.weights_ == PAPER_WEIGHTS


def test_a_take_is_trimmed_by_whole_frames_of_motion_and_sound():
    said = take("long", tier(["SIL", "M", "AA", "SIL"], 1.3))
    short = trimmed(said)
    begin = said.phones.intervals[1].start - short.phones.intervals[1].start
    assert begin == pytest.approx(1.0)
    assert np.array_equal(short.markers.positions, said.markers.positions[50 : 50 + len(short.markers)])
    assert short.phones.intervals[-1].end == pytest.approx(3.2)
    assert short.duration == pytest.approx(3.2, abs=0.001)
    assert [phone.label for phone in short.phones] == ["SIL", "M", "AA", "SIL"]


def test_residuals_that_follow_the_company_are_told_and_chance_is_not():
    """Where a residual hangs on the phone before, it is found again; where nothing fits, nothing is added."""
    random = np.random.default_rng(1)
    spoken = [["SIL", *random.choice(["M", "AA", "T", "IY"], 12).tolist(), "SIL"] for _ in range(20)]
    model = GraphMotion(PAPER).fit([take(f"t{k}", tier(labels)) for k, labels in enumerate(spoken)])
    graph = model.graph_
    residuals = RecordedResiduals(graph)
    vowel = graph.symbols.index("AA")
    value = np.zeros((len(graph), 5, 2))
    before = np.r_[-1, graph.phones[:-1]]
    value[:, :, 0] = np.where(before == vowel, 3.0, -1.0)[:, None]
    residuals.fit(value)
    said = tier(["SIL", "T", "AA", "T", "SIL"], 0.1)
    told = residuals.at(said, np.array([0.15, 0.35]), None)
    assert told[1, 0] > 1.0 > 0.0 > told[0, 0]
    assert np.abs(told[:, 1]).max() < 1e-9
    residuals.weights_ = residuals.deaf_weights_ = FitWeights(near=50.0)
    lonely = tier(["SIL", "ZH", "T", "OY", "SIL"], 0.1)
    assert np.abs(residuals.at(lonely, np.array([0.25]), None)).max() < 0.05


def test_three_minutes_are_synthesised_whole_in_bounded_memory(graph, both):
    random = np.random.default_rng(4)
    labels = ["SIL", *random.choice(["M", "AA", "T", "IY", "S", "UW", "P"], 1798).tolist(), "SIL"]
    said = tier(labels, 0.1)
    times = np.arange(0, 180, 0.04)
    for model in (graph, both):
        made = model.synthesise(said, times)
        assert made.shape == (4_500, 12, 3)
        assert np.isfinite(made).all()
    tracemalloc.start()
    both.synthesise(Tier("phones", said.intervals[:620]), np.arange(0, 62, 62 / 15_000))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 250e6  # as many frames in a tenth of the time: what is kept for a frame is little


def test_the_combination_follows_the_curves_where_it_has_no_recording(both, recorded):
    never = Tier("phones", (Interval(0.0, 0.2, "SIL"), Interval(0.2, 0.3, "OY"), Interval(0.3, 0.5, "SIL")))
    times = np.array([0.25])
    bare = both.speech_.synthesise(never, times)
    assert np.abs(both.synthesise(never, times) - bare).max() < 0.7
    assert both.mouth_.names == SpeechMotion(SMALL).fit(recorded[:3]).mouth_.names


def test_quiet_and_short_sounds_are_heard(graph, both, recorded):
    said = recorded[0]
    for audio in (Audio(np.zeros(0), 16000), Audio.silence(0.5, 8000), Audio([0.1], 44100)):
        for model in (graph, both):
            assert np.isfinite(model.synthesise_heard(said.phones, np.arange(0, 1, 0.1), audio)).all()
