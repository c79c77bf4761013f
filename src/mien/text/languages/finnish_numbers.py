"""Numbers as Finnish says them, in the nominative; the words stand in ``assets/languages/fi.toml``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["cardinal", "decimal", "ordinal"]


def cardinal(number: int, table: Mapping[str, Any]) -> str:
    """A whole number in words; above the last power digit by digit.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> table = find_language("fi").table["numbers"]
    >>> [cardinal(number, table) for number in (0, 12, 21, 100, 365, 1995, 2001)]
    ... # doctest: +NORMALIZE_WHITESPACE
    ['nolla', 'kaksitoista', 'kaksikymmentäyksi', 'sata', 'kolmesataakuusikymmentäviisi',
     'tuhat yhdeksänsataayhdeksänkymmentäviisi', 'kaksituhatta yksi']
    """
    if number < 0:
        return f"{table['minus']} {cardinal(-number, table)}"
    if number == 0:
        return str(table["small"][0])
    groups: list[str] = []
    rest, powers = number, 0
    while rest:
        rest, group = divmod(rest, 1000)
        if powers > len(table["powers"]):
            return " ".join(table["small"][int(digit)] for digit in str(number))
        if group:
            groups.insert(0, _with_power(group, powers, table))
        powers += 1
    return " ".join(groups)


def _with_power(group: int, power: int, table: Mapping[str, Any]) -> str:
    if power == 0:
        return _hundreds(group, table)
    one, many = table["powers"][power - 1]
    if group == 1:
        return str(one)
    return _hundreds(group, table) + ("" if power == 1 else " ") + str(many)


def _hundreds(number: int, table: Mapping[str, Any]) -> str:
    """1 to 999."""
    hundreds, rest = divmod(number, 100)
    one, many = table["hundred"]
    said = "" if not hundreds else one if hundreds == 1 else table["small"][hundreds] + many
    return str(said + (_tens(rest, table) if rest else ""))


def _tens(number: int, table: Mapping[str, Any]) -> str:
    if number <= 10:
        return str(table["small"][number])
    if number < 20:
        return str(table["small"][number - 10] + table["teen"])
    tens, rest = divmod(number, 10)
    return str(table["small"][tens] + table["tens"] + (table["small"][rest] if rest else ""))


def decimal(written: str, table: Mapping[str, Any]) -> str:
    """A number as written, with a decimal comma.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> decimal("3,05", find_language("fi").table["numbers"])
    'kolme pilkku nolla viisi'
    """
    whole, comma, part = written.partition(",")
    said = cardinal(int(whole), table)
    if comma:
        said += f" {table['comma']} " + " ".join(table["small"][int(digit)] for digit in part)
    return said


def ordinal(number: int, table: Mapping[str, Any]) -> str:
    """A place in a row, such as the day of a month; beyond the table the cardinal.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> ordinal(3, find_language("fi").table["numbers"])
    'kolmas'
    """
    known = table["ordinals"]
    return str(known[number]) if 0 <= number < len(known) else cardinal(number, table)
