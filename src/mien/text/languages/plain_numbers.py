"""Numbers in words in many languages, by the rules of the Unicode CLDR, with the units that follow them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from unicode_rbnf import RbnfEngine

from mien.core.errors import unknown_name
from mien.text.languages.language import Language

__all__ = ["Numbers"]

_FIELD = re.compile(r"\{(?P<name>\w+)(?:(?P<how>[:#])(?P<what>[^{}]+))?\}")
_SOFT_HYPHEN = "\u00ad"
_MOST_DIGITS = 15  # longer ones digit by digit


class Numbers:
    """How one language says numbers.

    Attributes
    ----------
    pattern : str
        What a number without a sign looks like, with its marks between thousands and before decimals.
    """

    def __init__(self, language: Language) -> None:
        table = language.table
        self._table: dict[str, Any] = table.get("written", {})
        self._nouns: dict[str, str] = table.get("units", {}) | table.get("currencies", {})
        self._tag, self._engine = language.tag, _engine(language.tag)
        self._point = self._table.get("decimal", ",")
        group = "[.'’ \u00a0\u202f\u2009]" if self._point == "," else "[,'’ \u00a0\u202f\u2009]"
        self.pattern = rf"(?:\d{{1,3}}(?:{group}\d{{3}})+(?!\d)(?:{re.escape(self._point)}\d+)?|\d+(?:[.,]\d+)?)"
        self._grouped = re.compile(rf"\d{{1,3}}(?:{group}\d{{3}})+(?!\d)")

    def _parts(self, written: str) -> tuple[str, str]:
        """The digits before and after the decimal sign."""
        whole = self._grouped.match(written)
        rest = written[whole.end() :] if whole else ""
        if whole:
            return re.sub(r"\D", "", whole.group()), rest[1:]
        head, _, tail = re.sub("[.,]", ".", written).partition(".")
        return head, tail

    def value(self, written: str) -> float:
        """What a number amounts to."""
        head, tail = self._parts(written)
        return float(f"{head}.{tail or 0}")

    def spelled(self, number: int, rule: str = "numbering") -> str:
        """A whole number by a list of the table, or by a set of rules; as digits where CLDR lacks the language."""
        names = self._table.get(rule)
        if isinstance(names, list):
            return str(names[number]) if number < len(names) else self.spelled(number)
        if rule == "digits":
            return self.digits(str(number)).replace(" ", "" if not self._table.get("blank", True) else " ")
        if "thousands" in self._table:
            return _in_kana(number, self._table)
        if self._engine is None:
            return str(number)
        known = f"spellout-{rule}"
        if known not in self._engine.rulesets:
            rules = [name[9:] for name in self._engine.rulesets if name.startswith("spellout-")]
            raise unknown_name(f"rule for numbers in the table of {self._tag}", rule, rules)
        said = self._engine.format_number(number, ruleset_names=[known]).text
        for wrong, right in (self._table.get("respelled", {}) | {_SOFT_HYPHEN: ""}).items():
            said = said.replace(wrong, right)
        return said

    def digits(self, written: str) -> str:
        """Digits one by one; anything else is passed over."""
        return " ".join(self.spelled(int(sign)) for sign in written if sign.isdecimal())

    def plain(self, written: str, rule: str | None = None) -> str:
        """A number as written: whole, with decimals, or digit by digit where it begins with 0 or is very long."""
        head, tail = self._parts(written)
        if len(head) > _MOST_DIGITS or (len(head) > 1 and head[0] == "0"):
            said = self.digits(head)
        else:
            said = self.spelled(int(head), rule or self._table.get("number", "numbering"))
        if not tail:
            return said
        one = self._table.get("decimals") == "number" and len(tail) <= 2 and tail[0] != "0"
        return f"{said} {self._table.get('point', self._point)} {self.spelled(int(tail)) if one else self.digits(tail)}"

    def counted(self, written: str, sign: str) -> str:
        """A number and the noun of a unit or a currency, in the form that goes with it.

        Examples
        --------
        >>> from mien.text.languages import find_language
        >>> [Numbers(find_language("ru")).counted(n, "km") for n in ("1", "3", "5", "2,5")]
        ['один километр', 'три километра', 'пять километров', 'два запятая пять километра']
        """
        head, tail = self._parts(written)
        noun = self._nouns[sign].split("|")
        rule = next(
            (
                f"cardinal-{kind}"
                for kind in ("feminine", "neuter", "masculine")
                if sign in self._table.get(kind, "").split()
            ),
            self._table.get("counted", self._table.get("number", "numbering")),
        )
        number = self.plain(written, rule)
        form = noun[min(_form(self._table.get("plural", "one"), int(head[-15:]), bool(tail)), len(noun) - 1)]
        if "{}" in form:
            return form.replace("{}", number)
        return f"{number} {form}" if self._table.get("blank", True) else f"{number}{form}"

    def amount(self, written: str, sign: str) -> str:
        """A sum of money; two decimals are its hundredths."""
        head, tail = self._parts(written)
        if len(tail) != 2 or "cents" not in self._table:
            return self.counted(written, sign)
        whole = self.counted(head, sign)
        return self.fill(self._table["cents"].replace("{whole}", whole), c=int(tail)) if int(tail) else whole

    def fill(self, template: str, **numbers: int) -> str:
        """A template with its numbers in words: ``{h:RULE}``, ``{h#SIGN}``, ``{h0:RULE}`` with a zero before nine."""

        def said(field: re.Match[str]) -> str:
            name = field["name"]
            padded = name not in numbers and name.endswith("0")
            number = numbers[name[:-1] if padded else name]
            if field["how"] == "#":
                return self.counted(str(number), field["what"])
            zero = self.spelled(0) + " " if padded and number < 10 else ""
            return zero + self.spelled(number, field["what"] or "numbering")

        return _FIELD.sub(said, template)


def _form(plural: str, number: int, broken: bool) -> int:
    """Which of a noun's forms goes with a number: one, few, many, with decimals (CLDR's plural rules)."""
    if plural == "two":  # French: nought and one and what is between them and two
        return int(number >= 2)
    if plural in ("cs", "pl", "ru"):
        if broken:
            return 3
        last, teen = number % 10, 10 < number % 100 < 20
        if number == 1 or (plural == "ru" and last == 1 and not teen):
            return 0
        few = 2 <= number <= 4 if plural == "cs" else 2 <= last <= 4 and not teen
        return 1 if few else 2
    return int(number != 1 or broken)


def _in_kana(number: int, table: Mapping[str, Any]) -> str:
    """A whole number as Japanese says it."""
    if number == 0:
        return str(table["figures"][0])
    said, powers = "", ("", "まん", "おく", "ちょう")
    for power in powers:
        number, group = divmod(number, 10_000)
        thousands, hundreds, tens, one = (group // 10**n % 10 for n in (3, 2, 1, 0))
        ten = "" if not tens else "じゅう" if tens == 1 else table["figures"][tens] + "じゅう"
        words = (
            table["thousands"][thousands] + table["hundreds"][hundreds] + ten + (table["figures"][one] if one else "")
        )
        said = (words + power if words else "") + said
    return said


@cache
def _engine(tag: str) -> RbnfEngine | None:
    try:
        return RbnfEngine.for_language(tag)
    except ValueError:
        return None
