from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.formats.sound_files import read_audio
from mien.speech import pitch
from mien.speech.pitch import QUIETEST, level_contour, pitch_contour

RATE = 16_000


def voice(hertz: float, seconds: float = 0.6, rate: int = RATE, level: float = 0.1) -> Audio:
    """A buzz with overtones that fall off."""
    t = np.arange(round(seconds * rate)) / rate
    return Audio(level * sum(np.sin(2 * np.pi * k * hertz * t) / k for k in range(1, 8)), rate)


@pytest.mark.parametrize("hertz", [90, 150, 260, 500])
@pytest.mark.parametrize("rate", [16_000, 44_100])
def test_the_pitch_of_a_buzz_is_found(hertz: float, rate: int) -> None:
    contour = pitch_contour(voice(hertz, rate=rate))
    assert contour.voiced.mean() > 0.8
    assert contour.median == pytest.approx(hertz, rel=0.01)


def test_a_quiet_recording_has_the_same_pitch() -> None:
    loud, quiet = (pitch_contour(voice(180, level=level)) for level in (0.2, 0.002))
    assert np.array_equal(loud.voiced, quiet.voiced)
    assert np.allclose(loud.hertz[loud.voiced], quiet.hertz[loud.voiced], rtol=0.01)


def test_times_stand_on_the_sound() -> None:
    """Voice from 0.5 to 1 s of 1.5 s."""
    sound = Audio.join([Audio.silence(0.5, RATE), voice(200, 0.5), Audio.silence(0.5, RATE)])
    contour = pitch_contour(sound)
    assert np.allclose(np.diff(contour.times), 0.016)
    assert contour.times[-1] <= sound.duration
    heard = contour.times[contour.voiced]
    assert heard[0] == pytest.approx(0.5, abs=0.05)
    assert heard[-1] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("seconds", [0.0, 0.001, 1.0])
def test_silence_has_no_pitch(seconds: float) -> None:
    contour = pitch_contour(Audio.silence(seconds, RATE))
    assert len(contour) >= 1
    assert not contour.voiced.any()
    assert np.isnan(contour.median)
    assert np.isnan(contour.hertz_at([0.0, 0.5])).all()


def test_noise_has_no_pitch() -> None:
    assert pitch_contour(Audio(np.random.default_rng(0).normal(0, 0.1, RATE), RATE)).voiced.mean() < 0.05


def test_gaps_are_bridged_when_asked_at_any_time() -> None:
    sound = Audio.join([voice(100), Audio.silence(0.4, RATE), voice(200)])
    contour = pitch_contour(sound)
    at = contour.hertz_at([0.0, 0.3, 0.8, 1.3, 9.0])
    assert at[[0, 1]] == pytest.approx([100, 100], rel=0.05)
    assert 110 < at[2] < 190
    assert at[[3, 4]] == pytest.approx([200, 200], rel=0.05)


def test_semitones_are_twelve_to_the_octave() -> None:
    contour = pitch_contour(voice(220))
    assert np.nanmedian(contour.semitones(110)) == pytest.approx(12, abs=0.2)
    assert np.nanmedian(contour.semitones()) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("band", [(20, 300), (300, 200), (60, 4000)])
def test_a_range_out_of_reach_is_refused(band: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="pitch is found from"):
        pitch_contour(voice(200), *band)


def test_levels_are_known() -> None:
    sound = Audio.join([Audio.silence(0.2, RATE), Audio(np.tile([0.1, -0.1], RATE // 4), RATE)])
    contour = level_contour(sound)
    assert np.allclose(np.diff(contour.times), 0.016)
    assert contour.decibels[0] == QUIETEST
    assert contour.decibels[-1] == pytest.approx(-20, abs=0.01)
    assert contour.decibels_at([0.45]) == pytest.approx(-20, abs=0.01)


def test_frames_of_level_and_pitch_coincide() -> None:
    sound = voice(200, 1.23)
    assert np.allclose(level_contour(sound).times, pitch_contour(sound).times)


def test_nothing_is_written_in_the_home_folder(tmp_path: Path) -> None:
    program = (
        "import numpy as np; from mien.core.audio import Audio; from mien.speech.pitch import pitch_contour;"
        "pitch_contour(Audio(0.1 * np.sin(np.arange(16000) / 12), 16000))"
    )
    environment = {k: v for k, v in os.environ.items() if k not in ("ORT_DISABLE_TELEMETRY", "XDG_CACHE_HOME")}
    subprocess.run([sys.executable, "-c", program], check=True, env={**environment, "HOME": str(tmp_path)})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.data
def test_women_speak_higher_than_men(shared_data: Path) -> None:
    """EmoDB: speaker 03 is a man, 09 a woman."""
    medians = {}
    for speaker in ("03", "09"):
        files = sorted((shared_data / "emodb" / "audio").glob(f"{speaker}*N*.flac"))
        medians[speaker] = np.median([pitch_contour(read_audio(path)[0]).median for path in files])
    assert 80 < medians["03"] < 150
    assert 160 < medians["09"] < 260


def test_one_sound_is_listened_to_once(monkeypatch: pytest.MonkeyPatch) -> None:
    sound, other = voice(150), voice(150)
    first = pitch_contour(sound)
    monkeypatch.setattr(pitch, "_detector", lambda: pytest.fail("listened again"))
    assert pitch_contour(sound) is first
    with pytest.raises(pytest.fail.Exception):
        pitch_contour(other)
    with pytest.raises(pytest.fail.Exception):
        pitch_contour(sound, lowest=80.0)
