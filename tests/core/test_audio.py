from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.audio import Audio
from mien.core.errors import InputError


def test_samples_lie_on_the_24_bit_grid_and_are_clipped() -> None:
    audio = Audio([0.1, 2.0, -2.0], 8000)
    steps = audio.samples.astype(np.float64) * 2**23
    assert np.array_equal(steps, np.round(steps))
    assert audio.samples[1] < 1.0
    assert audio.samples[2] == -1.0


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_a_lossless_file_gives_the_same_sound_back(tmp_path: Path, suffix: str) -> None:
    import soundfile

    audio = Audio(np.random.default_rng(1).uniform(-1, 1, 4000), 16000)
    audio.write(tmp_path / f"sound{suffix}")
    samples, rate = soundfile.read(tmp_path / f"sound{suffix}", dtype="float64")
    assert Audio(samples, rate) == audio


@given(st.integers(2000, 30000), st.sampled_from([8000, 16000, 22050, 44100]), st.sampled_from([16000, 24000, 48000]))
def test_resampling_keeps_the_duration(length: int, source: int, target: int) -> None:
    audio = Audio(np.zeros(length), source).resampled(target)
    assert abs(audio.duration - length / source) <= 1.5 / target


def test_resampling_keeps_a_tone() -> None:
    time = np.arange(16000) / 16000
    tone = Audio(0.5 * np.sin(2 * np.pi * 440 * time), 16000).resampled(48000)
    expected = 0.5 * np.sin(2 * np.pi * 440 * np.arange(48000) / 48000)
    assert np.abs(tone.samples[4800:-4800] - expected[4800:-4800]).max() < 1e-3


def test_silence_is_told_from_sound() -> None:
    assert Audio.silence(1, 16000).is_silent()
    assert Audio(1e-4 * np.random.default_rng(1).standard_normal(16000), 16000).is_silent()
    click = np.zeros(16000)
    click[8000:8400] = 0.3
    assert not Audio(click, 16000).is_silent()
    assert Audio(np.zeros(0), 16000).is_silent()


@pytest.mark.parametrize(
    ("samples", "rate", "words"),
    [(np.zeros((3, 2)), 8000, "one channel"), ([0.0], 0, "sample rate"), ([0.0, np.nan], 8000, "at sample 1")],
)
def test_bad_sound_is_refused(samples: object, rate: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Audio(samples, rate)  # type: ignore[arg-type]


def test_joined_sounds_follow_one_another() -> None:
    assert Audio.join([Audio([0.5], 8000), Audio([0.25], 8000)]).samples.tolist() == [0.5, 0.25]
    with pytest.raises(InputError, match="one sample rate"):
        Audio.join([Audio([0.5], 8000), Audio([0.25], 16000)])
