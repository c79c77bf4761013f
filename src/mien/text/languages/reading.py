"""Texts of any language to the words that are said for them, each with its phones."""

from __future__ import annotations

from pathlib import Path

from mien.core.limits import check_size
from mien.text.languages.espeak_reader import read_with_espeak
from mien.text.languages.language import Language, find_language
from mien.text.languages.letter_rules import read_letters
from mien.text.normalisation import spoken_words
from mien.text.spoken_text import SpokenText

__all__ = ["read_in", "read_words"]


def read_in(language: Language, text: str) -> SpokenText:
    """The words that are said for a text; each knows its phones, in the language's own signs.

    Raises
    ------
    InputError
        If there is nothing in the text that can be spoken.
    MissingPartError
        If the language is read by eSpeak NG and it is not installed.
    """
    check_size("spoken", len(text), "the text")
    return read_letters(text, language) if language.reader == "letters" else read_with_espeak(text, language)


def read_words(text: str, language: str | Path | None = None, spoken: str | None = None) -> SpokenText:
    """The words that are said for a text, in any language.

    Parameters
    ----------
    text : str
    language : str, Path or None
        As `find_language` takes it.
    spoken : str or None
        The tag of what it was spoken as, where no language was asked for.
    """
    found = find_language(language if language is not None else spoken)
    return spoken_words(text) if found is None else read_in(found, text)
