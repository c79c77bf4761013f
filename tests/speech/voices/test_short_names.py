"""Voices by the part of their name that no other has, and by kind."""

from __future__ import annotations

import pytest

from mien.core.errors import InputError
from mien.speech.voices import catalogue, get_voice


@pytest.mark.parametrize(
    ("asked", "named"),
    [("heart", "kokoro-heart"), ("Heart", "kokoro-heart"), ("female", "kokoro-heart"), ("male", "kokoro-michael")],
)
def test_short_names(asked: str, named: str) -> None:
    assert get_voice(asked).name == named


@pytest.mark.parametrize("asked", ["kokoro", "hart", ""])
def test_what_is_not_clear_is_asked_back(asked: str) -> None:
    with pytest.raises(InputError, match="unknown voice"):
        get_voice(asked)


def test_every_shipped_voice_has_a_kind() -> None:
    assert {voice.sounds for voice in catalogue()} == {"female", "male"}
