"""What a language writes in figures and signs, as regular expressions made from its table (`written_forms`)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from mien.text.languages.language import Language
from mien.text.languages.plain_numbers import Numbers

__all__ = ["WrittenPatterns"]

_BLANK = "[ \u00a0\u202f\u2009]?"
_DAY, _MONTH = r"(?:0?[1-9]|[12]\d|3[01])", r"(?:0?[1-9]|1[0-2])"
_HOUR, _MINUTE = r"(?:[01]?\d|2[0-4])", r"[0-5]\d"
_LETTERS_MOST = 5


class WrittenPatterns:
    """One language's tables, and its patterns: pairs of a name and an expression, the first that fits goes first."""

    def __init__(self, language: Language) -> None:
        table = language.table
        self.table: dict[str, Any] = table.get("written", {})
        self.numbers = Numbers(language)
        self.units, self.money = table.get("units", {}), table.get("currencies", {})
        self.ordinals, self.signs = table.get("ordinals", {}), table.get("signs", {})
        self.counters: dict[str, str] = table.get("counters", {})
        self.pinyin = bool(table.get("pinyin"))
        self.short: dict[str, str] = table.get("abbreviations", {})
        self.words_in_capitals = frozenset(self.table.get("words_in_capitals", "").split())
        self.months = [month.split("|") for month in self.table.get("months", "").split()]
        self.vowels = re.compile(f"[{self.table.get('vowels', 'AEIOUYÄÖÜÅÉÈÊÀÁÍÓÚ')}]")
        # Chinese and Japanese put no blanks about figures
        east = "east" in self.table
        self.start, self.end = (r"(?<![\d.,])", "(?![A-Za-z])") if east else (r"(?<![\w.,])", r"(?!\w)")
        self.minus = r"(?P<{}>(?<![\w\d])[-−](?=\d))?"

    def patterns(self) -> Iterator[tuple[str, str]]:
        """All of them, in the order in which they are tried."""
        yield from self._telephones()
        yield from self._dates()
        yield from self._clocks()
        yield from self._amounts()
        yield from self._counted_and_ranked()
        yield from self._numbers()
        yield from self._letters_and_signs()

    def _telephones(self) -> Iterator[tuple[str, str]]:
        """Short forms of several words, before anything takes a part of them; telephone numbers."""
        table = self.table
        spaced = "|".join(re.escape(name) for name in self.short if " " in name)
        if spaced:
            yield "short", rf"(?i:(?<!\w)(?:{spaced}))"
        if table.get("phone") == "pairs":
            yield "pairs", r"(?<![\w.,:])(?:\+\d\d[ .-]?(?:\(0\))?[1-9]|0[1-9])(?:[ .-]?\d\d){4}(?![\w.,]?\d)"
        yield (
            "phone",
            r"\+\d[\d /()-]{6,20}\d"
            r"|(?<![\w.,:])(?!\d\d(?P<pp>[/-])\d\d(?P=pp)\d\d)0\d{1,5}(?:[ /-]\d{2,10}){1,5}(?![\w.,:])",
        )

    def _dates(self) -> Iterator[tuple[str, str]]:
        table = self.table
        if "date" not in table:
            return
        yield "iso", rf"(?<!\d)(?P<iy>\d{{4}})(?P<is>[-/])(?P<im>{_MONTH})(?P=is)(?P<id>{_DAY})(?!\d)"
        if table.get("day_first", True):
            yield (
                "date",
                (
                    rf"(?<![\d.,/-])(?P<dd>{_DAY})(?P<ds>[./-]){_BLANK}(?P<dm>{_MONTH})(?P=ds){_BLANK}"
                    r"(?P<dy>\d{4}|\d\d)(?![\d/-]|[.,]\d)"
                ),
            )
        if "east" in table:
            years, months, days = table["east"].split()
            yield "east", rf"(?:(?P<ey>\d{{4}})(?:{years}))?(?P<em>{_MONTH})(?:{months})(?:(?P<ed>{_DAY})(?:{days}))?"
        if table.get("dots"):
            yield "dotted", rf"(?<![\d.,])(?P<pd>{_DAY})\.{_BLANK}(?P<pm>{_MONTH})\.(?!\d)"
        names = "|".join(re.escape(form) for forms in self.months for form in forms)
        if names:
            yield (
                "named",
                (
                    rf"(?<![\d.,:])(?P<nd>{_DAY})(?:\.|er\b|º|°|:e|-?е|-?го)?{_BLANK}"
                    rf"(?P<no>(?i:(?:de |di |d')?(?:{names}))\b)"
                    + (r"(?P<ny>,? \d{4}(?!\d))?" if "named" in table else "(?P<ny>(?!))?")
                ),
            )

    def _clocks(self) -> Iterator[tuple[str, str]]:
        """Times: with a colon; with a stop between words of the clock; with a letter (15h30); hours alone."""
        if "clock" not in self.table:
            return
        after = self.table.get("clock_after", "")
        tail = rf"(?:{_BLANK}(?:{after})(?!\w))" if after else "(?!)"
        yield "colon", rf"(?<![\d:.,])(?P<ch>{_HOUR}):(?P<cm>{_MINUTE})(?::(?P<cs>{_MINUTE}))?(?![\d:]|[.,]\d){tail}?"
        if "clock_before" in self.table:
            before = (
                "|".join(f"(?<={word})" for word in self.table["clock_before"].split("|") if word) or r"(?<![\d.,])"
            )
            yield (
                "stop",
                (
                    rf"(?:{before})(?P<sh>{_HOUR})\.(?P<sm>{_MINUTE})(?![\d.]\d|\d){tail}?"
                    rf"|(?<![\d.,])(?P<th>{_HOUR})\.(?P<tm>{_MINUTE}){tail}"
                ),
            )
        if "clock_letter" in self.table:
            letter, ends = self.table["clock_letter"], self.table.get("clock_minute", "min")
            before, edge = (r"(?<![\d.,])", "") if "east" in self.table else (r"(?<![\w.,])", r"(?![\w/])")
            yield (
                "letter",
                rf"{before}(?P<lh>{_HOUR}){_BLANK}(?:{letter})(?:{_BLANK}(?P<lm>{_MINUTE})(?:{_BLANK}(?:{ends}))?)?{edge}",
            )
        if after:
            yield "whole", rf"(?<![\w.,])(?P<wh>{_HOUR}){tail}"

    def _amounts(self) -> Iterator[tuple[str, str]]:
        """Money, units, fractions that are one sign."""
        number, start, end = self.numbers.pattern, self.start, self.end
        money = "|".join(re.escape(sign) for sign in sorted(self.money, key=len, reverse=True))
        if money:
            before = money + "".join(f"|{sign}" for sign in self.table.get("unit_before", ""))
            yield "before", rf"(?P<bs>{before}){_BLANK}(?P<bn>{number}){end}"
            yield "after", rf"{start}(?P<an>{number}){_BLANK}(?P<as>{money}){end}"
        units = "|".join(re.escape(sign) for sign in sorted(self.units, key=len, reverse=True))
        if units:
            yield "unit", rf"(?:{start}|(?<=[-−])){self.minus.format('um')}(?P<un>{number}){_BLANK}(?P<us>{units}){end}"
        fractions = "|".join(sign for sign in self.signs if "/" in sign)
        if fractions:
            yield "fraction", rf"(?<![\w/.,])(?:{fractions})(?![\w/]|[.,]\d)"

    def _counted_and_ranked(self) -> Iterator[tuple[str, str]]:
        """A number with a counter; kings and other ordinals."""
        table, start = self.table, self.start
        if self.counters:  # not a fraction: 3分の1
            longest = sorted(self.counters, key=len, reverse=True)
            named = "|".join(sign for sign in longest if sign[0].isdigit())
            signs = "|".join(sign for sign in longest if not sign[0].isdigit())
            yield (
                "counter",
                rf"{start}(?:(?P<ci>{named})|(?P<cn>\d{{1,4}})(?P<cw>{signs}))(?P<ck>{table['stretch'].split()[0]})?(?!の\d)",
            )
        if "ranked_after" in table:
            before = "|".join(rf"(?<=\b{word} )" for word in table["ranked_after"])
            yield "ranked", rf"(?i:{before})(?P<rn>\d{{1,3}})\.(?=[ \u00a0]{table['ranked_noun']})"
        for place, suffix in enumerate(self.ordinals):
            yield f"ordinal{place}", rf"{start}(?P<o{place}>\d{{1,4}})(?:{suffix})"

    def _numbers(self) -> Iterator[tuple[str, str]]:
        """Years, ranges, all other numbers."""
        table, number = self.table, self.numbers.pattern
        if "year" in table:
            yield "year", r"(?<![\w.,:/-])(?:1[1-9]|20)\d\d(?![\w:/]|[.,]\d|[-–]\d)"
        if "range" in table:
            yield "range", rf"(?<![\w.,-])(?P<low>{number}){_BLANK}[-–]{_BLANK}(?=(?P<high>{number})(?![-–\w]))"
        tone = "(?<![a-zü])" if self.pinyin else ""  # hao3
        yield "number", rf"{tone}{self.minus.format('nm')}(?P<nn>{number})"

    def _letters_and_signs(self) -> Iterator[tuple[str, str]]:
        """Roman numbers, words of capitals, signs."""
        table = self.table
        if "roman" in table:
            suffix, stop = table.get("roman_suffix", "(?!)"), r"\.?" if table.get("dots") else ""
            yield "century", rf"(?<!\w)(?P<xc>[IVX]{{1,6}})(?:{suffix})(?!\w)"
            yield "roman", rf"(?<![\w.])(?P<xr>[IVX]{{2,6}}){stop}(?!\w)"
        if table.get("capitals", True):
            yield "capitals", rf"(?<![\w'’])[^\W\d_a-zß-öø-ÿ]{{2,{_LETTERS_MOST}}}(?![\w'’])"
        signs = "".join(re.escape(sign) for sign in self.signs if len(sign) == 1)
        if signs:
            yield "sign", f"[{signs}]"
