"""What is written and not said: directions, speakers' names."""

from __future__ import annotations

import pytest

from mien.text.normalisation import spoken_words


@pytest.mark.parametrize(
    ("written", "said", "noted"),
    [
        ("[door slams] Who is there?", "who is there", "door slams"),
        ("Well (sighs) that is that.", "well that is that", "sighs"),
        ("(very quietly) Go.", "go", "very quietly"),
        ("*laughs* No.", "no", "laughs"),
        ("I *really* mean it (see below).", "i really mean it see below", ""),
        ("It is late (the pause was long).", "it is late the pause was long", ""),
        ("ANNA: Hello.", "hello", "ANNA"),
        ("Anna: Hello.\nBob: Hi.\nAnna: Bye.", "hello hi bye", "Anna, Bob"),
        ("Anna: hello.", "anna hello", ""),
        ("NOTE: read this.\nTip: and this.", "note read this tip and this", ""),
    ],
)
def test_directions_and_names_are_not_spoken_and_named_in_a_note(written: str, said: str, noted: str) -> None:
    text = spoken_words(written)
    assert text.spoken == said
    assert [noted in note.message for note in text.notes] == ([True] if noted else [])


def test_places_in_the_written_text_are_kept() -> None:
    written = "ANNA: (sighs) The ﬁne [bang] line."
    text = spoken_words(written)
    assert [written[word.start : word.end] for word in text.words] == ["The", "ﬁne", "line"]
    assert text.words[-1].pause == "."
