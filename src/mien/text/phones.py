"""The 39 ARPAbet phones and their classes, read from ``assets/phones/arpabet.toml``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from mien.core.assets import asset_table

__all__ = ["Phone", "is_vowel", "phone_table"]


@dataclass(frozen=True)
class Phone:
    """One phone of English.

    Attributes
    ----------
    symbol : str
        ARPAbet without stress, such as ``"AA"``.
    manner : str
        vowel, diphthong, stop, affricate, fricative, nasal, liquid or glide.
    voiced : bool
        Whether the vocal folds swing in it.
    """

    symbol: str
    manner: str
    voiced: bool


@cache
def phone_table() -> dict[str, Phone]:
    """All phones by symbol.

    Examples
    --------
    >>> len(phone_table()), phone_table()["NG"].manner
    (39, 'nasal')
    """
    table = asset_table("phones/arpabet.toml")
    return {
        symbol: Phone(symbol, manner, voicing == "voiced")
        for manner, groups in table.items()
        for voicing, symbols in groups.items()
        for symbol in symbols
    }


def is_vowel(symbol: str) -> bool:
    """Whether a phone is a vowel or a diphthong; False for a pause.

    Examples
    --------
    >>> is_vowel("AY"), is_vowel("M"), is_vowel("SIL")
    (True, False, False)
    """
    phone = phone_table().get(symbol)
    return phone is not None and phone.manner in ("vowel", "diphthong")
