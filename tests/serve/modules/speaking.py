"""A voice for tests: every letter is a phone of a tenth of a second, every word a buzz; no engine is needed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import pronounce

RATE, EDGE, PHONE = 8000, 0.2, 0.1


def toy_speech(
    text: str,
    voice: str | None = None,
    seed: int = 0,
    language: object = None,
    spellings: Sequence[object] = (),
) -> Utterance:
    """Words one after another without gaps, a fifth of a second of silence at either end."""
    now, phones, words = EDGE, [Interval(0.0, EDGE, "SIL")], []
    for word in spoken_words(text).words:
        start = now
        for phone in pronounce(word.text):
            phones.append(Interval(now, now + PHONE, phone))
            now = round(now + PHONE, 6)
        words.append(Interval(start, now, word.text))
    phones.append(Interval(now, now + EDGE, "SIL"))
    samples = np.zeros(round((now + EDGE) * RATE))
    inside = slice(round(EDGE * RATE), round(now * RATE))
    samples[inside] = 0.5 * np.sin(2 * np.pi * 200 * np.arange(len(samples)) / RATE)[inside]
    return Utterance(
        text, Audio(samples, RATE), Tier("words", tuple(words)), Tier("phones", tuple(phones)), "en-US", "voice"
    )


@pytest.fixture
def toy_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.speech.synthesis.synthesise", toy_speech)
