"""The WAV holds every sample."""

from __future__ import annotations

import soundfile

from mien.formats.wav import write_sound
from tests.faces import tiny_animation


def test_every_sample_is_kept(tmp_path):
    sound = tiny_animation().utterance.audio
    write_sound(sound, tmp_path / "a.wav")
    samples, rate = soundfile.read(tmp_path / "a.wav", dtype="float32")
    assert rate == sound.rate
    assert samples.tobytes() == sound.samples.tobytes()
    assert soundfile.info(tmp_path / "a.wav").subtype == "PCM_24"
