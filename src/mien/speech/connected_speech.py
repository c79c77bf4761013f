"""How English changes in connected speech: what may be heard in place of what the dictionary has for each word alone.

Coalescence (*had you* with /jh/), one of two like consonants (*this sentence*), final /t d/ left out between consonants
(*last year*), /dh/ after another sound of the tongue tip (*in this*), weak forms of small words (*'er*, *an'*), the tap
of *data*, the ending of *goin'*; all optional: Cruttenden 2014, "Gimson's Pronunciation of English", chapters 9 to 12.
The lists are hand-made.
"""

from __future__ import annotations

from mien.text.phones import is_vowel
from mien.text.pronunciation import Pronunciation, pronunciations

__all__ = ["heard_pronunciations", "leaves_out", "loses_its_first", "together"]

_COALESCED = {
    ("D", "Y"): "JH", ("T", "Y"): "CH", ("S", "Y"): "SH", ("Z", "Y"): "ZH", ("S", "SH"): "SH", ("Z", "SH"): "SH",
}  # fmt: skip
_TIP = ("N", "L", "T", "D", "S", "Z")
_WEAK: dict[str, tuple[str, ...]] = {
    "he": ("IY",), "him": ("IH M", "AH M"), "his": ("IH Z",), "her": ("ER",), "had": ("AE D", "AH D", "HH AH D"),
    "has": ("AE Z", "AH Z", "HH AH Z"), "have": ("AE V", "AH V", "HH AH V"), "and": ("AH N", "EH N"),
    "you": ("Y AH",), "your": ("Y ER",), "are": ("ER",), "or": ("ER",), "for": ("F ER",), "of": ("AH",),
    "them": ("AH M",), "can": ("K AH N",), "at": ("AH T",), "as": ("AH Z",), "to": ("T AH",), "from": ("F R AH M",),
    "was": ("W AH Z",), "that": ("DH AH T",), "than": ("DH AH N",), "some": ("S AH M",), "must": ("M AH S",),
}  # fmt: skip


def heard_pronunciations(word: str) -> tuple[Pronunciation, ...]:
    """Pronunciations of a word that a speaker may have used: those of the dictionary, then its weak forms.

    Examples
    --------
    >>> heard_pronunciations("he")
    (('HH', 'IY'), ('IY',))
    """
    listed = pronunciations(word)
    weak = [tuple(phones.split()) for phones in _WEAK.get(word.lower(), ())]
    return tuple(dict.fromkeys((*listed, *weak, *map(_tapped, listed), *map(_clipped, listed))))


def _tapped(phones: Pronunciation) -> Pronunciation:
    """With each /t/ between vowels, the first of them perhaps followed by /r/, as a tap."""
    inside = [
        phone == "T" and 0 < place < len(phones) - 1 and _opens(phones[place - 1]) and is_vowel(phones[place + 1])
        for place, phone in enumerate(phones)
    ]
    return tuple("D" if tap else phone for tap, phone in zip(inside, phones, strict=True))


def _opens(phone: str) -> bool:
    return phone == "R" or is_vowel(phone)


def _clipped(phones: Pronunciation) -> Pronunciation:
    """With *-in'* for *-ing* where it is an ending."""
    return (*phones[:-1], "N") if len(phones) > 3 and phones[-2:] == ("IH", "NG") else phones


def together(last: str, following: str) -> str | None:
    """What the last phone of a word and the first of the next may become together.

    Examples
    --------
    >>> together("D", "Y"), together("S", "S"), together("N", "Y")
    ('JH', 'S', None)
    """
    return last if last == following and not is_vowel(last) else _COALESCED.get((last, following))


def loses_its_first(last: str, following: str) -> bool:
    """Whether the first phone of a word may be left out: /dh/ after another sound of the tongue tip."""
    return following == "DH" and last in _TIP


def leaves_out(before: str, last: str, following: str) -> bool:
    """Whether the last phone of a word may be left out: /t d/ between consonants.

    Examples
    --------
    >>> leaves_out("S", "T", "Y"), leaves_out("IY", "T", "Y")
    (True, False)
    """
    return last in ("T", "D") and not is_vowel(before) and not is_vowel(following)
