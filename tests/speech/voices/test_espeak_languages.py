"""What eSpeak NG's phones hold in other languages that is no sound of its own."""

from __future__ import annotations

import pytest

from mien.core.utterance import PAUSE
from mien.speech.voices import catalogue
from mien.text.languages import find_language, read_in


@pytest.mark.parametrize(
    ("tag", "text", "phones"),
    [
        ("it", "grazie, treno", "ɡ r a"),  # a trill is led in by a moment of silence
        ("ru", "красный, пять", "k r ɑ"),
        ("fr", "une église éthiopique", "ɪ θ ɪ"),  # read as English: the engine says so by marks among the phones
    ],
)
def test_only_sounds_are_phones(tag: str, text: str, phones: str) -> None:
    voice = next(voice for voice in catalogue() if voice.name == f"espeak-{tag}")
    if not voice.availability().installed:
        pytest.skip(f"eSpeak NG is not installed; {voice.availability().hint}")
    language = find_language(tag)
    assert language is not None
    speech = voice.speak(read_in(language, text))
    assert speech.phones is not None
    labels = [phone.label for phone in speech.phones]
    assert phones in " ".join(labels)
    for label in set(labels) - {PAUSE}:
        language.segments(label)  # an unknown one is refused
