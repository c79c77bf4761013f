"""Mandarin in pinyin: marks over vowels become digits after the syllable, as eSpeak NG reads them."""

from __future__ import annotations

import unicodedata

__all__ = ["with_tone_digits"]

_TONES = {"\u0304": "1", "\u0301": "2", "\u030c": "3", "\u0300": "4"}
_TONELESS = "5"
_INITIALS: tuple[str, ...] = ("zh", "ch", "sh", *"bpmfdtnlgkhjqxrzcsyw", "")
_FINALS: tuple[str, ...] = (
    *(
        "iang",
        "iong",
        "uang",
        "ang",
        "eng",
        "ing",
        "ong",
        "iao",
        "ian",
        "uai",
        "uan",
        "van",
        "ai",
        "ei",
        "ao",
        "ou",
        "an",
    ),
    *("en", "er", "ia", "ie", "iu", "in", "ua", "ue", "ui", "un", "uo", "ve", "vn", *"aoeiuv"),
)
_VOWELS = "aoeiuv"


def with_tone_digits(word: str) -> str:
    """A word of pinyin with a digit after each syllable; anything else is left as it is.

    Examples
    --------
    >>> with_tone_digits("nǐ"), with_tone_digits("hǎo"), with_tone_digits("xuéxiào"), with_tone_digits("nǚ'ér")
    ('ni3', 'hao3', 'xue2xiao4', 'nv3er2')
    >>> with_tone_digits("hao3"), with_tone_digits("ma"), with_tone_digits("你好")
    ('hao3', 'ma5', '你好')
    """
    if "'" in word or "’" in word:
        parts = [with_tone_digits(part) for part in word.replace("’", "'").split("'") if part]
        return "".join(parts) if all(part[-1].isdigit() for part in parts) else word
    bare, marks = _without_marks(word)
    if not bare.isascii() or any(char.isdigit() for char in bare) or not bare.isalpha():
        return word
    found, place = [], 0
    while place < len(bare):
        syllable = _longest(bare, place)
        if not syllable:
            return word
        tone = next((marks[k] for k in range(place, place + len(syllable)) if k in marks), _TONELESS)
        found.append(syllable + tone)
        place += len(syllable)
    return "".join(found)


def _without_marks(word: str) -> tuple[str, dict[int, str]]:
    """Small letters without marks, ü as v, and the tone of each letter that carries one."""
    bare, marks = "", dict[int, str]()
    for char in unicodedata.normalize("NFD", word.lower()):
        if char in _TONES:
            marks[len(bare) - 1] = _TONES[char]
        elif char == "\u0308" and bare.endswith("u"):
            bare = bare[:-1] + "v"
        else:
            bare += char
    return bare, marks


def _longest(bare: str, place: int) -> str:
    """The longest syllable from here after which another can begin."""
    rest = bare[place:]
    fitting = [a + b for a in _INITIALS for b in _FINALS if rest.startswith(a + b)]
    for syllable in sorted(fitting, key=len, reverse=True):
        after = rest[len(syllable) :]
        if not after or after[0] not in _VOWELS:
            return syllable
    return max(fitting, key=len) if fitting else ""
