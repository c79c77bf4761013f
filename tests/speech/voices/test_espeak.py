"""What is particular to eSpeak's voices."""

from __future__ import annotations

import pytest

from mien.core.progress import listening
from mien.emotion.emotional_voice import FIGURES
from mien.speech.voices import espeak
from mien.speech.voices.espeak import Espeak, espeak_languages
from mien.speech.voices.sentences import in_groups, sentences_of
from mien.text.normalisation import spoken_words


def test_a_formant_voice_carries_part_of_an_emotions_pitch_and_tilt() -> None:
    voices = (Espeak(), *espeak_languages()[:1])
    assert all(0 < voice.feeling[name] < 1 for voice in voices for name in ("pitch", "tilt"))
    assert set(Espeak().feeling) <= set(FIGURES)


def test_a_long_text_is_spoken_in_groups_of_whole_sentences(monkeypatch: pytest.MonkeyPatch) -> None:
    text = spoken_words("He came home early. Nobody saw him at all. " * 60)
    sentences = sentences_of(text)
    groups = list(in_groups(sentences))
    assert [sentence for group in groups for sentence in group] == list(sentences)
    assert [sum(len(sentence.words) for sentence in group) for group in groups] == [504, 36]
    asked: list[int] = []
    engine = espeak.ask_espeak
    monkeypatch.setattr(
        espeak, "ask_espeak", lambda request, voice: asked.append(len(request["sentences"])) or engine(request, voice)
    )
    told: list[tuple[str, int, int]] = []
    with listening(lambda *said: told.append(said)):
        speech = Espeak().speak(text)
    assert asked == [len(group) for group in groups]
    assert told == [("speaking", len(groups[0]), 120), ("speaking", 120, 120)]
    assert speech.words is not None
    assert len(speech.words) == len(text.words)
