"""The patterns that `mien.text.normalisation` looks for, and what each of them is read as.

A reader gets its match, the whole text and whether the text shouts (is mostly in capitals), and gives pieces
``(start, end, spoken words)`` of the text.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable

from mien.text.spoken_numbers import cardinal, decimal, digits, english_table, fraction, ordinal, plural, year

__all__ = ["READERS", "TEXT_PATTERN"]

_VULGAR = "½¼¾⅓⅔"
_LETTER = rf"[^\W\d_²³µπ{_VULGAR}]\u0301*"  # letters that stand for words are signs
_NUMBER = r"(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?|\.\d+"
_MONTHS = "january|february|march|april|may|june|july|august|september|october|november|december"
_SHORT_MONTHS = r"(?:jan|feb|mar|apr|jun|jul|aug|sept?|oct|nov|dec)\b\.?"

_NOT_SPOKEN = re.compile("[^a-z']+")
_NAME_AFTER = re.compile(r"\s{1,9}[A-Z][a-z]")
_WORD_AND_BLANKS = 60
_LONG_AMOUNT = 15  # digits

Piece = tuple[int, int, str]
Reader = Callable[[re.Match[str], str, bool], list[Piece]]


def _just_before(match: re.Match[str], text: str) -> str:
    """The word before a match and what parts them, and a little more."""
    return text[max(0, match.start() - _WORD_AND_BLANKS) : match.start()]


def _whole(match: re.Match[str], spoken: str) -> list[Piece]:
    return [(match.start(), match.end(), spoken)]


def _address(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    signs = english_table()["address_signs"] | english_table()["signs"]
    address = re.sub(r"^https?://(www\.)?", "", match.group(), flags=re.IGNORECASE).rstrip("/")
    pieces = []
    for part in re.findall(r"[A-Za-z]+|\d+|.", address):
        if part.isdecimal():
            pieces.append(digits(part) if len(part) > 2 else cardinal(int(part)))
        else:
            pieces.append(_plain_word(part, False) if part.isalpha() else signs.get(part, ""))
    return _whole(match, " ".join(pieces))


def _money(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    table = english_table()
    one, many, part, parts = table["currencies"][match["sign"]]
    amount = match["amount"].replace(",", "")
    size = match["size"]
    whole, _, cents = amount.partition(".")
    if size:
        return _whole(match, f"{decimal(amount)} {table['magnitudes'][size]} {many}")
    if len(cents) != 2 or len(whole) > _LONG_AMOUNT:
        return _whole(match, f"{decimal(amount)} {one if amount == '1' else many}")
    spoken = [f"{cardinal(int(whole))} {one if int(whole) == 1 else many}"] if int(whole or 0) else []
    if int(cents):
        spoken.append(f"{cardinal(int(cents))} {part if int(cents) == 1 else parts}")
    return _whole(match, " ".join(spoken) or f"zero {many}")


def _date(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    if match["iso_year"]:
        number, month, day = int(match["iso_year"]), int(match["iso_month"]), int(match["iso_day"])
    else:
        month, day, number = int(match["us_month"]), int(match["us_day"]), int(match["us_year"])
    if not (1 <= month <= 12 and 1 <= day <= 31):
        return _whole(match, digits(match.group()))
    if number < 100:
        number += 2000 if number < 50 else 1900
    return _whole(match, f"{english_table()['numbers']['months'][month - 1]} {ordinal(day)} {year(number)}")


def _month_day(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    name = match["month"].lower()
    month = english_table()["abbreviations"].get(name.rstrip(".") + ".", name)
    return [(match.start("month"), match.end("month"), month), (*match.span("day"), ordinal(int(match["day"])))]


def _fixed(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, english_table()["fixed"][match.group()])


def _letters_and_letters(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``AT&T``, ``R&D``: letters by name."""
    spelt = [" ".join(f"{letter.lower()}." for letter in part) for part in match.group().split("&")]
    return _whole(match, " and ".join(spelt))


