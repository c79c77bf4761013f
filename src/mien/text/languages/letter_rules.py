"""Reading a language whose spelling says how it sounds: Finnish.

Numbers, short forms and signs are written out first, then letters become phones, the longest group first; a letter
written twice is one long phone. What the letters, numbers and short forms are stands in the language's table.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import replace

from mien.core.errors import InputError, Note
from mien.text.languages.language import Language
from mien.text.languages.tokens import Token, is_from_other_script
from mien.text.languages.written_forms import spoken_tokens
from mien.text.spoken_text import SpokenText, SpokenWord

__all__ = ["phones_of_letters", "read_letters"]

_PIECE = re.compile(r"(?P<word>[^\W\d_]+(?:['’][^\W\d_]+)*)|(?P<sign>\S)")
_SILENT = "'’\"”“„«»()[]{}…-–—/\\*_~^|<>#`´"


def read_letters(text: str, language: Language) -> SpokenText:
    """The words that are said for a text; each has its phones.

    Raises
    ------
    InputError
        If nothing in it can be spoken, or a word is in another script.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> said = read_letters("Kello on 15, kuningas.", find_language("fi"))
    >>> said.spoken
    'kello on viisitoista kuningas'
    >>> said.words[-1].phones
    ('k', 'u', 'n', 'i', 'ŋː', 'ɑ', 's')
    """
    words: list[SpokenWord] = []
    dropped: list[str] = []
    replaced: list[str] = []
    for token in spoken_tokens(text, language):
        spoken: list[SpokenWord] = []
        for start, end, said in _pieces(token, language, dropped):
            for name in said.split():
                letters, strange = _folded(name, language)
                replaced += strange
                phones = phones_of_letters(letters, language)
                if phones:
                    spoken.append(SpokenWord(letters, start, end, "", phones))
        if spoken:
            words += [*spoken[:-1], replace(spoken[-1], pause=token.pause)]
        elif words and token.pause and not words[-1].pause:
            words[-1] = replace(words[-1], pause=token.pause)
    if not words:
        raise InputError(f"nothing in the text {text.strip()[:40]!r} can be spoken: give at least one word or number")
    return SpokenText(text, tuple(words), _notes(dropped, replaced, language))


def phones_of_letters(word: str, language: Language) -> tuple[str, ...]:
    """Phones of a word in small letters, by the rules of the language's table.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> finnish = find_language("fi")
    >>> [" ".join(phones_of_letters(word, finnish)) for word in ("tuuli", "tulli", "kengät", "kenkä", "yötyö")]
    ['t uː l i', 't u lː i', 'k e ŋː æ t', 'k e ŋ k æ', 'y ø t y ø']
    """
    rules = language.table["letters"]
    longest = max(map(len, rules))
    marked, place, found = f"#{word}", 0, list[str]()
    while place < len(marked):
        group = next(
            (marked[place : place + n] for n in range(longest, 0, -1) if marked[place : place + n] in rules), ""
        )
        if not group:  # the mark of the word's start, or an apostrophe
            place += 1
            continue
        last = group[-1]
        phones = list(rules[group])
        place += len(group)
        if len(group.lstrip("#")) == 1 and marked[place : place + 1] == last and not phones[-1].endswith("ː"):
            phones[-1] += "ː"
            place += 1
        found += phones
    return tuple(found)


def _pieces(token: Token, language: Language, dropped: list[str]) -> list[tuple[int, int, str]]:
    """Places in the text and what is said for them."""
    if token.said:
        if any(char.isdecimal() for char in token.said):  # numbers of this language are not known
            raise InputError(f"{language.name}: write {token.text!r} in words")
        return [(token.start, token.end, token.said)]
    pieces = []
    for match in _PIECE.finditer(token.text):
        said = (_spelled_out(match["word"], language) or match["word"]) if match["word"] else ""
        if not said and match["sign"] not in tuple(_SILENT):
            dropped.append(match.group())
        pieces.append((token.start + match.start(), token.start + match.end(), said))
    return pieces


def _spelled_out(word: str, language: Language) -> str:
    """The names of a word's letters, for capitals that make no word (WC, ATK) and single consonants."""
    names, small = language.table.get("letter_names", {}), word.lower()
    no_vowel = not any(letter in "aeiouyäöå" for letter in small)
    if all(letter in names for letter in small) and (no_vowel or (len(word) <= 3 and len(word) > 1 and word.isupper())):
        return " ".join(names[letter] for letter in small)
    return ""


def _folded(word: str, language: Language) -> tuple[str, list[str]]:
    """A word in the letters of the language, and the letters that had to be replaced."""
    known = set("".join(language.table["letters"]))
    out, strange = [], []
    for char in unicodedata.normalize("NFC", word).lower():
        if char in known or char in "'’":
            out.append(char)
            continue
        if is_from_other_script(char):
            raise InputError(f"expected {language.name}, but the word {word!r} is in another script: use Latin letters")
        plain = {"ü": "y", "ø": "ö", "æ": "ä", "õ": "ö", "ß": "ss", "đ": "d", "ł": "l", "þ": "t", "ð": "d"}.get(char)
        plain = plain or "".join(c for c in unicodedata.normalize("NFD", char) if c in known)
        out.append(plain)
        strange.append(f"{char!r} as {plain!r}" if plain else f"{char!r} as nothing")
    return "".join(out), strange


def _notes(dropped: Sequence[str], replaced: Sequence[str], language: Language) -> tuple[Note, ...]:
    notes = []
    if dropped:
        notes.append(Note("note", f"left out of the spoken text: {' '.join(dict.fromkeys(dropped))}"))
    if replaced:
        notes.append(Note("note", f"letters that {language.name} lacks are read: {', '.join(dict.fromkeys(replaced))}"))
    return tuple(notes)
