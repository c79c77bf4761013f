"""Every table of a language that comes with mien is whole: its own sentences are read, and known for what they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.text.languages import find_language, known_languages, read_in
from mien.text.languages.pinyin import with_tone_digits
from mien.text.languages.reading import looks_like

WANTED = {"fi", "de", "es", "fr", "it", "pt", "nl", "sv", "pl", "cs", "tr", "ru", "el", "zh", "ja"}
ENGLISH = Path(__file__).parents[3] / "benchmarks" / "voices_sentences.txt"


def test_the_languages_are_there() -> None:
    assert set(known_languages()) >= WANTED


@pytest.mark.parametrize("tag", sorted(WANTED))
def test_its_sentences_are_read_and_every_phone_is_known(tag: str) -> None:
    language = find_language(tag)
    assert language is not None
    sample = language.table["sample"]
    assert len(sample) >= 5
    for text in sample:
        words = read_in(language, text).words
        assert len(words) >= 2
        assert all(language.segments(phone) is not None for word in words for phone in word.phones or ())


@pytest.mark.parametrize("tag", sorted(WANTED - {"zh"}))
def test_a_text_is_known_by_its_small_words_and_letters(tag: str) -> None:
    language = find_language(tag)
    assert language is not None
    assert looks_like(" ".join(language.table["sample"])) == tag


def test_english_is_taken_for_none_of_them() -> None:
    assert [line for line in ENGLISH.read_text(encoding="utf-8").splitlines() if looks_like(line)] == []


def test_marks_of_tone_and_digits_read_alike() -> None:
    mandarin = find_language("zh")
    assert mandarin is not None
    marked, digits = (read_in(mandarin, text).words for text in ("nǐ hǎo, xuéxiào", "ni3 hao3, xue2xiao4"))
    assert [word.phones for word in marked] == [word.phones for word in digits]
    assert with_tone_digits("pizza") == "pizza"


def test_kanji_are_refused_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.text.languages.segmenting.find_spec", lambda name: None)
    japanese = find_language("ja")
    assert japanese is not None
    with pytest.raises(InputError, match="write kanji in kana"):
        read_in(japanese, "今日は")
