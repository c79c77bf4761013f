"""How English words change where they meet: what may be heard in place of what the dictionary has for each alone.

Coalescence (*had you* with /jh/), final /t d/ left out between consonants (*last year*), and the weak forms of small
words (*'e*, *'er*, *an'*), all optional: Cruttenden 2014, "Gimson's Pronunciation of English", chapters 11 and 12. The
lists are hand-made.
"""

from __future__ import annotations

from mien.text.phones import is_vowel
from mien.text.pronunciation import Pronunciation, pronunciations

__all__ = ["COALESCED", "heard_pronunciations", "leaves_out"]

COALESCED = {("D", "Y"): "JH", ("T", "Y"): "CH", ("S", "Y"): "SH", ("Z", "Y"): "ZH"}
"""What the last phone of a word and the first of the next become together."""
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
    weak = tuple(tuple(phones.split()) for phones in _WEAK.get(word.lower(), ()))
    return tuple(dict.fromkeys((*pronunciations(word), *weak)))


def leaves_out(before: str, last: str, following: str) -> bool:
    """Whether the last phone of a word may be left out: /t d/ between consonants.

    Examples
    --------
    >>> leaves_out("S", "T", "Y"), leaves_out("IY", "T", "Y")
    (True, False)
    """
    return last in ("T", "D") and not is_vowel(before) and not is_vowel(following)
