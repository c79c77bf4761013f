from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.corpus.recordings import Corpus
from mien.motion.graph import audio_distance
from mien.motion.maps.emotion_component_maps import LivelyMap, MeetingFrames, PaperMap, liveliness_of
from mien.motion.maps.emotion_mapping import (
    EmotionMapping,
    corpus_pairs,
    leave_one_sentence_out,
    meeting_frames,
    score_mapping,
    split_components,
)
from mien.motion.warping import warping_path
from tests.motion.expressive_takes import takes

Floats = NDArray[np.float64]
MARKERS = 12


def smooth(frames: int, columns: int, random: np.random.Generator, width: int) -> Floats:
    noise = random.laplace(size=(frames + 6 * width, columns))
    kernel = np.exp(-0.5 * (np.arange(-3 * width, 3 * width + 1) / width) ** 2)
    rows = np.stack([np.convolve(noise[:, c], kernel, "valid")[:frames] for c in range(columns)], axis=1)
    return np.asarray(rows / rows.std(axis=0))


def two_factors(
    sentences: int, seed: int = 0, speech_gain: float = 1.0, mood_gain: float = 0.9, shift: float = 1.0
) -> tuple[list[tuple[Floats, Floats]], Floats, Floats]:
    """Speech (3 sources) and emotion (2 sources) move markers; in the other emotion the latter are 0.9 times as big and
    shifted, and the sentence is said at another pace."""
    random = np.random.default_rng(seed)
    basis = np.linalg.qr(random.normal(size=(3 * MARKERS, 5)))[0].T * np.array([12, 9, 7, 6, 5])[:, None]
    offset = shift * np.array([2.5, -2.0])
    pairs = []
    for _ in range(sentences):
        frames = int(random.integers(70, 100))
        speech, mood = smooth(frames, 3, random, 3), smooth(frames, 2, random, 4)
        pace = np.clip(np.linspace(0, frames - 1, frames) + 4 * np.sin(np.linspace(0, np.pi, frames)), 0, frames - 1)
        warped = [
            np.stack([np.interp(pace, np.arange(frames), part[:, c]) for c in range(part.shape[1])], axis=1)
            for part in (speech, mood)
        ]
        made = [
            np.concatenate([speech, mood], axis=1) @ basis,
            np.concatenate([speech_gain * warped[0], mood_gain * warped[1] + offset], axis=1) @ basis,
        ]
        noisy = [m + random.normal(0, 0.1, m.shape) for m in made]
        pairs.append((noisy[0].reshape(-1, MARKERS, 3), noisy[1].reshape(-1, MARKERS, 3)))
    return pairs, basis, offset


def met_in_order(source: Floats, target: Floats) -> MeetingFrames:
    path = np.repeat(np.arange(len(source))[:, None], 2, axis=1)
    size = source.shape[1]
    return MeetingFrames([(source, target, path)], np.eye(size), np.ones(size, dtype=bool))


def test_the_known_split_is_recovered() -> None:
    pairs, basis, _ = two_factors(6)
    learned = EmotionMapping().fit(pairs)
    emotion = np.array(learned.split_.is_emotion)
    directions = (learned.code_.mixing_ @ learned.code_.axes_)[emotion]
    true = basis[3:]
    # What the emotion components move lies in what emotion truly moves.
    inside = directions @ np.linalg.pinv(true) @ true
    assert 1 <= emotion.sum() <= 3
    assert np.linalg.norm(inside) / np.linalg.norm(directions) > 0.9
    assert "emotion" in str(learned.split_)


def test_the_known_change_is_recovered() -> None:
    pairs, basis, offset = two_factors(6)
    learned = EmotionMapping().fit(pairs[:-1])
    source = pairs[-1][0]
    change = (learned.apply(source) - source).reshape(len(source), -1).mean(axis=0)
    true = offset @ basis[3:]
    assert change @ true / np.linalg.norm(change) / np.linalg.norm(true) > 0.95
    assert np.linalg.norm(change) == pytest.approx(np.linalg.norm(true), rel=0.2)


def test_a_component_that_only_moves_further_is_emotion() -> None:
    pairs, basis, _ = two_factors(12, mood_gain=1.8, shift=0.0)
    learned = EmotionMapping().fit(pairs)
    emotion = np.array(learned.split_.is_emotion)
    directions = (learned.code_.mixing_ @ learned.code_.axes_)[emotion]
    inside = directions @ np.linalg.pinv(basis[3:]) @ basis[3:]
    assert emotion.sum() == 2
    assert np.linalg.norm(inside) / np.linalg.norm(directions) > 0.85
    assert all(abs(shift) < 0.5 for shift in learned.split_.shift)
    assert all(spread > 1.4 for spread, e in zip(learned.split_.spread, emotion, strict=True) if e)


def test_a_gain_on_speech_beats_a_mean_offset_and_moves_as_far_as_the_truth() -> None:
    scores = leave_one_sentence_out(two_factors(5, speech_gain=1.4)[0])
    assert scores["mien"].rms < 0.85 * scores["mean offset"].rms
    assert scores["mien"].share > scores["mean offset"].share
    assert 0.85 <= scores["mien"].liveliness <= 1.15


