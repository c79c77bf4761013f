from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.motion.maps.emotion_maps import learn_emotion_maps
from mien.motion.performer_file import load_learned, save_learned
from mien.motion.performers import load_learned_performer
from tests.motion.expressive_takes import emotion_maps as learned
from tests.motion.expressive_takes import take, takes


def test_every_two_emotions_that_share_sentences_get_a_map_each_way() -> None:
    assert len(learned().maps) == 6
    assert learned().emotions == ("happy", "neutral", "surprised")
    assert set(learned().sentences.values()) == {4}


def test_a_map_brings_a_new_sentence_nearer_to_what_was_recorded() -> None:
    new = {emotion: take(9, emotion, 0.0, 0.05) for emotion in ("neutral", "happy", "surprised")}
    source = new["neutral"].markers
    for emotion in ("happy", "surprised"):
        real = new[emotion].markers.positions
        made = learned().apply(source.positions, "neutral", emotion, source.rate)
        before, after = (np.sqrt(((motion - real) ** 2).sum(axis=2).mean()) for motion in (source.positions, made))
        assert after < 0.45 * before


def test_a_saved_performer_maps_the_same_bits(tmp_path: Path) -> None:
    whole = replace(load_learned_performer("default"), emotion_maps=learned())
    save_learned(whole, tmp_path / "a.mien")
    again = load_learned(tmp_path / "a.mien").emotion_maps
    assert again is not None
    source = take(9, "neutral").markers
    for step in learned().maps:
        made = [
            maps.apply(source.positions, *step, source.rate, np.random.default_rng(1)) for maps in (learned(), again)
        ]
        assert np.array_equal(*made)
    assert str(again.maps["neutral", "happy"].split_) == str(learned().maps["neutral", "happy"].split_)
    save_learned(load_learned(tmp_path / "a.mien"), tmp_path / "b.mien")
    assert (tmp_path / "a.mien").read_bytes() == (tmp_path / "b.mien").read_bytes()


def test_a_performer_without_maps_comes_back_without(tmp_path: Path) -> None:
    save_learned(load_learned_performer("default"), tmp_path / "again.mien")
    assert load_learned(tmp_path / "again.mien").emotion_maps is None


def test_the_way_may_lead_through_neutral() -> None:
    kept = {step: m for step, m in learned().maps.items() if "neutral" in step}
    maps = replace(learned(), maps=kept)
    assert maps.way("happy", "surprised") == (("happy", "neutral"), ("neutral", "surprised"))
    assert maps.way("happy", "happy") == ()
    with pytest.raises(InputError, match="no map from 'happy' to 'angry'"):
        maps.apply(np.zeros((5, 218, 3)), "happy", "angry", FrameRate.of(60))


def test_another_frame_rate_changes_alike() -> None:
    source = take(9, "neutral").markers
    half = source.positions[::2]
    full = learned().apply(source.positions, "neutral", "happy", source.rate)
    slow = learned().apply(half, "neutral", "happy", FrameRate.of(30))
    assert np.abs((slow - half) - (full - source.positions)[::2][: len(slow)]).mean() < 0.1


def test_takes_with_lost_markers_are_left_out() -> None:
    said = takes(3)
    lost = said[1].markers.positions.copy()
    lost[0, 0] = np.nan
    said[1] = replace(said[1], markers=MarkerTrack(said[1].markers.names, lost, said[1].markers.rate))
    maps = learn_emotion_maps(said)
    assert maps is not None
    assert maps.sentences["neutral", "happy"] == 2
    assert said[1].name in maps.notes[0].message


def test_one_sentence_is_not_enough() -> None:
    assert learn_emotion_maps(takes(1)) is None
