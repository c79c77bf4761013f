"""Songs: a band is subtracted, held sound compressed, lyrics found."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import mien
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.speech.song import align_song, held_notes, note_on_singing, song_time, without_band
from tests.programs import voice_or_skip

RATE = 16_000
TIME = np.arange(4 * RATE) / RATE


def made_songs() -> ModuleType:
    path = Path(__file__).parents[2] / "benchmarks" / "made_songs.py"
    spec = importlib.util.spec_from_file_location("made_songs", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    import sys

    sys.modules["made_songs"] = module
    spec.loader.exec_module(module)
    return module


def power(samples: np.ndarray, hertz: float) -> float:
    return float(np.abs(np.mean(samples * np.exp(-2j * np.pi * hertz * TIME[: len(samples)]))) ** 2)


def test_what_stays_is_subtracted_and_what_moves_is_kept() -> None:
    chord = 0.2 * np.sin(2 * np.pi * 500 * TIME)
    voice = 0.2 * np.sin(2 * np.pi * 1200 * TIME) * (np.sin(2 * np.pi * 2 * TIME) > 0.2)
    left = without_band(Audio(chord + voice, RATE))
    assert power(left, 500) < 0.1 * power(chord, 500)
    assert power(left, 1200) > 0.5 * power(voice, 1200)


def test_rests_are_turned_down() -> None:
    noise = np.random.default_rng(0).standard_normal(len(TIME))
    sound = noise * np.where((TIME > 1) & (TIME < 2), 0.2, 0.01)
    left = without_band(Audio(sound, RATE))
    assert np.abs(left[3 * RATE :]).max() < 0.02 * np.abs(left[RATE : 2 * RATE]).max()


def test_held_sound_is_compressed_and_lively_sound_is_not() -> None:
    random = np.random.default_rng(1)
    steps = np.repeat(random.choice([300, 700, 1500, 2500, 4000], 40), RATE // 20)
    lively = np.sin(2 * np.pi * np.cumsum(steps) / RATE)
    held = np.sin(2 * np.pi * 700 * TIME[: 2 * RATE])
    old, new = song_time(np.concatenate([lively, held]))
    assert old[0] == new[0] == 0
    assert (np.diff(new) > 0).all()
    first = float(np.interp(2.0, old, new))
    assert first > 1.6
    assert new[-1] - first < 0.8


def test_lyrics_are_found_in_a_made_song() -> None:
    voice_or_skip("espeak")
    song = made_songs().make_song("river", "espeak", 10.0)
    found = align_song(song.audio, song.lyrics)
    assert found.sung
    assert found.duration == pytest.approx(song.audio.duration)
    assert found.phones.intervals[-1].end == pytest.approx(song.audio.duration)
    assert [w.label for w in found.words] == [w.label for w in song.truth.words]
    error = [abs(a.start - b.start) for a, b in zip(found.words, song.truth.words, strict=True)]
    assert np.median(error) < 0.3


def test_a_silent_song_rests() -> None:
    found = align_song(Audio.silence(1.0, RATE), "la la")
    assert found.timing == "none"
    assert found.sung


def test_a_song_needs_lyrics() -> None:
    with pytest.raises(InputError, match="a song needs its lyrics"):
        mien.animate(Audio.silence(1.0, RATE), song=True)


def test_a_song_that_is_taken_for_speech_is_told_and_speech_is_not() -> None:
    steps = np.repeat([220.0, 262.0, 294.0, 220.0], RATE)
    song = Audio(0.3 * np.sin(2 * np.pi * np.cumsum(steps) / RATE), RATE)
    share, count = held_notes(song)
    assert share > 0.8
    assert count >= 3
    (note,) = note_on_singing(song)
    assert "--song" in note.message
    glide = 150 + 60 * np.sin(2 * np.pi * 1.5 * TIME)
    assert note_on_singing(Audio(0.3 * np.sin(2 * np.pi * np.cumsum(glide) / RATE), RATE)) == ()


def test_the_tail_of_a_note_belongs_to_its_word() -> None:
    from mien.core.timeline import Interval, Tier
    from mien.speech.song import _sung_through

    sound = 0.3 * np.sin(2 * np.pi * 600 * TIME) * ((TIME > 0.5) & (TIME < 2.0) | (TIME > 3.0))
    phones = Tier("phones", (
        Interval(0, 0.5, "SIL"), Interval(0.5, 1.2, "AA"), Interval(1.2, 3.3, "SIL"), Interval(3.3, 4.0, "AA")
    ))  # fmt: skip
    moved = _sung_through(phones, sound)
    assert moved[1.2] == pytest.approx(2.0, abs=0.05)
    assert moved[3.3] == pytest.approx(3.0, abs=0.05)
