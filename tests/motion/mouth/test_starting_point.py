"""A few takes of somebody, started from another performer: what is learned is how the two differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.motion.learning import LearningSettings, learn, learn_corpus
from mien.motion.mouth.coarticulation import CoarticulationSettings
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.performer_file import load_learned, save_learned
from tests.motion.speaking import takes

SMALL = SpeechMotionSettings(
    components=2,
    influence=InfluenceSettings(strands=4, epochs=6, batch=128),
    correction=CorrectionSettings(hidden=(24,), networks=1, epochs=4, batch=128),
)
SETTINGS = LearningSettings(
    SMALL, CoarticulationSettings(components=2, class_back_off=True), speech_model="coarticulation"
)


def spoken(count: int, seed: int = 0, jaw: float = 1.0, rounding: float = 1.0, late: float = 0.0) -> list[Take]:
    """Takes of a made-up speaker in channels: opening and rounding of `tests.motion.speaking`, times two gains.

    Rounding comes ``late`` seconds later.
    """
    made = []
    for take in takes(count, seed, noise=0.0):
        positions = take.markers.positions
        opening = np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1)
        narrow = 24 - positions[:, 4, 0] - 0.1 * opening
        frames = np.arange(len(narrow))
        narrow = np.interp(frames - late * take.markers.rate.fps, frames, narrow)
        weights = np.stack([jaw * opening / 36, rounding * narrow / 8], axis=1).clip(0, 1)
        made.append(replace(take, channels=ChannelTrack(("jawOpen", "mouthPucker"), weights, take.markers.rate)))
    return made


@pytest.fixture(scope="module")
def known() -> SpeechMotion:
    return SpeechMotion(SMALL).fit(spoken(40))


def test_gains_of_a_person_are_found_in_three_takes(known: SpeechMotion) -> None:
    person = SpeechMotion(SMALL).fit(spoken(3, seed=9, jaw=1.5, rounding=0.4), prior=known)
    alone = SpeechMotion(SMALL).fit(spoken(3, seed=9, jaw=1.5, rounding=0.4))
    assert person.mouth_.names == ("jawOpen", "mouthPucker")
    missed = []
    made, before = [], []
    for take in spoken(6, seed=50, jaw=1.5, rounding=0.4):
        assert take.channels is not None
        times = take.markers.rate.times(len(take.markers))
        shown, other = (one.synthesise(take.phones, times) for one in (person, alone))
        made.append(shown)
        before.append(known.synthesise(take.phones, times))
        missed.append([np.abs(one - take.channels.values).mean() for one in (shown, other)])
    gains = np.concatenate(made).std(axis=0) / np.concatenate(before).std(axis=0)
    assert gains == pytest.approx([1.5, 0.4], rel=0.15)
    near, far = np.mean(missed, axis=0)
    assert near < 0.75 * far


def test_lips_shut_though_no_closure_was_recorded(known: SpeechMotion) -> None:
    takes_without = [t for t in spoken(30, seed=3) if not {p.label for p in t.phones} & set("PBM")][:2]
    person = SpeechMotion(SMALL).fit(takes_without, prior=known)
    assert person.closure_.apart_["bilabial"] == pytest.approx(known.closure_.apart_["bilabial"])
    assert sum(person.coverage_.diphones_.values()) > sum(known.coverage_.diphones_.values())


def test_the_file_says_from_whom_and_which_takes_are_known(tmp_path) -> None:
    prior = learn(spoken(12), SETTINGS, name="somebody", about={"licence": "CC BY 4.0", "citation": "Them 2006"})
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218"})
    for take in spoken(2, seed=9, jaw=1.5):
        corpus.add(take)
    made = learn_corpus(corpus, SETTINGS, name="anna", prior=prior)
    assert made.about["started from"] == "somebody (CC BY 4.0; Them 2006)"
    assert set(made.trained_on) > set(prior.trained_on)
    save_learned(made, tmp_path / "anna.mien")
    again = load_learned(tmp_path / "anna.mien")
    assert np.array_equal(again.motion.key_shapes("AA"), made.motion.key_shapes("AA"))
    told: list[str] = []
    same = learn_corpus(corpus, SETTINGS, prior=made, tell=lambda note: told.append(note.message))
    assert "started from" not in same.about
    assert any("learned from takes of this corpus" in message for message in told)


def test_markers_are_nothing_to_start_from() -> None:
    markers = SpeechMotion(replace(SMALL, learn_in="markers")).fit(takes(6))
    with pytest.raises(InputError, match="learned in markers"):
        SpeechMotion(SMALL).fit(spoken(2), prior=markers)


def test_lips_that_come_late_are_found(known: SpeechMotion) -> None:
    person = SpeechMotion(SMALL).fit(spoken(4, seed=9, late=0.08), prior=known)
    assert person.delays_.any()
    made, recorded = [], []
    for take in spoken(4, seed=50, late=0.08):
        assert take.channels is not None
        made.append(person.synthesise(take.phones, take.markers.rate.times(len(take.markers)))[:, 1])
        recorded.append(take.channels.values[:, 1])
    one, other, frames = np.concatenate(made), np.concatenate(recorded), np.arange(len(np.concatenate(made)))
    lags = np.arange(-4, 5)
    best = max(lags, key=lambda lag: np.corrcoef(other, np.interp(frames - lag, frames, one))[0, 1])
    assert best == 0
    assert not SpeechMotion(SMALL).fit(spoken(4, seed=9), prior=known).delays_.any()
