"""Numbers as English says them.

Written here rather than taken from a library, for reasons measured in November 2026: `inflect` takes 1.1 s to
import, `num2words` is LGPL and pulls in a package without wheels, and `wetext` weighs 45 MB installed, re-orders
dates ("March 5" becomes "the fifth of march", which the recording does not say) and stops with an assertion on
ordinary text such as ``5'10"``.
"""

from __future__ import annotations

from typing import Any

from mien.core.assets import asset_table

__all__ = ["cardinal", "decimal", "digits", "english_table", "fraction", "ordinal", "plural", "year"]


def english_table() -> dict[str, Any]:
    """The table ``assets/text/english.toml``."""
    return asset_table("text/english.toml")


_MOST_DIGITS = 18
"""Digits of a number that is said as one; longer ones are read digit by digit."""


def cardinal(number: int) -> str:
    """A whole number in words; above 10**18 digit by digit.

    Examples
    --------
    >>> cardinal(1234), cardinal(-20), cardinal(1000001)
    ('one thousand two hundred thirty four', 'minus twenty', 'one million one')
    """
    table = english_table()["numbers"]
    if number < 0:
        return "minus " + cardinal(-number)
    if number < 20:
        return str(table["small"][number])
    if number < 100:
        return str(table["tens"][number // 10]) + (f" {cardinal(number % 10)}" if number % 10 else "")
    if number < 1000:
        return f"{cardinal(number // 100)} hundred" + (f" {cardinal(number % 100)}" if number % 100 else "")
    power = (len(str(number)) - 1) // 3
    if power >= len(table["thousands"]):
        return digits(str(number))
    head, rest = divmod(number, 1000**power)
    return f"{cardinal(head)} {table['thousands'][power]}" + (f" {cardinal(rest)}" if rest else "")


def digits(text: str) -> str:
    """Digits one by one; anything else in the text is passed over.

    Examples
    --------
    >>> digits("555-01")
    'five five five zero one'
    """
    return " ".join(cardinal(int(sign)) for sign in text if sign.isdecimal())


def decimal(text: str) -> str:
    """A number as written, with thousands commas and a decimal point.

    Examples
    --------
    >>> decimal("1,200.05"), decimal(".5")
    ('one thousand two hundred point zero five', 'point five')
    """
    whole, point, part = text.replace(",", "").partition(".")
    spoken = digits(whole) if len(whole) > _MOST_DIGITS else cardinal(int(whole)) if whole else ""
    return f"{spoken} point {digits(part)}".strip() if point else spoken


def ordinal(number: int) -> str:
    """A place in a row.

    Examples
    --------
    >>> ordinal(21), ordinal(40), ordinal(112)
    ('twenty first', 'fortieth', 'one hundred twelfth')
    """
    head, _, last = cardinal(number).rpartition(" ")
    irregular = english_table()["ordinals"]
    if last in irregular:
        last = irregular[last]
    else:
        last = (last[:-1] + "ie" if last.endswith("y") else last) + "th"
    return f"{head} {last}".strip()


def year(number: int) -> str:
    """A year of four figures, in the usual pairs.

    Examples
    --------
    >>> year(1984), year(1905), year(2005), year(2024), year(1900)
    ('nineteen eighty four', 'nineteen oh five', 'two thousand five', 'twenty twenty four', 'nineteen hundred')
    """
    century, rest = divmod(number, 100)
    if century % 10 == 0 and rest < 10:
        return cardinal(number)
    if rest == 0:
        return cardinal(century) + " hundred"
    return f"{cardinal(century)} {'oh ' if rest < 10 else ''}{cardinal(rest)}"


def fraction(top: int, bottom: int) -> str:
    """A common fraction.

    Examples
    --------
    >>> fraction(1, 2), fraction(3, 4), fraction(2, 3), fraction(7, 100)
    ('one half', 'three quarters', 'two thirds', 'seven over one hundred')
    """
    if not 2 <= bottom <= 20:
        return f"{cardinal(top)} over {cardinal(bottom)}"
    name = {2: "half", 4: "quarter"}.get(bottom) or ordinal(bottom)
    return f"{cardinal(top)} {name if top == 1 else plural(name)}"


def plural(word: str) -> str:
    """The plural of a number word: of a decade, or of a part.

    Examples
    --------
    >>> plural("eighty"), plural("half"), plural("six")
    ('eighties', 'halves', 'sixes')
    """
    if word.endswith("lf"):
        return word[:-1] + "ves"
    if word.endswith("y"):
        return word[:-1] + "ies"
    return word + ("es" if word.endswith("x") else "s")
