"""Written English to spoken words: numbers, dates, money, abbreviations, acronyms, signs.

`spoken_words` reads a text from left to right. At each place the first pattern of `mien.text.text_patterns` that
fits says what is spoken there, so the most special come first (an address on the net before a plain word). What the
signs and abbreviations stand for is data: ``assets/text/english.toml``.

Not said are: what stands in square brackets, ``[door slams]``; a few words in round brackets or between asterisks that
say how somebody speaks or what is heard, ``(sighs)``, ``*laughs*``, ``(very quietly)``; the name of a speaker at the
start of a line, ``ANNA:``, or ``Anna:`` where several lines begin with names. Each is named in a note.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from mien.core.errors import InputError, Note
from mien.core.limits import check_size, most
from mien.text.heteronyms import with_heteronyms
from mien.text.pronunciation import Pronunciation, pronounce
from mien.text.spoken_numbers import english_table
from mien.text.spoken_text import SpokenText, SpokenWord
from mien.text.text_patterns import READERS, TEXT_PATTERN

__all__ = ["pronounce_text", "spoken_words"]


def spoken_words(text: str) -> SpokenText:
    """Turn written English into the words that are said.

    Parameters
    ----------
    text : str
        Ordinary English. Signs that are not said, such as emoji, are left out with one note.

    Returns
    -------
    SpokenText

    Raises
    ------
    InputError
        If there is nothing to say, or a word is in a script that an English voice cannot speak.

    Examples
    --------
    >>> spoken_words("Dr. Smith paid $3.50 on March 5, 2024.").spoken
    'doctor smith paid three dollars fifty cents on march fifth twenty twenty four'
    >>> [word.pause for word in spoken_words("Well, is it 5%?").words]
    [',', '', '', '', '?']
    """
    if not text.strip():
        raise InputError("a text to speak is empty: give at least one word")
    check_size("spoken", len(text), "the text")
    clean, origin, dropped = _clean(text)
    clean, notes = _without_directions(clean)
    words = [
        SpokenWord(word.text, origin[word.start], origin[word.end - 1] + 1, word.pause, word.phones)
        for word in _scan(clean)
    ]
    if not words:
        raise InputError(f"nothing in the text {_shorten(text)!r} can be spoken: give at least one word or number")
    if dropped:
        notes += (Note("note", f"left out of the spoken text: {' '.join(dict.fromkeys(dropped))}"),)
    return SpokenText(text, with_heteronyms(words), notes)


def pronounce_text(text: str) -> tuple[tuple[str, Pronunciation], ...]:
    """Each spoken word of a written text with its pronunciation.

    Examples
    --------
    >>> pronounce_text("2 cats")
    (('two', ('T', 'UW')), ('cats', ('K', 'AE', 'T', 'S')))
    """
    return tuple((word.text, pronounce(word.text)) for word in spoken_words(text).words)


# ---- Letters and signs -------------------------------------------------------------------------------------------

_SAME_LENGTH = str.maketrans(
    {"‘": "'", "’": "'", "ʼ": "'", "´": "'", "`": "'", "“": '"', "”": '"', "„": '"', "«": '"', "»": '"'}
    | {"‐": "-", "‑": "-", "−": "-", "–": "—", "―": "—", "…": ".", "\u00a0": " ", "\u2009": " ", "\u202f": " "}
)


def _clean(text: str) -> tuple[str, Sequence[int], list[str]]:
    """A text in plain letters, known signs and blanks; the written character of each; what was dropped."""
    plain = text.translate(_SAME_LENGTH)
    read_as = {char: _cleaned(char) for char in set(plain)}
    if all(char == read for char, read in read_as.items()):
        return plain, range(len(plain)), []
    out: list[str] = []
    origin: list[int] = []
    dropped: list[str] = []
    for place, char in enumerate(plain):
        read = read_as[char]
        if read is None:
            raise _wrong_script(text, place)
        if read == " " and unicodedata.category(char)[0] == "S":
            dropped.append(char)
        out.append(read)
        origin += [place] * len(read)
    return "".join(out), origin, dropped


def _cleaned(char: str) -> str | None:
    """What one character counts as; None for a letter or digit of a script that English is not written in.

    Ligatures, letters of formulas, circled and full-width letters and their like count as the plain letters that they
    stand for (Unicode's compatibility decomposition).
    """
    category = unicodedata.category(char)
    if (
        char.isascii()
        or char in english_table()["signs"]
        or char in "—¡¿‰"
        or char in english_table()["folded_letters"]
    ):
        return char if category[0] != "C" or char == "\n" else " "
    plain = unicodedata.normalize("NFKC", char)
    if plain != char and plain.isascii() and plain.isalnum():
        return plain
    if category[0] == "L" and _is_latin(char):
        return char
    if category[0] == "L" or category in ("Nd", "Nl", "Mc"):
        return None
    return "\u0301" if category == "Mn" else " "


def _is_latin(char: str) -> bool:
    return unicodedata.name(char, "").startswith("LATIN")


def _wrong_script(text: str, place: int) -> InputError:
    script = unicodedata.name(text[place], "unknown").split()[0].replace("CJK", "Chinese").capitalize()
    start = max(text.rfind(blank, 0, place) for blank in " \n\t") + 1
    word = text[start:].split(maxsplit=1)[0]
    return InputError(
        f"expected English, but the word {_shorten(word)!r} at character {place + 1} is in the {script} script: "
        "write it in Latin letters"
    )


def _shorten(text: str, limit: int = 40) -> str:
    return text if len(text) <= limit else text[: limit - 1] + "…"


# ---- Reading from left to right ------------------------------------------------------------------------------------

_PAUSE_RANK = "-,;:!?."
_LAST = re.compile(r"[ \"')\]]*\Z")


def _scan(text: str) -> list[SpokenWord]:
    words: list[SpokenWord] = []
    shouting = _is_shouting(text)
    longest = most("word")
    place = 0
    while place < len(text):
        match = TEXT_PATTERN.match(text, place)
        if match is None or match.end() == place:
            if text[place] == "\n" and text[place + 1 : place + 2] == "\n":
                _note_pause(words, ".")  # a new paragraph; a single new line may be no more than the edge of the page
            elif text[place] != "-" or text[place - 1 : place + 2].strip() == "-":
                _note_pause(words, text[place])
            place += 1
            continue
        name = match.lastgroup or ""
        for start, end, spoken in READERS[name](match, text, shouting):
            for word in spoken.split():
                if len(word) > longest:
                    check_size("word", len(word), f"the word {text[start : start + 20]!r}")
                words.append(SpokenWord(word, start, end))
        place = match.end()
        if name == "abbreviation" and _LAST.match(text, place):
            _note_pause(words, ".")
    return words


def _note_pause(words: list[SpokenWord], char: str) -> None:
    char = {"—": "-", "(": ",", ")": ","}.get(char, char)
    if words and char in _PAUSE_RANK and char != "-":
        if not words[-1].pause or _PAUSE_RANK.index(char) > _PAUSE_RANK.index(words[-1].pause):
            words[-1] = replace(words[-1], pause=char)
    elif words and char == "-" and not words[-1].pause:
        words[-1] = replace(words[-1], pause="-")


def _is_shouting(text: str) -> bool:
    """Whether most words are in capitals, so that capitals do not mean an acronym."""
    words = re.findall(r"[A-Za-z]{2,}", text)
    return len(words) >= 3 and sum(word.isupper() for word in words) > len(words) / 2


# ---- Stage directions and the names of speakers ------------------------------------------------------------------

_SQUARE = re.compile(r"\[([^\[\]\n]{1,200})\]")
_ROUND = re.compile(r"\(([^()\n]{1,60})\)|\*([^*\n]{1,60})\*")
_NAME = re.compile(r"^[ \t]*([A-Z][A-Za-z.' -]{0,30}?)([ \t]*):(?=[ \t]+\S)", re.MULTILINE)
_MOST_WORDS = 4
_MODIFIERS = ("very", "more", "quite", "still", "a", "long", "half")


def _without_directions(text: str) -> tuple[str, tuple[Note, ...]]:
    """A text of the same length with blanks for what is not said.

    Returns
    -------
    str
    tuple of Note
        One for directions and one for names, where there are any.

    Examples
    --------
    >>> text, notes = _without_directions("ANNA: (sighs) Well. [door slams]")
    >>> text.strip()
    'Well.'
    >>> [note.message for note in notes]
    ['not spoken, taken as the name of a speaker: ANNA', 'not spoken, taken as stage directions: door slams, sighs']
    """
    found: list[str] = []
    names: list[str] = []

    def hidden(match: re.Match[str]) -> str:
        found.append(next(part for part in match.groups() if part is not None).strip())
        return " " * len(match[0])

    def hidden_if_heard(match: re.Match[str]) -> str:
        inside = next(part for part in match.groups() if part is not None)
        return hidden(match) if _is_direction(inside) else match[0]

    def hidden_name(match: re.Match[str]) -> str:
        if match[1] not in speakers or not _may_be_name(match):
            return match[0]
        names.append(match[1])
        return " " * len(match[0])

    text = _ROUND.sub(hidden_if_heard, _SQUARE.sub(hidden, text))
    speakers = _speakers(text)
    text = _NAME.sub(hidden_name, text)
    notes = []
    for what, said in (("the name of a speaker", names), ("stage directions", found)):
        if said:
            notes.append(Note("note", f"not spoken, taken as {what}: {', '.join(dict.fromkeys(said))}"))
    return text, tuple(notes)


def _is_direction(words: str) -> bool:
    """Whether a few words tell how somebody speaks, or what is heard: they begin with a word for that."""
    said = re.findall(r"[a-z']+", words.lower())
    if said and said[0] in _MODIFIERS:
        said = said[1:]
    return 0 < len(said) <= _MOST_WORDS and said[0] in _direction_words()


@cache
def _direction_words() -> frozenset[str]:
    return frozenset(english_table()["stage_directions"]["words"].split())


def _may_be_name(match: re.Match[str]) -> bool:
    """Whether the colon follows at once; a direction may stand between ("BOB (quietly): No.") after capitals only."""
    return not match[2] or match[1].isupper()


def _speakers(text: str) -> set[str]:
    """Names at the start of lines: in capitals, or of lines of which several begin with a name."""
    at_start = [match[1] for match in _NAME.finditer(text) if _may_be_name(match)]
    never = set(english_table()["stage_directions"]["not_names"].split())
    names = [name for name in at_start if name.lower() not in never and len(name.split()) <= 3]
    several = sum(Counter(names).values()) >= 2
    return {name for name in names if (name.isupper() and len(name) > 1) or several}
