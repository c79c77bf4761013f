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

from mien.text.languages.language import Language
from mien.text.languages.tokens import Token, tokens_of
from mien.text.languages.written_patterns import WrittenPatterns

__all__ = ["Form", "spoken_tokens", "written_forms"]

_TAIL = re.compile(r"[\"'”“»)\]\s]*\Z")
_ROMAN = re.compile(r"X{0,3}(?:IX|IV|V?I{0,3})")
_VALUES = {"I": 1, "V": 5, "X": 10}
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


class _Reader(WrittenPatterns):
    """A method for each pattern of a language: from its match to what is said, None if it is none after all."""

    def __init__(self, language: Language) -> None:
        super().__init__(language)
        patterns = dict(self.patterns())
        self.pattern = re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in patterns.items()))
        self.readers: dict[str, Callable[[re.Match[str]], str | None]] = {
            name: partial(self._ordinal, int(name[7:])) if name.startswith("ordinal") else getattr(self, f"_{name}")
            for name in patterns
        }

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
