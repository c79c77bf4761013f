from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.formats.sound_files import read_audio
from mien.motion.effort import DECIBELS
from mien.speech.vocal_effort import read_effort, voice_decibels
from mien.speech.voice_features import analyse

DATA = Path(os.environ.get("MIEN_DATA", Path(__file__).parents[2].parent / "shared" / "data"))
ACTORS = ("01", "03", "05", "08", "09", "12")
needs_recordings = pytest.mark.skipif(not (DATA / "ravdess-half").exists(), reason="needs the shared recordings")


def voice(hertz: float, tilt: float, seconds: float = 2.0, level: float = 0.1) -> Audio:
    """Harmonics that fall by ``tilt`` dB an octave, in syllables of a quarter second."""
    rate = 16_000
    times = np.arange(round(seconds * rate)) / rate
    partials = np.arange(1, int(6000 / hertz))
    sound = sum(10 ** (-tilt * np.log2(n) / 20) * np.sin(2 * np.pi * n * hertz * times + n) for n in partials)
    syllables = 0.55 + 0.45 * np.sin(2 * np.pi * 4 * times)
    sound = np.asarray(sound * syllables)
    return Audio((level * sound / np.abs(sound).max()).astype(np.float32), rate)


def test_a_bright_high_voice_works_harder_than_a_dull_low_one() -> None:
    calm, strained = (read_effort(sound, DECIBELS) for sound in (voice(120, 15), voice(330, 4)))
    assert calm.decibels == 0
    assert strained.decibels > 15
    assert np.mean(strained.levels) > 1.4


def test_the_level_of_a_recording_says_nothing() -> None:
    read = [read_effort(voice(250, 7, level=level), DECIBELS) for level in (0.9, 0.09, 0.02)]
    assert read[0].decibels > 1
    assert max(r.decibels for r in read) - min(r.decibels for r in read) < 1
    assert np.abs(np.array(read[0].levels) - read[1].levels).max() < 0.1


def test_within_a_recording_level_counts() -> None:
    soft, loud = voice(150, 12, level=0.03), voice(150, 12, level=0.3)
    read = read_effort(Audio.join([soft, loud]), DECIBELS)
    times, levels = np.array(read.times), np.array(read.levels)
    assert levels[(times > 2.5) & (times < 3.5)].mean() > levels[(times > 0.5) & (times < 1.5)].mean() + 0.2


def test_a_whisper_is_little_effort_and_silence_is_ordinary() -> None:
    noise = np.random.default_rng(1).normal(0, 0.05, 32_000) * (0.5 + 0.5 * np.sin(np.arange(32_000) / 600))
    whispered = read_effort(Audio(noise.astype(np.float32), 16_000), DECIBELS)
    assert whispered.decibels < 0
    assert "whispered" in whispered.told
    silent = read_effort(Audio.silence(1.0, 16_000), DECIBELS)
    assert silent.levels == (1.0,)


@needs_recordings
def test_strong_anger_is_heard_against_the_same_actors_neutral_voice() -> None:
    for actor in ACTORS:
        calm, angry = (
            read_effort(read_audio(DATA / "ravdess-half" / f"03-01-{kind}-01-01-{actor}.flac")[0], DECIBELS)
            for kind in ("01-01", "05-02")
        )
        assert calm.decibels < 4, actor
        assert angry.decibels > 12, actor


@needs_recordings
def test_ordinary_speech_of_other_microphones_is_one() -> None:
    for corpus in ("grid-s1", "timit-sample"):
        paths = sorted((DATA / corpus).rglob("*.flac"))[::9][:12]
        found = [voice_decibels(analyse(read_audio(path)[0]))[0] for path in paths]
        assert np.mean(found) < 3, corpus
        assert np.median(found) == 0, corpus
