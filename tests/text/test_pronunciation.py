from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.text.letter_to_sound import phones_of_letters
from mien.text.normalisation import pronounce_text
from mien.text.phones import phone_table
from mien.text.pronunciation import (
    _dictionary,
    dictionary_entries,
    in_dictionary,
    pronounce,
    pronunciations,
)


def test_dictionary_words_come_first_with_their_alternatives() -> None:
    assert pronounce("seven") == ("S", "EH", "V", "AH", "N")
    assert pronunciations("the")[:2] == (("DH", "AH"), ("DH", "IY"))


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("selfies'", "S EH L F IY Z"),
        ("googled", "G UW G AH L D"),
        ("b.", "B IY"),
        ("a.", "EY"),
        ("v.'s", "V IY Z"),
        ("snowface", "S N OW F EY S"),
        ("bcd", "B IY S IY D IY"),
    ],
)
def test_unlisted_words_are_built_from_listed_ones(word: str, phones: str) -> None:
    assert " ".join(pronounce(word)) == phones


def test_endings_follow_the_sound_before_them() -> None:
    assert not in_dictionary("wugwugs")
    stem = pronounce("boombox")
    assert pronounce("boombox's") == (*stem, "IH", "Z")


def test_letters_to_sounds_handles_new_words() -> None:
    assert phones_of_letters("blork") == ("B", "L", "AO", "R", "K")
    assert phones_of_letters("shrandle") == ("SH", "R", "AE", "N", "D", "AH", "L")


def test_every_phone_of_the_dictionary_has_a_class() -> None:
    used = {phone for _, phones in dictionary_entries() for phone in phones}
    assert used == set(phone_table())


def test_a_word_without_letters_is_refused() -> None:
    with pytest.raises(InputError, match="letters a to z"):
        pronounce("'")


def test_a_text_comes_back_word_by_word() -> None:
    assert [word for word, _ in pronounce_text("Dr. No has 2 cats")] == ["doctor", "no", "has", "two", "cats"]


def test_every_word_of_the_dictionary_is_found_where_it_stands() -> None:
    import pocketsphinx

    text = Path(pocketsphinx.get_model_path("en-us/cmudict-en-us.dict")).read_text(encoding="utf-8")
    listed: dict[str, list[str]] = {}
    for line in text.splitlines():
        word, _, phones = line.partition(" ")
        listed.setdefault(word.partition("(")[0], []).append(phones)
    assert list(listed) == sorted(listed), "words are looked for by halves: they must stand in order"
    looked = _dictionary()
    some = [*list(listed)[:5], *list(listed)[::97], *list(listed)[-5:]]
    assert [looked[word] for word in some] == [listed[word] for word in some]
    assert [looked[word] for word in ("", "!", "aaaaaaab", "sevenish", "~")] == [[]] * 5
