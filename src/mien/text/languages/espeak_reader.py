"""Reading a language with eSpeak NG, run as a separate program (GPL-3): each word of a text to its phones in IPA."""

from __future__ import annotations

import re
from dataclasses import replace

from mien.core.errors import InputError, Note
from mien.text.languages.espeak_program import ask_espeak
from mien.text.languages.language import Language
from mien.text.languages.pinyin import with_tone_digits
from mien.text.languages.segmenting import can_segment, note_on_blanks, segmented
from mien.text.languages.tokens import Token
from mien.text.languages.written_forms import spoken_tokens
from mien.text.spoken_text import SpokenText, SpokenWord

__all__ = ["read_with_espeak"]


def read_with_espeak(text: str, language: Language) -> SpokenText:
    """The words that are said for a text; each has its phones.

    Raises
    ------
    InputError
        If nothing in it can be spoken.
    MissingPartError
        If eSpeak NG is not installed.
    """
    _refuse_unreadable(text, language)
    tokens = [part for token in spoken_tokens(text, language) for part in segmented(token, language)]
    spelled = [word for token in tokens for word in _words_of(token, language)]
    if not spelled:
        raise InputError(f"nothing in the text {text.strip()[:40]!r} can be spoken: give at least one word or number")
    asked = [_as_engines_want(word) for word in spelled]
    answers = iter(ask_espeak({"voice": language.espeak, "words": asked}, f"espeak-{language.tag}")[0]["words"])
    words: list[SpokenWord] = []
    dropped: list[str] = []
    for token in tokens:
        said = [(word, tuple(filter(None, map(_without_stress, next(answers))))) for word in _words_of(token, language)]
        spoken = [SpokenWord(word.lower(), token.start, token.end, "", phones) for word, phones in said if phones]
        for phone in (phone for _, phones in said for phone in phones):
            language.segments(
                phone
            )  # a phone that is in none of its tables is refused now, with a message that names it
        dropped += [word for word, phones in said if not phones]
        words += spoken
        if words and token.pause and (spoken or not words[-1].pause):
            words[-1] = replace(words[-1], pause=token.pause)
    if not words:
        raise InputError(f"nothing in the text {text.strip()[:40]!r} can be spoken: give at least one word or number")
    notes = (Note("note", f"left out of the spoken text: {' '.join(dict.fromkeys(dropped))}"),) if dropped else ()
    return SpokenText(text, tuple(words), notes + note_on_blanks(spelled, language))


def _words_of(token: Token, language: Language) -> list[str]:
    """What is said for a piece of text: itself, or the words that it stands for."""
    words = (token.said or token.text).split()
    return [with_tone_digits(word) for word in words] if language.table.get("pinyin") else words


def _as_engines_want(word: str) -> str:
    """A letter said by its name (``"a."``) as a capital."""
    return word[0].upper() if len(word) == 2 and word[1] == "." else word


def _refuse_unreadable(text: str, language: Language) -> None:
    table: dict[str, str] = language.table.get("not_read", {})
    found = re.search(table["pattern"], text) if table and not can_segment(language) else None
    if found is not None:
        raise InputError(f"{language.name}: {found.group()!r} cannot be read: {table['instead']}")


def _without_stress(phone: str) -> str:
    return "" if phone.startswith("(") else phone.strip("ˈˌ‿ -|")  # "(en)": another language's word follows
