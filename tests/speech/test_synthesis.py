"""Text to an utterance."""

from __future__ import annotations

from itertools import pairwise

import pytest

from mien.core.errors import AlignmentError, InputError
from mien.core.utterance import PAUSE
from mien.speech import synthesis
from mien.speech.synthesis import synthesise
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import pronounce


def test_the_default_voice_speaks_and_is_aligned() -> None:
    text = "On May 3 Dr. Bell paid $5."
    utterance = synthesise(text)
    assert utterance.text == text
    assert utterance.timing == "aligned"
    assert utterance.language == "en-US"
    assert [word.label for word in utterance.words] == [
        "on",
        "may",
        "third",
        "doctor",
        "bell",
        "paid",
        "five",
        "dollars",
    ]
    phones = utterance.phones.intervals
    assert phones[0].label == phones[-1].label == PAUSE
    assert phones[-1].end == pytest.approx(utterance.duration)
    assert all(one.end == pytest.approx(two.start) for one, two in pairwise(phones))
    spoken = [phone.label for phone in phones if phone.label != PAUSE]
    assert spoken == [phone for word in utterance.words for phone in pronounce(word.label)]


def test_same_text_and_seed_same_utterance() -> None:
    assert synthesise("Twice the same.", seed=3) == synthesise("Twice the same.", seed=3)


def test_two_hundred_words() -> None:
    text = "We walked along the river, and the wind was cold. " * 20
    utterance = synthesise(text)
    assert len(utterance.words) == len(spoken_words(text).words) == 200
    assert 40 < utterance.duration < 100
    phones = utterance.phones.intervals
    assert all(one.end == pytest.approx(two.start) for one, two in pairwise(phones))
    assert all({one.label, two.label} != {PAUSE} for one, two in pairwise(phones))
    # The same sentence twenty times over, as the network made it: every copy has the same times.
    starts = [word.start for word in utterance.words]
    lengths = [starts[i + 9] - starts[i] for i in range(0, 200, 10)]
    assert max(lengths) - min(lengths) < 0.03


def test_what_was_left_out_of_the_text_is_noted() -> None:
    notes = synthesise("Fine ☃ then.").notes
    assert any("☃" in note.message for note in notes)


def test_the_voice_s_own_times_serve_where_alignment_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AlignmentError("no path")

    monkeypatch.setattr(synthesis, "align_words", refuse)
    utterance = synthesise("Hello there.")
    assert utterance.timing == "voice"
    assert [word.label for word in utterance.words] == ["hello", "there"]
    assert "could not be aligned: no path" in utterance.notes[-1].message


@pytest.mark.parametrize(("text", "reason"), [("", "empty"), ("  \n", "empty"), ("日本語", "script"), ("?!", "spoken")])
def test_texts_that_cannot_be_spoken(text: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        synthesise(text)


def test_unknown_voice() -> None:
    with pytest.raises(InputError, match="unknown voice"):
        synthesise("hello", voice="hal")
