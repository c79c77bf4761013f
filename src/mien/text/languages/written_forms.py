"""What is written in figures and signs, in words: times, dates, ordinals, money, units, ranges, numbers, capitals.

How a language says them stands in its table: ``[written]``, ``[units]``, ``[currencies]``, ``[ordinals]``,
``[counters]``, ``[signs]`` (``docs/languages.md``). Numbers are spelled by the rules of the Unicode CLDR
(`unicode_rbnf`). In a template ``{h:RULE}`` is a number by a set of those rules or by a list of the table,
``{h#SIGN}`` one with a unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

from mien.text.languages.language import Language
from mien.text.languages.plain_numbers import Numbers
from mien.text.languages.tokens import Token, tokens_of

__all__ = ["Form", "spoken_tokens", "written_forms"]

_BLANK = "[ \u00a0\u202f\u2009]?"
_TAIL = re.compile(r"[\"'”“»)\]\s]*\Z")
_ROMAN = re.compile(r"X{0,3}(?:IX|IV|V?I{0,3})")
_VALUES = {"I": 1, "V": 5, "X": 10}
_LETTERS_MOST = 5
_MASKS = "\ue000\ue001"
_MASKED = re.compile(r"\ue000+|\ue001+|[^\s\ue000\ue001–—-][^\s\ue000\ue001]*")


@dataclass(frozen=True)
class Form:
    """Characters ``start`` to ``end`` of a text, the words said for them, and whether they end the sentence."""

    start: int
    end: int
    said: str
    ends: bool = False


def written_forms(text: str, language: Language) -> Iterator[Form]:
    """Every piece of a text that is not read as it is written, in order.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> [form.said for form in written_forms("Um 7:30 Uhr am 3.5.2024: 5,50 €", find_language("de"))]
    ['sieben Uhr dreißig', 'dritten Mai zweitausendvierundzwanzig', 'fünf Euro fünfzig']
    """
    reader = _reader(language)
    shouting = len(re.findall(r"[^\W\d_]{2,}", text)) >= 3 and text.upper() == text
    for match in reader.pattern.finditer(text):
        name = match.lastgroup or ""
        if name == "capitals" and shouting:
            continue
        said = reader.readers[name](match)
        if said is not None:
            ends = match.group().endswith(".") and _TAIL.match(text, match.end()) is not None
            yield Form(match.start(), match.end(), " ".join(said.split()), ends)


def spoken_tokens(text: str, language: Language) -> Iterator[Token]:
    """Pieces of a text between blanks and between what is written in figures, signs and short forms, with their words.

    Examples
    --------
    >>> from mien.text.languages import find_language
    >>> [(t.text, t.said, t.pause) for t in spoken_tokens("Der 7:30-Zug, z.B.", find_language("de"))]
    [('Der', '', ''), ('7:30', 'sieben Uhr dreißig', ''), ('Zug', '', ','), ('z.B.', 'zum Beispiel', '')]
    """
    forms, masked = list(written_forms(text, language)), text
    for number, form in enumerate(forms):  # one sign for the whole form, so that no blank or mark inside it cuts it
        mark = _MASKS[number % 2] * (form.end - form.start)
        masked = masked[: form.start] + mark + masked[form.end :]
    short: Mapping[str, str] = language.table.get("abbreviations", {})
    there = {form.start: form for form in forms}
    for token in tokens_of(masked, short):
        parts = [match.span() for match in _MASKED.finditer(token.text)]
        if len(parts) < 2 and not any(token.start <= form.start < token.end for form in forms):
            yield replace(token, said=short.get(token.text.lower(), ""))
            continue
        for place, (start, end) in enumerate(parts):
            found = there.get(token.start + start)
            last = place == len(parts) - 1
            pause = (token.pause or ("." if found is not None and found.ends else "")) if last else ""
            part = text[token.start + start : token.start + end]
            if found is None and not any(char.isalnum() for char in part):
                continue
            yield Token(part, token.start + start, token.start + end, pause, found.said if found else "")


@cache
def _reader(language: Language) -> _Reader:
    return _Reader(language)


def _word_before(match: re.Match[str]) -> str:
    word = re.search(r"([^\W\d_]+)[ \u00a0]\Z", match.string[max(0, match.start() - 20) : match.start()])
    return word[1].lower() if word else ""


class _Reader:
    """One language's patterns, and a method for each: from its match to what is said, None if it is none after all."""

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
        patterns = dict(self._patterns())
        self.pattern = re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in patterns.items()))
        self.readers: dict[str, Callable[[re.Match[str]], str | None]] = {
            name: partial(self._ordinal, int(name[7:])) if name.startswith("ordinal") else getattr(self, f"_{name}")
            for name in patterns
        }

    def _patterns(self) -> Iterator[tuple[str, str]]:
        table, number = self.table, self.numbers.pattern
        # Chinese and Japanese put no blanks about figures
        start, end = (r"(?<![\d.,])", "(?![A-Za-z])") if "east" in table else (r"(?<![\w.,])", r"(?!\w)")
        day, month = r"(?:0?[1-9]|[12]\d|3[01])", r"(?:0?[1-9]|1[0-2])"
        hour, minute = r"(?:[01]?\d|2[0-4])", r"[0-5]\d"
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
        if "date" in table:
            yield "iso", rf"(?<!\d)(?P<iy>\d{{4}})(?P<is>[-/])(?P<im>{month})(?P=is)(?P<id>{day})(?!\d)"
            if table.get("day_first", True):
                yield (
                    "date",
                    (
                        rf"(?<![\d.,/-])(?P<dd>{day})(?P<ds>[./-]){_BLANK}(?P<dm>{month})(?P=ds){_BLANK}"
                        r"(?P<dy>\d{4}|\d\d)(?![\d/-]|[.,]\d)"
                    ),
                )
            if "east" in table:
                years, months, days = table["east"].split()
                yield "east", rf"(?:(?P<ey>\d{{4}})(?:{years}))?(?P<em>{month})(?:{months})(?:(?P<ed>{day})(?:{days}))?"
            if table.get("dots"):
                yield "dotted", rf"(?<![\d.,])(?P<pd>{day})\.{_BLANK}(?P<pm>{month})\.(?!\d)"
            names = "|".join(re.escape(form) for forms in self.months for form in forms)
            if names:
                yield (
                    "named",
                    (
                        rf"(?<![\d.,:])(?P<nd>{day})(?:\.|er\b|º|°|:e|-?е|-?го)?{_BLANK}"
                        rf"(?P<no>(?i:(?:de |di |d')?(?:{names}))\b)"
                        + (r"(?P<ny>,? \d{4}(?!\d))?" if "named" in table else "(?P<ny>(?!))?")
                    ),
                )
        yield from self._clocks(hour, minute)
        money = "|".join(re.escape(sign) for sign in sorted(self.money, key=len, reverse=True))
        if money:
            before = money + "".join(f"|{sign}" for sign in table.get("unit_before", ""))
            yield "before", rf"(?P<bs>{before}){_BLANK}(?P<bn>{number}){end}"
            yield "after", rf"{start}(?P<an>{number}){_BLANK}(?P<as>{money}){end}"
        units = "|".join(re.escape(sign) for sign in sorted(self.units, key=len, reverse=True))
        minus = r"(?P<{}>(?<![\w\d])[-−](?=\d))?"
        if units:
            yield "unit", rf"(?:{start}|(?<=[-−])){minus.format('um')}(?P<un>{number}){_BLANK}(?P<us>{units}){end}"
        fractions = "|".join(sign for sign in self.signs if "/" in sign)
        if fractions:
            yield "fraction", rf"(?<![\w/.,])(?:{fractions})(?![\w/]|[.,]\d)"
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
        if "year" in table:
            yield "year", r"(?<![\w.,:/-])(?:1[1-9]|20)\d\d(?![\w:/]|[.,]\d|[-–]\d)"
        if "range" in table:
            yield "range", rf"(?<![\w.,-])(?P<low>{number}){_BLANK}[-–]{_BLANK}(?=(?P<high>{number})(?![-–\w]))"
        tone = "(?<![a-zü])" if self.pinyin else ""  # hao3
        yield "number", rf"{tone}{minus.format('nm')}(?P<nn>{number})"
        if "roman" in table:
            suffix, stop = table.get("roman_suffix", "(?!)"), r"\.?" if table.get("dots") else ""
            yield "century", rf"(?<!\w)(?P<xc>[IVX]{{1,6}})(?:{suffix})(?!\w)"
            yield "roman", rf"(?<![\w.])(?P<xr>[IVX]{{2,6}}){stop}(?!\w)"
        if table.get("capitals", True):
            yield "capitals", rf"(?<![\w'’])[^\W\d_a-zß-öø-ÿ]{{2,{_LETTERS_MOST}}}(?![\w'’])"
        signs = "".join(re.escape(sign) for sign in self.signs if len(sign) == 1)
        if signs:
            yield "sign", f"[{signs}]"

    def _clocks(self, hour: str, minute: str) -> Iterator[tuple[str, str]]:
        """Times: with a colon; with a stop between words of the clock; with a letter (15h30); hours alone."""
        if "clock" not in self.table:
            return
        after = self.table.get("clock_after", "")
        tail = rf"(?:{_BLANK}(?:{after})(?!\w))" if after else "(?!)"
        yield "colon", rf"(?<![\d:.,])(?P<ch>{hour}):(?P<cm>{minute})(?::(?P<cs>{minute}))?(?![\d:]|[.,]\d){tail}?"
        if "clock_before" in self.table:
            before = (
                "|".join(f"(?<={word})" for word in self.table["clock_before"].split("|") if word) or r"(?<![\d.,])"
            )
            yield (
                "stop",
                (
                    rf"(?:{before})(?P<sh>{hour})\.(?P<sm>{minute})(?![\d.]\d|\d){tail}?"
                    rf"|(?<![\d.,])(?P<th>{hour})\.(?P<tm>{minute}){tail}"
                ),
            )
        if "clock_letter" in self.table:
            letter, ends = self.table["clock_letter"], self.table.get("clock_minute", "min")
            before, edge = (r"(?<![\d.,])", "") if "east" in self.table else (r"(?<![\w.,])", r"(?![\w/])")
            yield (
                "letter",
                rf"{before}(?P<lh>{hour}){_BLANK}(?:{letter})(?:{_BLANK}(?P<lm>{minute})(?:{_BLANK}(?:{ends}))?)?{edge}",
            )
        if after:
            yield "whole", rf"(?<![\w.,])(?P<wh>{hour}){tail}"

    # ---- What is said ------------------------------------------------------------------------------------------

    def _short(self, match: re.Match[str]) -> str:
        return self.short[match.group().lower()]

    def _phone(self, match: re.Match[str]) -> str:
        plus = self.signs.get("+", "plus") + " " if match.group()[0] == "+" else ""
        return plus + self.numbers.digits(match.group())

    def _pairs(self, match: re.Match[str]) -> str:
        """A French telephone number: figures by twos, each pair a number (06 12 34 56 78)."""
        figures = re.sub(r"\D", "", match.group().replace("(0)", ""))
        parts = [figures[:2], figures[2:3], *re.findall("..", figures[3:])]
        if match.group()[0] != "+":
            parts = re.findall("..", figures)
        plus = self.signs.get("+", "plus") + " " if match.group()[0] == "+" else ""
        return plus + " ".join(
            self.numbers.digits(part) if part[0] == "0" else self.numbers.plain(part) for part in parts
        )

    def _iso(self, match: re.Match[str]) -> str | None:
        return self._day(match, match["id"], match["im"], match["iy"])

    def _date(self, match: re.Match[str]) -> str | None:
        century = "" if len(match["dy"]) == 4 else "20" if match["dy"] < "50" else "19"
        return self._day(match, match["dd"], match["dm"], century + match["dy"])

    def _east(self, match: re.Match[str]) -> str | None:
        if match["ed"]:
            return self._day(match, match["ed"], match["em"], match["ey"] or "")
        year = self.table["date"].partition("{month}")[0].replace("{year}", self._year_words(match["ey"]))
        return (year if match["ey"] else "") + str(self.months[int(match["em"]) - 1][0])

    def _dotted(self, match: re.Match[str]) -> str | None:
        return self._day(match, match["pd"], match["pm"], "")

    def _named(self, match: re.Match[str]) -> str:
        day = self.numbers.fill(f"{{d:{self._day_rule(match)}}}", d=int(match["nd"]))
        year = self.table["named"].format(self._year_words(match["ny"].lstrip(", "))) if match["ny"] else ""
        return f"{day} {match['no']} {year}"

    def _day(self, match: re.Match[str], day: str, month: str, year: str) -> str | None:
        template = self.table["date"]
        if not year and template.startswith("{year}"):
            template = "{month}" + template.partition("{month}")[2]
        elif not year:
            template = template.partition("{month}")[0] + "{month}"
        template = template.replace("{day}", f"{{day:{self._day_rule(match)}}}")
        name = self.months[int(month) - 1][0].replace("_", " ") if self.months else month
        template = template.replace("{month}", name).replace("{year}", self._year_words(year))
        return self.numbers.fill(template, day=int(day), m=int(month))

    def _day_rule(self, match: re.Match[str]) -> str:
        """The rule for the day: by the word before it (``am dritten``), the first one by a name of its own."""
        return str(self.table.get("day_after", {}).get(_word_before(match), self.table["day"]))

    def _year_words(self, written: str) -> str:
        if not written:
            return ""
        return self.numbers.fill(
            f"{{y:{self.table.get('date_year', self.table.get('year', 'numbering'))}}}", y=int(written)
        )

    def _colon(self, match: re.Match[str]) -> str:
        return self._clock(match, match["ch"], match["cm"], match["cs"])

    def _stop(self, match: re.Match[str]) -> str:
        return self._clock(match, match["sh"] or match["th"], match["sm"] or match["tm"])

    def _letter(self, match: re.Match[str]) -> str:
        return self._clock(match, match["lh"], match["lm"])

    def _whole(self, match: re.Match[str]) -> str:
        return self._clock(match, match["wh"], None)

    def _clock(self, match: re.Match[str], hour: str, minute: str | None, second: str | None = None) -> str:
        hours, minutes = int(hour), int(minute or 0)
        case = self.table.get("hour_after", {}).get(_word_before(match), "hours")
        sharp, _, full = self.table["clock"].replace(":hours", f":{case}").partition("|")
        if not minutes and not second:
            return self.numbers.fill(sharp, h=hours, m=0)
        said = self.numbers.fill(full, h=hours, m=minutes)
        return f"{said} {self.numbers.counted(second, 's')}" if second else said

    def _before(self, match: re.Match[str]) -> str:
        return self.numbers.amount(match["bn"], match["bs"])

    def _after(self, match: re.Match[str]) -> str:
        return self.numbers.amount(match["an"], match["as"])

    def _unit(self, match: re.Match[str]) -> str:
        minus = self.signs.get("−", "minus") + " " if match["um"] else ""
        return minus + self.numbers.counted(match["un"], match["us"])

    def _fraction(self, match: re.Match[str]) -> str:
        return str(self.signs[match.group()])

    def _year(self, match: re.Match[str]) -> str:
        return self.numbers.fill(f"{{y:{self.table['year']}}}", y=int(match.group()))

    def _range(self, match: re.Match[str]) -> str:
        written, word = match["low"], ""
        if self.numbers.value(written) < self.numbers.value(match["high"]):
            word = self.table["range"]
        rule = self.table.get("year") if re.fullmatch(r"(?:1[1-9]|20)\d\d", written) else None
        said = self.numbers.fill(f"{{n:{rule}}}", n=int(written)) if rule else self.numbers.plain(written)
        return f"{said} {word}"

    def _number(self, match: re.Match[str]) -> str:
        minus = self.signs.get("−", "minus") + " " if match["nm"] else ""
        return minus + self.numbers.plain(match["nn"])

    def _century(self, match: re.Match[str]) -> str | None:
        return self._roman_number(match["xc"], "{n:ordinal-masculine}")

    def _roman(self, match: re.Match[str]) -> str | None:
        return self._roman_number(match["xr"], self.table["roman"])

    def _roman_number(self, written: str, templates: str) -> str | None:
        if not _ROMAN.fullmatch(written) or written in self.words_in_capitals:
            return None
        figures = [_VALUES[letter] for letter in written]
        number = sum(-a if a < b else a for a, b in zip(figures, [*figures[1:], 0], strict=True))
        small, _, large = templates.partition("|")
        return self.numbers.fill(large if large and number > 10 else small, n=number)

    def _capitals(self, match: re.Match[str]) -> str | None:
        """A name of capitals, by its letters: all without a vowel, and short ones that are not said as a word."""
        word = match.group()
        if word.isupper() and word not in self.words_in_capitals and (len(word) <= 3 or not self.vowels.search(word)):
            return " ".join(f"{letter.lower()}." for letter in word)
        return None

    def _sign(self, match: re.Match[str]) -> str:
        return str(self.signs[match.group()])

    def _ranked(self, match: re.Match[str]) -> str:
        before = match.string[max(0, match.start() - 60) : match.start()]
        oblique = re.search(self.table["ranked_oblique"] + r"\Z", before)
        rule = "ordinal-n" if oblique else self.table["ranked_after"][_word_before(match)]
        return self.numbers.fill(f"{{n:{rule}}}", n=int(match["rn"]))

    def _counter(self, match: re.Match[str]) -> str:
        """A number and what is counted, and whether it is a stretch of time."""
        said = self.counters[match["ci"]] if match["ci"] else self._counted(int(match["cn"]), match["cw"])
        return said + (self.table["stretch"].split()[1] if match["ck"] else "")

    def _counted(self, number: int, sign: str) -> str:
        """The sounds of a number and its counter change each other: only the last figure matters."""
        forms = self.counters[sign].split()
        if f"{number}{sign}" in self.counters:  # full-width figures
            return self.counters[f"{number}{sign}"]
        rest, last = divmod(number, 10)
        if last:
            return (self.numbers.spelled(rest * 10) if rest else "") + forms[last]
        if number % 100:
            return self.numbers.spelled(number).removesuffix("じゅう") + forms[10]
        said = self.numbers.spelled(number)
        if number % 1000 and forms[10].startswith("じゅっ"):
            return said.removesuffix("く") + forms[10].removeprefix("じゅ")
        return said + (forms[3].removeprefix("さん") if number else forms[0])

    def _ordinal(self, place: int, match: re.Match[str]) -> str:
        rule = list(self.ordinals.values())[place]
        return self.numbers.fill(f"{{n:{rule}}}", n=int(match[f"o{place}"]))
