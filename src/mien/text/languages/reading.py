"""Texts of any language to the words that are said for them, each with its phones.

Does a text look like another language than the one it is read as? That is only said, never acted upon.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from mien.core.errors import Note
from mien.core.limits import check_size
from mien.text.languages.espeak_reader import read_with_espeak
from mien.text.languages.language import Language, find_language, known_languages
from mien.text.languages.letter_rules import read_letters
from mien.text.normalisation import spoken_words
from mien.text.spoken_numbers import english_table
from mien.text.spoken_text import SpokenText

__all__ = ["looks_like", "note_on_language", "read_in", "read_words"]

_LEAST = 2
_LETTER_COUNTS = 1.0


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


@cache
def _signs() -> dict[str, tuple[frozenset[str], frozenset[str]]]:
    found = {}
    for tag in known_languages():
        language = find_language(tag)
        if language is not None:
            table = language.table
            found[tag] = frozenset(table.get("known_by", ())), frozenset(table.get("known_by_letters", ""))
    return found


def looks_like(text: str) -> str | None:
    """Tag of the language that a text seems to be in, if that is not English and mien knows it.

    Small words that the language has and English lacks are counted, and words with letters that English lacks; the
    language must have two such words more than English has of its own.

    Examples
    --------
    >>> looks_like("Ich habe das nicht gesagt."), looks_like("Hyvää päivää."), looks_like("I never said that.")
    ('de', 'fi', None)
    >>> looks_like("The naïve café in El Paso is the best.") is None
    True
    """
    words = re.findall(r"[^\W\d_]+", text.lower())
    own = frozenset(english_table()["known_by"]["words"].split())
    english = sum(word in own for word in words)
    scores = {
        tag: sum((word in small and word not in own) + _LETTER_COUNTS * bool(letters & set(word)) for word in words)
        for tag, (small, letters) in _signs().items()
    }
    best = max(scores, key=lambda tag: scores[tag])
    return best if scores[best] >= max(_LEAST, english + 1) else None


def note_on_language(text: str) -> tuple[Note, ...]:
    """A note for a text that is about to be read as English and looks like another language."""
    tag = looks_like(text)
    language = find_language(tag) if tag else None
    if language is None:
        return ()
    return (
        Note("note", f"the text looks like {language.name} and is read as English: --language {tag} reads it as such"),
    )
