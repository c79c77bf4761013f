"""Phones as SSML's ``phoneme`` gives them, in IPA or in ARPAbet, brought to the ARPAbet of `mien.speech`."""

from __future__ import annotations

import re
import unicodedata
from functools import cache

from mien.core.assets import asset_table
from mien.core.errors import InputError, unknown_name

__all__ = ["phones_of"]

_ARPABET = ("x-arpabet", "arpabet", "x-cmu", "cmu")
_IPA = ("ipa",)


def _bare(text: str) -> str:
    """IPA without stress, length, ties, and other marks on or between signs."""
    kept = (char for char in unicodedata.normalize("NFC", text) if unicodedata.category(char) not in ("Mn", "Lm", "Sk"))
    return "".join(char for char in kept if char not in " .|‖·'-ː")


@cache
def _ipa() -> dict[str, tuple[str, ...]]:
    """IPA signs, longest first, with ties and marks left out."""
    found = {_bare(sign): tuple(phones) for sign, phones in asset_table("phones/ipa_to_arpabet.toml")["phones"].items()}
    found |= {"eɪ": ("EY",), "oʊ": ("OW",), "əʊ": ("OW",), "aɪ": ("AY",), "aʊ": ("AW",), "ɔɪ": ("OY",)}
    found |= {
        "tʃ": ("CH",),
        "dʒ": ("JH",),
        "ʧ": ("CH",),
        "ʤ": ("JH",),
        "ɝ": ("ER",),
        "ɚ": ("ER",),
        "ɜː": ("ER",),
        "ɜ": ("ER",),
    }
    found |= {"g": ("G",), "ɡ": ("G",), "ɹ": ("R",), "r": ("R",), "ɾ": ("D",), "ei": ("EY",), "ou": ("OW",)}
    return dict(sorted(found.items(), key=lambda entry: -len(entry[0])))


@cache
def _symbols() -> frozenset[str]:
    table = asset_table("phones/arpabet.toml")
    return frozenset(symbol for groups in table.values() for symbols in groups.values() for symbol in symbols)


def phones_of(text: str, alphabet: str) -> tuple[str, ...]:
    """ARPAbet phones without stress.

    Raises
    ------
    InputError
        If the alphabet or a sign is not known.

    Examples
    --------
    >>> phones_of("T AH0 M EY1 T OW0", "x-arpabet")
    ('T', 'AH', 'M', 'EY', 'T', 'OW')
    >>> phones_of("təˈmeɪtoʊ", "ipa")
    ('T', 'AH', 'M', 'EY', 'T', 'OW')
    """
    name = alphabet.strip().lower()
    if name in _ARPABET:
        phones = tuple(re.sub(r"\d", "", phone).upper() for phone in text.split())
        for phone in phones:
            if phone not in _symbols():
                raise unknown_name("ARPAbet phone", phone, _symbols())
        return phones
    if name not in _IPA:
        raise unknown_name("alphabet of phonemes", alphabet, (*_IPA, *_ARPABET))
    rest, phones = _bare(text), ()
    while rest:
        sign = next((sign for sign in _ipa() if sign and rest.startswith(sign)), None)
        if sign is None:
            raise InputError(f"the IPA sign {rest[0]!r} (U+{ord(rest[0]):04X}) in {text!r} has no English phone")
        phones += _ipa()[sign]
        rest = rest[len(sign) :]
    return phones
