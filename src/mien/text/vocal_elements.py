"""Elements that say how a text is spoken, as SSML has them: `VOCAL_ELEMENTS`."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import log2, log10

from mien.core.errors import InputError, unknown_name
from mien.text.parameter_values import Given, needed, only
from mien.text.say_as import say_as
from mien.text.script import Prosody, Spelling
from mien.text.script_builder import SILENT, Builder
from mien.text.written_phones import phones_of

__all__ = ["VOCAL_ELEMENTS"]

RATES = {"x-slow": 0.5, "slow": 0.75, "medium": 1.0, "default": 1.0, "fast": 1.3, "x-fast": 1.7}
PITCHES = {"x-low": -5.0, "low": -2.5, "medium": 0.0, "default": 0.0, "high": 2.5, "x-high": 5.0}
VOLUMES = {"silent": -90.0, "x-soft": -12.0, "soft": -6.0, "medium": 0.0, "default": 0.0, "loud": 4.0, "x-loud": 7.0}
EMPHASIS = {
    "strong": (0.8, 1.5, 4.0),
    "moderate": (0.88, 0.8, 2.5),
    "none": (1.0, 0.0, 0.0),
    "reduced": (1.12, -0.5, -3.0),
}
"""Rate, semitones and decibels of an emphasised stretch. Hand-made."""


def _sentence(builder: Builder, given: Given) -> None:
    only(given)
    item = builder.opened[-1]

    def close() -> None:
        said = builder.text[builder.start_in(item) :].rstrip()
        if said and said[-1] not in ".?!:;":
            builder.text = builder.text.rstrip() + "."
        if said and not builder.text.endswith(" "):
            builder.text += " "

    item.close = close


def _sub(builder: Builder, given: Given) -> None:
    only(given, "alias")
    alias, item = needed(given, "alias"), builder.opened[-1]

    def close() -> None:
        builder.text = builder.text[: builder.start_in(item)] + alias

    item.close = close


def _say_as(builder: Builder, given: Given) -> None:
    only(given, "interpret-as", "format", "detail")
    kind, item = needed(given, "interpret-as"), builder.opened[-1]
    for name in ("format", "detail"):
        if name in given:
            builder.note(f"say-as: {name}={given[name]!r} is not followed")

    def close() -> None:
        start = builder.start_in(item)
        said = say_as(kind, builder.text[start:])
        if said is None:
            builder.note(f"say-as: {kind!r} is not known; the text is read as it is written")
        else:
            builder.text = builder.text[:start] + said

    item.close = close


def _phoneme(builder: Builder, given: Given) -> None:
    only(given, "ph", "alphabet", "type")
    alphabet, item = given.get("alphabet", "ipa"), builder.opened[-1]
    if given.get("type", "default") != "default":
        builder.note(f"phoneme: type={given['type']!r} is not followed")
    try:
        phones = phones_of(needed(given, "ph"), alphabet)
    except InputError as problem:
        if alphabet.lower().endswith("arpabet"):
            raise
        builder.note(f"phoneme: {problem}; the word is read as it is written")
        return

    def close() -> None:
        start = builder.start_in(item)
        said = builder.text[start:]
        if not said.strip():
            raise InputError("<phoneme> stands around the word that it is for")
        if len(said.split()) > 1 or not any(char.isalpha() for char in said):
            builder.note(f"phoneme: {said.strip()!r} is not one word in letters; it is read as it is written")
            return
        builder.spellings.append(Spelling(start, len(builder.text), phones))

    item.close = close


def _emphasis(builder: Builder, given: Given) -> None:
    only(given, "level")
    level = given.get("level", "moderate")
    if level not in EMPHASIS:
        raise unknown_name("level of emphasis", level, EMPHASIS)
    _spoken(builder, *EMPHASIS[level])


def _prosody(builder: Builder, given: Given) -> None:
    only(given, "rate", "pitch", "volume", "contour", "range", "duration")
    for name in ("contour", "range", "duration"):
        if name in given:
            builder.note(f"prosody: {name} is not followed: no voice here can")
    rate = _rate(given["rate"], builder) if "rate" in given else None
    pitch = _semitones(given["pitch"], builder) if "pitch" in given else None
    volume = _decibels(given["volume"], builder) if "volume" in given else None
    _spoken(builder, rate, pitch, volume)


def _rate(text: str, builder: Builder) -> float:
    if text.strip() in RATES:
        return RATES[text.strip()]
    found = re.fullmatch(r"([+-]?)(\d+(?:\.\d+)?)(%?)", text.strip())
    if found is None:
        raise InputError(f"a rate is such as slow, 80% or 1.2, not {text!r}")
    number = float(found[2]) / (100 if found[3] else 1)
    rate = 1 + number * (-1 if found[1] == "-" else 1) if found[1] else number
    if not 0.25 <= rate <= 4 and builder.is_ssml:
        builder.note(f"prosody: a rate of {text} is limited to between 0.25 and 4 times as fast")
        return min(4.0, max(0.25, rate))
    if not 0.25 <= rate <= 4:
        raise InputError(f"a rate lies between 0.25 and 4 times as fast, not {rate:g}")
    return rate


def _semitones(text: str, builder: Builder) -> float | None:
    if text.strip() in PITCHES:
        return PITCHES[text.strip()]
    found = re.fullmatch(r"([+-]\d+(?:\.\d+)?)(st|%)", text.strip())
    if found is None:
        if re.fullmatch(r"[+-]?\d+(?:\.\d+)?(Hz)?", text.strip(), re.IGNORECASE):
            builder.note(f"prosody: a pitch of {text} is not followed; give it as +2st or +10%")
            return None
        raise InputError(f"a pitch is such as high, +2st or -10%, not {text!r}")
    if found[2] == "st":
        pitch = float(found[1])
    else:
        factor = 1 + float(found[1]) / 100
        pitch = 12 * log2(factor) if factor > 0 else -99.0
    if not -12 <= pitch <= 12 and builder.is_ssml:
        builder.note(f"prosody: a pitch of {text} is limited to within 12 semitones")
        return min(12.0, max(-12.0, pitch))
    if not -12 <= pitch <= 12:
        raise InputError(f"a pitch changes by at most 12 semitones, not {text!r}")
    return round(pitch, 6)


def _decibels(text: str, builder: Builder) -> float | None:
    if text.strip() in VOLUMES:
        return VOLUMES[text.strip()]
    if re.fullmatch(r"[+-]\d+(\.\d+)?%?|\d+(\.\d+)?%", text.strip()):
        builder.note(f"prosody: a volume of {text} is not followed; give it as +3dB")
        return None
    found = re.fullmatch(r"([+-]?\d+(?:\.\d+)?)(dB)?", text.strip())
    if found is None:
        raise InputError(f"a volume is such as soft or +3dB, not {text!r}")
    if found[2]:
        return max(-90.0, min(12.0, float(found[1])))
    share = float(found[1]) / 100  # SSML 1.0: 0 to 100
    if not 0 <= share <= 1:
        raise InputError(f"a volume without dB runs from 0 to 100, not {text!r}")
    return round(20 * log10(share), 6) if share > 0 else -90.0


def _spoken(builder: Builder, rate: float | None, pitch: float | None, volume: float | None) -> None:
    here = builder.point()

    def close() -> None:
        if (rate, pitch, volume) != (None, None, None):
            builder.prosody.append(Prosody(here, builder.point(after=True), rate, pitch, volume))

    builder.opened[-1].close = close


def _voice(builder: Builder, given: Given) -> None:
    only(given, "name", "gender", "age", "variant", "languages", "required", "ordering", "onvoicefailure")
    for name in given:
        if name != "name":
            builder.note(f"voice: {name} is not followed; name a voice of mien (mien doctor lists them)")
    if not given.get("name", "").strip():
        return
    builder.end_segment()
    names = " ".join(given["name"].split())
    builder.voices.append(f"{names} ..." if builder.is_ssml else names)

    def close() -> None:
        builder.end_segment()
        builder.voices.pop()

    builder.opened[-1].close = close


def _audio(builder: Builder, given: Given) -> None:
    builder.note(f"audio: {given.get('src', 'the sound')!r} is not played; the text in the element is spoken")


def _passed_over(builder: Builder, given: Given) -> None:
    builder.note(f"<{builder.opened[-1].event.text}> is not followed")


def _as_it_is(builder: Builder, given: Given) -> None:
    for name in given:
        if name not in ("id", "xml:id"):
            builder.note(f"{builder.opened[-1].event.text}: {name}={given[name]!r} is not followed")


def _lookup(builder: Builder, given: Given) -> None:
    builder.note("lookup: lexicons are not read; its words are spoken as usual")


VOCAL_ELEMENTS: dict[str, Callable[[Builder, Given], None]] = {
    "p": _sentence,
    "s": _sentence,
    "w": _as_it_is,
    "token": _as_it_is,
    "lang": _as_it_is,
    "lookup": _lookup,
    "sub": _sub,
    "say-as": _say_as,
    "phoneme": _phoneme,
    "emphasis": _emphasis,
    "prosody": _prosody,
    "voice": _voice,
    "audio": _audio,
    **dict.fromkeys(SILENT, _passed_over),
}
"""Every element that is no command, by name."""