def _day_month_year(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``30.11.2026``: the day first, as most of the world writes it."""
    day, month, number = int(match["dot_day"]), int(match["dot_month"]), int(match["dot_year"])
    return _whole(match, f"{english_table()['numbers']['months'][month - 1]} {ordinal(day)} {year(number)}")


def _instant(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``2026-11-30T12:00Z``: the date is read by itself, what follows the T is a clock's time."""
    zone = " u. t. c." if match["zone"] else ""
    return _whole(match, f"at {_clock_words(int(match['t_hour']), int(match['t_minute']))}{zone}")


def _net_number(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``192.168.0.1`` digit by digit, ``3.11.7`` number by number."""
    parts = match.group().split(".")
    read, dot = (digits, " dot ") if len(parts) == 4 else (lambda part: cardinal(int(part)), " point ")
    return _whole(match, dot.join(read(part) for part in parts))


def _sized(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``1.5M``, ``2k``."""
    return _whole(match, f"{decimal(match['how_many'])} {english_table()['magnitudes'][match['magnitude']]}")


def _listed(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """A Roman number that begins a line of a list: ``iv.``, ``(II)``."""
    number = _roman_value(match["item"])
    return _whole(match, cardinal(number)) if number else _word(match, text, shouting)


def _roman_value(written: str) -> int:
    """The value of a Roman number up to 39; 0 if it is none."""
    parts = re.fullmatch(r"(X{0,3})(IX|IV|V?I{0,3})", written.upper())
    ones = {"": 0, "I": 1, "II": 2, "III": 3, "IV": 4, "V": 5, "VI": 6, "VII": 7, "VIII": 8, "IX": 9}
    return 10 * len(parts[1]) + ones[parts[2]] if parts else 0


def _clock_words(hour: int, minute: int) -> str:
    if hour in (0, 24) and not minute:
        return "midnight"
    if minute:
        return cardinal(hour) + (" oh " if minute < 10 else " ") + cardinal(minute)
    return cardinal(hour) + (" o'clock" if 1 <= hour <= 12 else " hundred")


def _zip(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """A postal code after the letters of its state: ``CA 90210``."""
    return _whole(match, digits(match.group()).replace("zero", "oh"))


def _clock(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    hour, minute = int(match["hour"]), int(match["minute"])
    half = (match["half"] or "").lower().replace(".", "")
    spoken = cardinal(hour) if half and not minute else _clock_words(hour, minute)
    if match["second"]:
        spoken += f" and {cardinal(int(match['second']))} seconds"
    return _whole(match, spoken + (f" {half[0]}. m." if half else ""))


def _phone_number(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, ("plus " if match.group().startswith("+") else "") + digits(match.group()))


def _fraction(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    whole = f"{cardinal(int(match['whole']))} and " if match["whole"] else ""
    top, bottom = int(match["top"]), int(match["bottom"])
    spoken = fraction(top, bottom) if whole == "" or top != 1 else "a " + fraction(top, bottom).partition(" ")[2]
    return _whole(match, whole + spoken)


def _mixed(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, f"{cardinal(int(match['units']))} and {english_table()['signs'][match['vulgar']]}")


def _roman(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """Numbered after such as "chapter", ranked after a name, else a word in capitals."""
    number = _roman_value(match.group())
    before = re.search(r"([^\W\d_]+)\s+$", _just_before(match, text))
    name = before[1] if before else ""
    several = len(match.group()) > 1
    if _is_numbered(name) and (several or name[0].isupper()):
        return _whole(match, cardinal(number))
    if name[:1].isupper() and several and not shouting:
        return _whole(match, f"the {ordinal(number)}")
    return _word(match, text, shouting)


def _is_numbered(name: str) -> bool:
    """Whether a word, or what it is the plural of, has numbers after it: "chapter", "Types"."""
    return bool({name.lower(), name.lower().removesuffix("s")} & set(english_table()["numbers"]["numbered"]))


def _romans(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """Several in a row: ``I, II and III``, ``Henry VII and VIII``."""
    found = list(re.finditer(r"[IVX]+", match.group()))
    if not any(len(item.group()) > 1 for item in found):
        found = []
    before = re.search(r"([^\W\d_]+)\s+$", _just_before(match, text))
    ranked = bool(before and before[1][0].isupper() and not _is_numbered(before[1]) and not shouting)
    pieces = []
    for item in re.finditer(r"\w+", match.group()):
        number = _roman_value(item.group()) if item.group().isupper() else 0
        if not number or not found or (ranked and len(item.group()) == 1):
            spoken = _plain_word(item.group(), shouting)
        else:
            spoken = f"the {ordinal(number)}" if ranked else cardinal(number)
        pieces.append((match.start() + item.start(), match.start() + item.end(), spoken))
    return pieces


def _power(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``10^6``: what stands after the number."""
    minus = "minus " if match["power_minus"] else ""
    named = {"2": "squared", "3": "cubed"} if not minus else {}
    spoken = named.get(match["power_of"], f"to the {minus}{cardinal(int(match['power_of']))}")
    return _whole(match, spoken)


def _ordinal(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, ordinal(int(match["place"].replace(",", ""))))


def _decade(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    number = int(match["tens"])
    head, _, last = (year(number) if number >= 100 else cardinal(number)).rpartition(" ")
    return _whole(match, f"{head} {plural(last)}")


def _several(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """More than one of what is named by letters and a number: ``MP3s``."""
    head, _, last = cardinal(int(match["tens_of"])).rpartition(" ")
    return _whole(match, f"{head} {plural(last)}".strip())


def _years(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    last = match["last_year"]
    spoken = year(int(last)) if len(last) == 4 else cardinal(int(last))
    return _whole(match, f"{year(int(match['first_year']))} to {spoken}")


def _range(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    """``50-60``: the first number and "to"; the second one, with its unit, is read next. Not ``747-400``."""
    low, high = int(match["low"]), int(match["high"])
    return [(match.start("low"), match.end("low"), decimal(match["low"]) + (" to" if low < high else ""))]


def _height(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, f"{cardinal(int(match['feet']))} foot {cardinal(int(match['inches']))}")


def _quantity(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    amount, unit = match["measure"].replace("—", "-"), match["unit"]
    one, many = english_table()["units"][unit]
    minus = "minus " if match["minus"] else ""
    return _whole(match, f"{minus}{decimal(amount)} {one if amount == '1' else many}")


def _number(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    written = match["plain"]
    minus = "minus " if match["minus_sign"] else ""
    if written.isdecimal() and len(written) == 4 and 1100 <= int(written) < 2100 and not minus:
        return _whole(match, year(int(written)))
    if written.isdecimal() and (len(written) > 9 or (written[0] == "0" and len(written) > 1)):
        return _whole(match, minus + digits(written))
    return _whole(match, minus + decimal(written))


def _abbreviation(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, english_table()["abbreviations"][match.group().lower()])


def _title(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, english_table()["titles"][match.group()])


def _before_number(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, english_table()["before_number"][match.group().lower()])


def _street_or_saint(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    table = english_table()["street_or_saint"]
    after_name = re.search(r"(?:[A-Z][a-z]+|\d(?:st|nd|rd|th))\s+$", _just_before(match, text))
    before_name = _NAME_AFTER.match(text, match.end())
    return _whole(match, table["before_name" if before_name and not after_name else "after_name"])


def _initials(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, " ".join(f"{letter.lower()}." for letter in match.group() if letter.isalpha()))


def _word(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    return _whole(match, _plain_word(match.group(), shouting))


def _plain_word(word: str, shouting: bool) -> str:
    bare, apostrophe, ending = word.partition("'")
    if len(bare) > 1 and bare.isupper() and not shouting and _is_spelt_out(bare):
        letters = [f"{letter}." for letter in _fold(bare)]
        return " ".join(letters) + ("'s" if ending.lower() == "s" else "")
    if len(word) > 2 and not apostrophe and word.endswith("s") and word[:-1].isupper() and _is_spelt_out(word[:-1]):
        return " ".join(f"{letter}." for letter in _fold(word[:-1])) + "'s"
    return _fold(word) if apostrophe and ending else _fold(word).strip("'")


def _is_spelt_out(capitals: str) -> bool:
    """Whether a word in capitals is said letter by letter: listed, or no word of the dictionary."""
    from mien.text.pronunciation import in_dictionary

    return capitals in english_table()["spelt_out"]["words"] or (
        len(capitals) <= 5 and not in_dictionary(_fold(capitals))
    )


def _sign(match: re.Match[str], text: str, shouting: bool) -> list[Piece]:
    sign = match.group()
    if sign == "#" and text[match.end() : match.end() + 1].isdecimal():
        return _whole(match, "number")
    return _whole(match, english_table()["signs"][sign])


def _fold(word: str) -> str:
    """Plain lower-case letters a-z and apostrophes of a word with accents."""
    plain = word.lower()
    if not plain.isascii():
        table = english_table()["folded_letters"]
        plain = unicodedata.normalize("NFD", "".join(table.get(char, char) for char in word)).lower()
    return _NOT_SPOKEN.sub("", plain)


def _any_of(names: list[str]) -> str:
    return "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))


def _numbers() -> dict[str, tuple[str, Reader]]:
    """Addresses, dates, times, money and numbers: what is tried first."""
    table = english_table()
    currencies, sizes = _any_of(list(table["currencies"])), _any_of(list(table["magnitudes"]))
    return {
        "address": (
            r"(?i:https?://[^\s\"<>]*[\w/]|www\.[^\s\"<>]*[\w/]|[\w.+-]{1,64}@[\w-]{1,63}(?:\.[\w-]{1,63})+"
            r"|[a-z][\w-]{0,63}\.(?:com|org|net|edu|gov|io)\b)",
            _address,
        ),
        "fixed": (rf"(?<![\w./])(?:{_any_of(list(table['fixed']))})(?![\w/]|\.\d|-\w)", _fixed),
        "lettersandletters": (r"\b[A-Z]{1,3}&[A-Z]{1,3}\b", _letters_and_letters),
        "daymonthyear": (
            r"(?<![\d.])(?P<dot_day>0?[1-9]|[12]\d|3[01])\.(?P<dot_month>0?[1-9]|1[0-2])\.(?P<dot_year>\d{4})"
            r"(?![\d.]\d|\d)",
            _day_month_year,
        ),
        "instant": (
            r"(?<=\d)T(?P<t_hour>[01]\d|2[0-3]):(?P<t_minute>[0-5]\d)(?::[0-5]\d(?:\.\d{1,9})?)?(?P<zone>Z)?",
            _instant,
        ),
        "netnumber": (r"(?<![\w.])\d{1,3}(?:\.\d{1,3}){2,3}(?![\w]|\.\d)", _net_number),
        "zip": (r"(?<=\b[A-Z]{2} )\d{5}\b(?!,\d)", _zip),
        "listed": (r"(?:(?<=\n)|^)[ \t]{0,9}\(?(?P<item>[ivxIVX]{1,6})(?=[.)][ \t])(?!\.[ \t][A-Z]\.)", _listed),
        "money": (rf"(?P<sign>{currencies})\s?(?P<amount>{_NUMBER})(?:\s?(?P<size>{sizes})\b)?", _money),
        "date": (
            r"(?P<iso_year>\d{4})-(?P<iso_month>\d\d)-(?P<iso_day>\d\d)(?=T\d\d:|\b)"
            r"|(?P<us_month>\d\d?)/(?P<us_day>\d\d?)/(?P<us_year>\d{4}|\d\d)\b",
            _date,
        ),
        "monthday": (
            rf"(?i:(?P<month>\b(?:{_MONTHS}|{_SHORT_MONTHS}))\s+(?P<day>[0-3]?\d)(?:st|nd|rd|th)?\b(?![\d:.]\d))",
            _month_day,
        ),
        "clock": (
            r"(?P<hour>[01]?\d|2[0-4]):(?P<minute>[0-5]\d)(?::(?P<second>[0-5]\d))?"
            r"(?:\s?(?P<half>(?i:[ap]\.m\.|[ap]m\b))|\b)",
            _clock,
        ),
        "phonenumber": (
            r"\+\d{1,3}(?:[ .-]\d{2,4}){2,4}\b|\(\d{3}\)\s?\d{3}-\d{4}\b|(?:\d{3}[.-]){1,2}\d{4}\b",
            _phone_number,
        ),
        "mixed": (rf"(?P<units>\d{{1,9}})\s?(?P<vulgar>[{_VULGAR}])", _mixed),
        "fraction": (r"(?:(?P<whole>\d{1,9})\s)?(?P<top>\d{1,2})/(?P<bottom>[1-9]\d?)\b(?![/\d])", _fraction),
        "ordinal": (r"(?i:(?P<place>\d[\d,]{0,12})(?:st|nd|rd|th))\b", _ordinal),
        "several": (r"(?<=[A-Z])(?P<tens_of>\d{1,2})'?s\b", _several),
        "decade": (r"'?(?P<tens>\d{0,3}0)'?s\b(?<=\d\ds|\d's)", _decade),
        "years": (r"(?P<first_year>1[1-9]\d\d|20\d\d)[-—](?P<last_year>\d{4}|\d\d)\b", _years),
        "range": (r"(?<![\w.-])(?P<low>\d{1,9})[-—](?=(?P<high>\d{1,9})(?!\d|[-—.]\d|[A-Za-z]))", _range),
        "height": (r"(?P<feet>\d)'\s?(?P<inches>\d\d?)(?:\"|'')?", _height),
        "quantity": (
            rf"(?P<minus>(?<!\w)-)?(?P<measure>{_NUMBER})\s?(?P<unit>{_any_of(list(table['units']))})(?![\w'])",
            _quantity,
        ),
        "power": (r"(?<=\d)\^(?P<power_minus>-)?(?P<power_of>\d{1,3})\b", _power),
        "sized": (rf"(?P<how_many>{_NUMBER})(?P<magnitude>k|K|M|B|bn)\b", _sized),
        "number": (rf"(?P<minus_sign>(?<![\w.])-)?(?P<plain>{_NUMBER})", _number),
    }


def _letters() -> dict[str, tuple[str, Reader]]:
    """Abbreviations, initials, signs and plain words."""
    table = english_table()
    return {
        "streetorsaint": (r"\bSt\b\.?", _street_or_saint),
        "abbreviation": (rf"(?i:(?<![\w.])(?:{_any_of(list(table['abbreviations']))}))", _abbreviation),
        "title": (rf"\b(?:{_any_of(list(table['titles']))})\b", _title),
        "beforenumber": (rf"(?i:\b(?:{_any_of(list(table['before_number']))})(?=\s?\d))", _before_number),
        "romans": (r"\b[IVX]{1,5}(?:(?:,\s|,?\s(?:and|or|to)\s)[IVX]{1,5}\b(?!'))+", _romans),
        "roman": (r"\b(?:X{1,2}(?:I[XV]|VI{0,3}|I{1,3})?|I[XV]|VI{0,3}|I{1,3})\b(?!')(?!(?<!I)\.\s?[A-Z])", _roman),
        "initials": (r"\b(?:[A-Za-z]\.){2,}|\b[A-HJ-Z]\.(?=\s?[A-Z])", _initials),
        "lonesign": (f"[{re.escape(''.join(table['signs']))}]", _sign),
        "word": (rf"'?{_LETTER}(?:{_LETTER}|'(?={_LETTER}))*", _word),
    }


_PATTERNS = _numbers() | _letters()
READERS: dict[str, Reader] = {name: reader for name, (_, reader) in _PATTERNS.items()}
TEXT_PATTERN = re.compile("|".join(f"(?P<{name}>{pattern})" for name, (pattern, _) in _PATTERNS.items()))
