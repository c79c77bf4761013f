"""What is particular to eSpeak's voices."""

from __future__ import annotations

from mien.emotion.emotional_voice import FIGURES
from mien.speech.voices.espeak import Espeak, espeak_languages


def test_a_formant_voice_carries_part_of_an_emotions_pitch_and_tilt() -> None:
    voices = (Espeak(), *espeak_languages()[:1])
    assert all(0 < voice.feeling[name] < 1 for voice in voices for name in ("pitch", "tilt"))
    assert set(Espeak().feeling) <= set(FIGURES)
