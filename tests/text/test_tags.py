"""Other names of emotions, and their short tags."""

from __future__ import annotations

import pytest

from mien.core.emotions import NOUNS, emotion_called
from mien.text.score import EmotionSpan
from mien.text.script_reading import read_script
from mien.text.tags import with_long_tags


@pytest.mark.parametrize(("noun", "emotion"), sorted(NOUNS.items()))
def test_nouns_are_understood_where_an_emotion_is_asked_for(noun: str, emotion: str) -> None:
    assert EmotionSpan.parse(f"{noun.title()}:0.4").name == emotion
    assert read_script(f"<{noun}>Well.</{noun}>").emotions[0].name == emotion


def test_a_short_tag_holds_to_the_end_or_to_the_next() -> None:
    script = read_script("One. <angry 0.6>Two. <sad>Three.")
    assert [(span.name, span.intensity) for span in script.emotions] == [("angry", 0.6), ("sad", 1.0)]
    assert script.text.split() == ["One.", "Two.", "Three."]
    assert [note.message.split(":")[1] for note in script.notes] == [
        " <angry> is never closed with </angry>",
        " <sad> is never closed with </sad>",
    ]
    assert not read_script("<sad>One.</sad>").notes


def test_what_is_no_emotion_is_left_alone() -> None:
    for text in ("3 < 4 > 2", "a <sadly> b", "<HeadNod/> Hello.", '<emotion name="sad">x</emotion>'):
        assert with_long_tags(text) == (text, ())
    assert with_long_tags("<sad>x</sad>", known={"sad"})[0] == "<sad>x</sad>"


def test_a_word_of_ones_own_stays() -> None:
    assert emotion_called(" Wistful ") == "wistful"
