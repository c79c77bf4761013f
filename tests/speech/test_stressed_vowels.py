"""The punctuation that a word is followed by, for what the voice and the face make of it."""

from __future__ import annotations

import pytest

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.speech.stressed_vowels import stressed_words


def marks(text: str, words: str, language: str = "en-US") -> list[str]:
    """Of words of a tenth of a second each."""
    spans = tuple(Interval(n / 10, (n + 1) / 10, word) for n, word in enumerate(words.split()))
    phones = Tier("phones", tuple(Interval(span.start, span.end, "AA") for span in spans))
    sound = Audio.silence(spans[-1].end, 16_000)
    said = Utterance(text, sound, Tier("words", spans), phones, language, "aligned")
    return [word.mark for word in stressed_words(said)]


@pytest.mark.parametrize(
    ("text", "words", "found"),
    [
        ("Well, Mr. Jones is here. Is he?", "well mister jones is here is he", [",", "", "", "", ".", "", "?"]),
        ("Dr. Who came at 3 p.m. on Monday.", "doctor who came at three p. m. on monday", [""] * 8 + ["."]),
        ("She said: yes; no!", "she said yes no", ["", ":", ";", "!"]),
    ],
)
def test_a_short_form_ends_no_sentence(text: str, words: str, found: list[str]) -> None:
    assert marks(text, words) == found


def test_other_languages_have_the_marks_of_their_words() -> None:
    assert marks("Hei, mit\u00e4 kuuluu?", "hei mit\u00e4 kuuluu", "fi") == [",", "", "?"]


@pytest.mark.parametrize("text", ["\u0436\u0443\u043a", "one two", ""])
def test_a_text_that_does_not_fit_its_words_marks_nothing(text: str) -> None:
    assert marks(text, "one two three") == ["", "", ""]