def test_least_squares_is_not_let_freeze_the_motion() -> None:
    random = np.random.default_rng(1)
    sentences = []
    for _ in range(4):
        common, one, other = (smooth(150, 4, random, 3) for _ in range(3))
        path = np.repeat(np.arange(150)[:, None], 2, axis=1)
        sentences.append((0.6 * common + 0.8 * one, 0.6 * common + 0.8 * other + 3.0, path))
    met = MeetingFrames(sentences, np.eye(4), np.ones(4, dtype=bool))
    learned = LivelyMap().fit(met)
    assert 0.86 <= learned.liveliness_ <= 1.14  # the least-squares gain is 0.36
    assert learned.error_ < learned.offset_error_
    made = np.concatenate([learned.apply(source) for source, _, _ in sentences])
    assert 0.8 < liveliness_of(made, np.concatenate([target for _, target, _ in sentences])) < 1.2


def test_what_the_source_does_not_tell_can_be_drawn() -> None:
    pairs, basis, _ = two_factors(5)
    random = np.random.default_rng(5)
    wandering = [(a, b + (3 * smooth(len(b), 1, random, 2) @ basis[3:4] / 6).reshape(b.shape)) for a, b in pairs]
    learned = EmotionMapping().fit(wandering)
    plain, alive = (score_mapping(learned, wandering[0], draw) for draw in (None, np.random.default_rng(0)))
    assert abs(alive.liveliness - 1) <= abs(plain.liveliness - 1) + 0.02
    again = learned.apply(pairs[0][0], np.random.default_rng(0))
    assert np.array_equal(again, learned.apply(pairs[0][0], np.random.default_rng(0)))


def test_the_compiled_path_is_the_reference() -> None:
    random = np.random.default_rng(0)
    for frames, others in ((1, 1), (1, 5), (17, 12), (30, 31)):
        a, b = random.normal(size=(frames, 3)), random.normal(size=(others, 3))
        assert np.array_equal(warping_path(a, b), audio_distance.warping_path(a, b))


def test_pairs_of_a_corpus(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218"})
    said = takes(3)
    lost = said[4].markers.positions.copy()
    lost[3, 7] = np.nan
    said[4] = replace(said[4], markers=MarkerTrack(said[4].markers.names, lost, said[4].markers.rate))
    for one in [*said, replace(said[1], name="again")]:
        corpus.add(one)
    pairs, notes = corpus_pairs(corpus, "neutral", "happy")
    assert len(pairs) == 2
    assert all(a.shape[1:] == b.shape[1:] == (218, 3) for a, b in pairs)
    assert "1 sentences are left out" in notes[0].message
    with pytest.raises(InputError, match="no sentence was recorded both in 'neutral' and in 'angry'"):
        corpus_pairs(corpus, "neutral", "angry")


def test_left_out_sentences_rank_as_they_should() -> None:
    scores = leave_one_sentence_out(two_factors(4)[0])
    assert scores["no change"].share == 0
    assert scores["mien"].rms <= 1.02 * scores["mean offset"].rms < scores["no change"].rms
    assert scores["mien"].share > 0.7
    assert 0.8 <= scores["mien"].liveliness <= 1.2


@pytest.mark.parametrize("kernel", ["exponential", "gaussian"])
def test_the_papers_map_hits_its_centres_and_little_else(kernel: str) -> None:
    random = np.random.default_rng(0)
    source = random.normal(size=(400, 3))
    target = source + np.array([1.0, 0.0, -1.0])
    learned = PaperMap("exponential" if kernel == "exponential" else "gaussian").fit(met_in_order(source, target))
    at_centres = learned.apply(learned.centres_) - learned.centres_
    assert np.allclose(at_centres, [1.0, 0.0, -1.0], atol=1e-6)
    fresh = random.normal(size=(200, 3))
    assert np.abs((learned.apply(fresh) - fresh)[:, [0, 2]]).mean() < 0.95


def test_dtw_finds_the_pace() -> None:
    random = np.random.default_rng(3)
    a = smooth(100, 3, random, 4)
    places = np.linspace(0, 1, 130) ** 1.2 * 99
    b = np.stack([np.interp(places, np.arange(100), a[:, c]) for c in range(3)], axis=1)
    path = meeting_frames(a, b)
    assert np.abs(path[:, 0] - places[path[:, 1]]).mean() < 1.5


def test_a_split_has_both_parts() -> None:
    random = np.random.default_rng(0)
    same = [(random.normal(size=(50, 3)), random.normal(size=(50, 3))) for _ in range(4)]
    assert 0 < sum(split_components(same).is_emotion) < 3
    all_move = [(a, a + 5) for a, _ in same]
    assert 0 < sum(split_components(all_move).is_emotion) < 3


def test_slips_are_refused() -> None:
    good = np.zeros((5, 2, 3))
    with pytest.raises(InputError, match="there is none"):
        EmotionMapping().fit([])
    with pytest.raises(InputError, match="sentence 0: expected"):
        EmotionMapping().fit([(good, np.zeros((5, 4, 3)))])
    with pytest.raises(InputError, match="missing"):
        EmotionMapping().fit([(good, np.full((5, 2, 3), np.nan))])
    with pytest.raises(InputError, match="at least two"):
        leave_one_sentence_out([(good, good)])
