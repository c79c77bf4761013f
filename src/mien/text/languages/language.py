"""A language is one table: ``assets/languages/TAG.toml``, or a file of the user's own in the same form."""

from __future__ import annotations

import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from mien.core.assets import asset, asset_table, assets_in
from mien.core.border import guarded
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import read_plain_text
from mien.core.utterance import PAUSE
from mien.text.phones import phone_table

__all__ = ["ENGLISH", "Language", "Segment", "find_language", "known_languages", "plain_sign"]

ENGLISH = "en-US"
_COMMON = ("ipa",)
_READERS = ("letters", "espeak")
_CEDILLA = "\u0327"  # part of a letter, as in ç
_MARKS = 'ːˑˈˌ.ʰʲʷʼ˞‿-"^'  # the last two are eSpeak's own


@dataclass(frozen=True)
class Segment:
    """A stretch of a phone in the terms of the models.

    Attributes
    ----------
    articulation : str
        The English phone (ARPAbet) made most alike.
    heard : str
        The English phone that the acoustic model takes it for.
    shapes : tuple of str
        Its own key shapes (``assets/performance/visemes.toml``); empty where the English phone's do.
    """

    articulation: str
    heard: str
    shapes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Language:
    """How a language is read and made.

    Attributes
    ----------
    tag : str
        BCP 47, such as ``"fi"``.
    name : str
        In English: ``"Finnish"``.
    reader : {"letters", "espeak"}
        Whether its spelling is read by the rules in its table, or by eSpeak NG, a separate program.
    espeak : str
        eSpeak NG's voice for it; ``""`` if it has none.
    table : mapping
        The whole table.
    """

    tag: str
    name: str
    reader: str
    espeak: str
    table: Mapping[str, Any]
    _segments: Mapping[str, tuple[Segment, ...]]

    def segments(self, phone: str) -> tuple[Segment, ...]:
        """What a phone is in the terms of the models; empty if it has no sound of its own.

        Raises
        ------
        InputError
            If neither this language's table nor the common one (``ipa.toml``) holds a part of it.

        Examples
        --------
        >>> [segment.articulation for segment in find_language("fi").segments("yː")]
        ['UW']
        >>> [segment.heard for segment in find_language("de").segments("pf")]
        ['P', 'F']
        """
        plain = plain_sign(phone)
        for sign in (phone, plain, plain.rstrip(self.table.get("tones", ""))):
            if sign in self._segments:
                return self._segments[sign]
        return self._cut(plain.rstrip(self.table.get("tones", "")), phone)

    def _cut(self, sign: str, phone: str) -> tuple[Segment, ...]:
        """A sign that is in none of its tables, cut into the longest ones that are."""
        found: list[Segment] = []
        while sign:
            part = next((sign[:n] for n in range(len(sign), 0, -1) if sign[:n] in self._segments), "")
            if not part:
                raise InputError(
                    f"{self.name}: the phone {phone!r} is in none of its tables: add it to [phones] of its file"
                )
            found += self._segments[part]
            sign = sign[len(part) :]
        return tuple(found)


def plain_sign(phone: str) -> str:
    """A phone's sign without marks of stress, length and the like.

    Examples
    --------
    >>> plain_sign("ˈyː"), plain_sign("t͡s"), plain_sign("ɔ̃"), plain_sign("õ"), plain_sign("ç")
    ('y', 'ts', 'ɔ', 'o', 'ç')
    """
    kept = (char for char in unicodedata.normalize("NFD", phone) if char not in _MARKS)
    return unicodedata.normalize("NFC", "".join(c for c in kept if c == _CEDILLA or unicodedata.category(c) != "Mn"))


def known_languages() -> tuple[str, ...]:
    """Tags of the languages beside English that come with mien.

    Examples
    --------
    >>> known_languages()
    ('cs', 'de', 'el', 'es', 'fi', 'fr', 'it', 'ja', 'nl', 'pl', 'pt', 'ru', 'sv', 'tr', 'zh')
    """
    return tuple(tag for tag in assets_in("languages") if tag not in _COMMON)


def find_language(asked: str | Path | None) -> Language | None:
    """The language of a tag (``"fi"``, ``"de-AT"``) or of a table in a file (``"it.toml"``); None for English.

    Raises
    ------
    InputError
        If there is no such language, or the file is damaged.

    Examples
    --------
    >>> find_language("fi").name, find_language("en-GB"), find_language("de-CH").tag
    ('Finnish', None, 'de')
    >>> find_language("fin")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    mien.core.errors.InputError: unknown language 'fin': did you mean 'fi'? known: ...
    """
    if asked is None:
        return None
    name = str(asked).strip()
    if name.lower().endswith(".toml"):
        return _load(Path(name))
    head = name.lower().replace("_", "-").partition("-")[0]
    if head == "en":
        return None
    if head not in known_languages():
        raise InputError(f"{unknown_name('language', name, ('en', *known_languages()))}; or a phone map, X.toml")
    return _shipped(head)


@cache
def _shipped(tag: str) -> Language:
    return _load(asset(f"languages/{tag}.toml"))


@guarded("a phone map of a language")
def _load(path: Path) -> Language:
    text, _ = read_plain_text(path, "a phone map")
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise InputError(f"the language {path} is not TOML: {problem}") from problem
    for name in ("tag", "name", "reader"):
        if not isinstance(table.get(name), str) or not table[name]:
            raise InputError(f'the language {path}: expected {name} = "..." at its top')
    if table["reader"] not in _READERS:
        raise unknown_name(f"reader in {path}", table["reader"], _READERS)
    if table["reader"] == "espeak" and not table.get("espeak"):
        raise InputError(f'the language {path}: reader = "espeak" needs espeak = "VOICE" (espeak-ng --voices)')
    if table["reader"] == "letters" and not table.get("letters"):
        raise InputError(f'the language {path}: reader = "letters" needs a section [letters]')
    for letter, phones in table.get("letters", {}).items():
        if not (isinstance(phones, list) and phones and all(isinstance(phone, str) for phone in phones)):
            raise InputError(f'the language {path}, letter {letter!r}: expected a list of phones such as ["n"]')
    segments = {sign: _segments(entry, path, sign) for sign, entry in (_common() | table.get("phones", {})).items()}
    return Language(table["tag"], table["name"], table["reader"], table.get("espeak", ""), table, segments)


@cache
def _common() -> dict[str, Any]:
    return dict(asset_table("languages/ipa.toml")["phones"])


def _segments(entry: Any, path: Path, sign: str) -> tuple[Segment, ...]:
    where = f"the language {path}, phone {sign!r}"
    return tuple(_segment(part, where) for part in (entry if isinstance(entry, list) else [entry]))


def _segment(part: Any, where: str) -> Segment:
    if isinstance(part, str):
        part = {"as": part}
    if not isinstance(part, dict) or not isinstance(part.get("as"), str):
        raise InputError(f'{where}: expected an English phone such as "AA", or {{ as = "AA", ... }}, got {part!r}')
    for name in part:
        if name not in ("as", "heard", "shape"):
            raise unknown_name(f"entry of {where}", name, ("as", "heard", "shape"))
    articulation, heard = str(part["as"]), str(part.get("heard", part["as"]))
    for phone in (articulation, heard):
        if phone not in phone_table() or phone == PAUSE:
            raise unknown_name(f"English phone of {where}", phone, phone_table())
    return Segment(articulation, heard, tuple(str(part.get("shape", "")).split()))
