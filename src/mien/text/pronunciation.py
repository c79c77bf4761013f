"""How an English word is pronounced: the dictionary, inflections and compounds of its words, then letters to sounds.

The dictionary is the one inside pocketsphinx (BSD licence): 126 052 words in the 39 phones of ARPAbet. A word that
it does not hold is taken apart (``cats`` = ``cat`` + ``s``, ``snowface`` = ``snow`` + ``face``) and, failing that,
spoken by rules learned from the dictionary (`mien.text.letter_to_sound`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, lru_cache
from importlib.util import find_spec
from mmap import ACCESS_READ, mmap
from pathlib import Path

from mien.core.errors import InputError, MissingPartError
from mien.text.phones import is_vowel, phone_table

__all__ = ["Pronunciation", "dictionary_entries", "in_dictionary", "pocketsphinx_model", "pronounce", "pronunciations"]

Pronunciation = tuple[str, ...]

_SIBILANTS = ("S", "Z", "SH", "ZH", "CH", "JH")
_SHORTEST_PART = 4


class _Dictionary:
    """A dictionary file in the order of its words, read where it is asked: parsed whole it would cost each start."""

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            self._text = mmap(file.fileno(), 0, access=ACCESS_READ)

    def entries(self) -> Iterator[tuple[str, str]]:
        """Headword, with ``(2)`` and on for alternatives, and phones separated by blanks."""
        return self._from(0)

    def __getitem__(self, word: str) -> list[str]:
        """The phones of a word and of its alternatives, in the order of the file; none if it is not there."""
        before, behind = -1, len(self._text)  # a line that starts at or before the first, and where it may not start
        while behind - before > 1:
            middle = (before + behind) // 2
            line = self._text.rfind(b"\n", 0, middle) + 1
            if self._word_at(line) < word:
                end = self._text.find(b"\n", middle)
                before = end if end >= 0 else len(self._text)
            else:
                behind = line
        found = []
        for headword, phones in self._from(before + 1):
            if headword.partition("(")[0] != word:
                break
            found.append(phones)
        return found

    def _word_at(self, line: int) -> str:
        return self._text[line : self._text.find(b" ", line)].decode().partition("(")[0]

    def _from(self, place: int) -> Iterator[tuple[str, str]]:
        while place < len(self._text):
            end = self._text.find(b"\n", place)
            end = end if end >= 0 else len(self._text)
            word, blank, phones = self._text[place:end].decode().partition(" ")
            if blank:
                yield word, phones
            place = end + 1


@cache
def _dictionary() -> _Dictionary:
    return _Dictionary(pocketsphinx_model() / "cmudict-en-us.dict")


def pocketsphinx_model() -> Path:
    """The folder of pocketsphinx's English model, found without loading its library.

    Raises
    ------
    MissingPartError
        If it is not installed.
    """
    package = find_spec("pocketsphinx")
    if package is None or package.origin is None:
        raise MissingPartError("pocketsphinx is not installed: pip install pocketsphinx")
    return Path(package.origin).parent / "model" / "en-us"


def dictionary_entries() -> list[tuple[str, Pronunciation]]:
    """All headwords with their first pronunciation."""
    return [(word, tuple(phones.split())) for word, phones in _dictionary().entries() if "(" not in word]


def in_dictionary(word: str) -> bool:
    """Whether the dictionary holds a word as it is.

    Examples
    --------
    >>> in_dictionary("seven"), in_dictionary("sevenish")
    (True, False)
    """
    return bool(_listed(word.lower()))


def pronounce(word: str) -> Pronunciation:
    """The most usual pronunciation of one spoken word.

    Parameters
    ----------
    word : str
        Letters a-z and apostrophes, as `mien.text.normalisation.spoken_words` gives them; ``"b."`` is a letter's name.

    Returns
    -------
    tuple of str
        ARPAbet phones without stress; at least one.

    Raises
    ------
    InputError
        If the word holds no letter from a to z.

    Examples
    --------
    >>> pronounce("seven")
    ('S', 'EH', 'V', 'AH', 'N')
    >>> pronounce("blorked")
    ('B', 'L', 'AO', 'R', 'K', 'T')
    """
    return pronunciations(word)[0]


@lru_cache(maxsize=4096)
def pronunciations(word: str) -> tuple[Pronunciation, ...]:
    """All pronunciations of one word that the dictionary knows, the most usual first; at least one.

    Examples
    --------
    >>> pronunciations("either")
    (('IY', 'DH', 'ER'), ('AY', 'DH', 'ER'))
    """
    word = word.lower()
    if not any("a" <= char <= "z" for char in word):
        raise InputError(f"expected a word in the letters a to z, got {word!r}")
    return _listed(word) or _inflected(word) or _compound(word) or (_by_letters(word),)


def _listed(word: str) -> tuple[Pronunciation, ...]:
    return tuple(dict.fromkeys(tuple(phones.split()) for phones in _dictionary()[word]))


def _by_letters(word: str) -> Pronunciation:
    from mien.text.letter_to_sound import phones_of_letters

    letters = "".join(char for char in word if "a" <= char <= "z")
    if not any(char in "aeiouy" for char in letters) or len(letters) == 1:
        return tuple(phone for letter in letters for phone in _listed(f"{letter}.")[0])
    return phones_of_letters(letters)


def _inflected(word: str) -> tuple[Pronunciation, ...]:
    """A known word with an ending: possessive, plural, past, -ing, -er and the like."""
    for ending, stems in _stems(word):
        for stem in stems:
            if known := _listed(stem):
                return tuple(_with_ending(phones, ending) for phones in known)
    return ()


def _stems(word: str) -> list[tuple[str, list[str]]]:
    bare = word.replace("'", "")
    cases: list[tuple[str, list[str]]] = []
    if word.endswith("'s"):
        cases.append(("s", [word[:-2], word[:-2] + "."]))
    if word.endswith(("s'", "'")):
        cases.append(("", [word.rstrip("'")]))
    if word.endswith("'ll"):
        cases.append(("ll", [word[:-3]]))
    if word.endswith("'d"):
        cases.append(("ed", [word[:-2]]))
    if word.endswith("'ve"):
        cases.append(("ve", [word[:-3]]))
    if word.endswith("in'"):
        cases.append(("in", [word[:-3], word[:-3] + "e"]))
    if len(bare) > 3 and bare.endswith("s") and not bare.endswith("ss"):
        cases.append(("s", [bare[:-1], bare[:-2] if bare.endswith("es") else "", _y_for_i(bare, "ies")]))
    for ending in ("ed", "ing", "er", "ness", "less", "ful", "ly", "ish", "able"):
        if len(bare) > len(ending) + 2 and bare.endswith(ending):
            root = bare[: -len(ending)]
            undoubled = root[:-1] if len(root) > 2 and root[-1] == root[-2] else ""
            vowel_ending = ending[0] in "aeiou"
            roots = [root, root + "e" if vowel_ending else "", undoubled if vowel_ending else ""]
            cases.append((ending, [*roots, _y_for_i(bare, "i" + ending)]))
    return [(ending, [stem for stem in stems if len(stem) > 1]) for ending, stems in cases]


def _y_for_i(word: str, ending: str) -> str:
    return word[: -len(ending)] + "y" if word.endswith(ending) else ""


_ENDINGS: dict[str, Pronunciation] = {
    "": (),
    "in": ("AH", "N"),
    "ing": ("IH", "NG"),
    "er": ("ER",),
    "ness": ("N", "AH", "S"),
    "less": ("L", "AH", "S"),
    "ful": ("F", "AH", "L"),
    "ly": ("L", "IY"),
    "ish": ("IH", "SH"),
    "able": ("AH", "B", "AH", "L"),
}


def _with_ending(phones: Pronunciation, ending: str) -> Pronunciation:
    last = phones[-1]
    voiced = last in phone_table() and phone_table()[last].voiced
    if ending == "s":
        return phones + (("IH", "Z") if last in _SIBILANTS else ("Z",) if voiced else ("S",))
    if ending == "ed":
        return phones + (("IH", "D") if last in ("T", "D") else ("D",) if voiced else ("T",))
    if ending in ("ll", "ve"):
        final = "L" if ending == "ll" else "V"
        return phones + ((final,) if is_vowel(last) else ("AH", final))
    return phones + _ENDINGS[ending]


def _compound(word: str) -> tuple[Pronunciation, ...]:
    """Two known words written as one, cut where the shorter of the two is longest."""
    bare = word.replace("'", "")
    cuts = sorted(range(_SHORTEST_PART, len(bare) - _SHORTEST_PART + 1), key=lambda cut: abs(2 * cut - len(bare)))
    for cut in cuts:
        first, second = _listed(bare[:cut]), _listed(bare[cut:])
        if first and second:
            return (first[0] + second[0],)
    return ()
