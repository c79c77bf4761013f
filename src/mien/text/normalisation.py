"""Written English to spoken words: numbers, dates, money, abbreviations, acronyms, signs.

`spoken_words` reads a text from left to right. At each place the first pattern of `mien.text.text_patterns` that
fits says what is spoken there, so the most special come first (an address on the net before a plain word). What the
signs and abbreviations stand for is data: ``assets/text/english.toml``.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

from mien.core.errors import InputError, Note
from mien.text.heteronyms import with_heteronyms
from mien.text.spoken_numbers import english_table
from mien.text.text_patterns import READERS, TEXT_PATTERN

__all__ = ["SpokenText", "SpokenWord", "spoken_words"]


@dataclass(frozen=True)
class SpokenWord:
    """One word to be said.

    Attributes
    ----------
    text : str
        Lower case: letters and apostrophes. A letter said by its name carries a full stop: ``"b."``.
    start, end : int
        The characters of the written text that it stands for, ``written[start:end]``. Words of one number share them.
    pause : str
        The punctuation that follows, ``""`` if none: the strongest of ``. ? ! : ; , -``, where ``"-"`` is a dash.
    phones : tuple of str or None
        How it is to be pronounced, where that was asked for; ARPAbet.
    """

    text: str
    start: int
    end: int
    pause: str = ""
    phones: tuple[str, ...] | None = None


@dataclass(frozen=True)
class SpokenText:
    """A written text and the words that are said for it, in order; at least one."""

    written: str
    words: tuple[SpokenWord, ...]
    notes: tuple[Note, ...] = ()

    @property
    def spoken(self) -> str:
        """The spoken words, parted by blanks."""
        return " ".join(word.text for word in self.words)

    def written_for(self, first: int, last: int) -> str:
        """The written text of words ``first`` to ``last``, both included."""
        return self.written[self.words[first].start : self.words[last].end]


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
    clean, dropped = _clean(text)
    words = _scan(clean)
    if not words:
        raise InputError(f"nothing in the text {_shorten(text)!r} can be spoken: give at least one word or number")
    notes: tuple[Note, ...] = ()
    if dropped:
        notes = (Note("note", f"left out of the spoken text: {' '.join(dict.fromkeys(dropped))}"),)
    return SpokenText(text, with_heteronyms(words), notes)


# ---- Letters and signs -------------------------------------------------------------------------------------------

_SAME_LENGTH = str.maketrans(
    {"‘": "'", "’": "'", "ʼ": "'", "´": "'", "`": "'", "“": '"', "”": '"', "„": '"', "«": '"', "»": '"'}
    | {"‐": "-", "‑": "-", "−": "-", "–": "—", "―": "—", "…": ".", "\u00a0": " ", "\u2009": " ", "\u202f": " "}
)


def _clean(text: str) -> tuple[str, list[str]]:
    """A text of the same length in plain letters, known signs and blanks; and what was dropped from it."""
    folded, signs = english_table()["folded_letters"], english_table()["signs"]
    out, dropped = [], []
    for place, char in enumerate(text.translate(_SAME_LENGTH)):
        category = unicodedata.category(char)
        if char.isascii() or char in signs or char in "—¡¿‰" or char in folded:
            out.append(char if category[0] != "C" else " ")
        elif category[0] in "LN" and unicodedata.name(char, "").startswith("FULLWIDTH"):
            out.append(unicodedata.normalize("NFKC", char))
        elif category[0] == "L" and _is_latin(char):
            out.append(char)
        elif category[0] == "L" or category in ("Nd", "Nl") or (category == "Mc"):
            raise _wrong_script(text, place)
        else:
            out.append(" " if category != "Mn" else "\u0301")
            if category[0] == "S":
                dropped.append(char)
    return "".join(out), dropped


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


def _scan(text: str) -> list[SpokenWord]:
    words: list[SpokenWord] = []
    shouting = _is_shouting(text)
    place = 0
    while place < len(text):
        match = TEXT_PATTERN.match(text, place)
        if match is None or match.end() == place:
            if text[place] != "-" or text[place - 1 : place + 2].strip() == "-":
                _note_pause(words, text[place])
            place += 1
            continue
        name = match.lastgroup or ""
        for start, end, spoken in READERS[name](match, text, shouting):
            words += [SpokenWord(word, start, end) for word in spoken.split()]
        place = match.end()
        if name == "abbreviation" and not text[place:].strip(" \"')]"):
            _note_pause(words, ".")
    return words


def _note_pause(words: list[SpokenWord], char: str) -> None:
    char = {"—": "-", "(": ",", ")": ",", "\n": ";"}.get(char, char)
    if words and char in _PAUSE_RANK and char != "-":
        if not words[-1].pause or _PAUSE_RANK.index(char) > _PAUSE_RANK.index(words[-1].pause):
            words[-1] = replace(words[-1], pause=char)
    elif words and char == "-" and not words[-1].pause:
        words[-1] = replace(words[-1], pause="-")


def _is_shouting(text: str) -> bool:
    """Whether most words are in capitals, so that capitals do not mean an acronym."""
    words = re.findall(r"[A-Za-z]{2,}", text)
    return len(words) >= 3 and sum(word.isupper() for word in words) > len(words) / 2
