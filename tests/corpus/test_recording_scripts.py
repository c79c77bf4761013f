from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.corpus.recording.scripts import LANGUAGES, read_script
from mien.text.normalisation import spoken_words
from mien.text.phones import phone_table
from mien.text.pronunciation import in_dictionary

sys.path.insert(0, str(Path(__file__).parent.parent.parent / "benchmarks"))

import script_coverage


@pytest.fixture(autouse=True)
def fewer_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """The likeliest pairs of words are enough here: a second instead of ten, and the same diphones are frequent."""
    monkeypatch.setattr(script_coverage, "NEIGHBOURS", 800)


def test_english_script_covers_the_frequent_diphones_in_under_sixty_sentences() -> None:
    lines = read_script("en")
    assert len(lines) < 60
    frequent = script_coverage.frequent_diphones()
    assert len(frequent) > 800  # 99 % of speech is not a handful
    held = script_coverage.english_diphones(lines)
    assert sum(diphone in held for diphone in frequent) >= 0.95 * len(frequent)


def test_english_script_has_every_phone_five_times_in_words_of_the_dictionary() -> None:
    lines = read_script("en")
    phones = Counter(phone for line in lines for phone in script_coverage.phones_of(line))
    assert set(phones) == set(phone_table())
    assert min(phones.values()) >= 5
    assert not [word.text for line in lines for word in spoken_words(line.text).words if not in_dictionary(word.text)]


def test_diphones_run_over_the_borders_of_words() -> None:
    held = script_coverage.english_diphones([read_script("en")[0]])  # "The quick ..."
    assert held["AH", "K"] >= 1
    shares = script_coverage.diphone_shares()
    assert sum(shares.values()) == pytest.approx(1.0)
    assert ("SIL", "DH") not in shares
    assert shares["AH", "N"] > 50 * shares["ZH", "UW"]


@pytest.mark.parametrize("language", LANGUAGES)
def test_sentences_can_be_read_in_one_breath(language: str) -> None:
    for line in read_script(language):
        assert 5 <= len(line.text.split()) <= 14, line.text
        assert line.text[0].isupper()
        assert line.text[-1] in ".?!"


def test_finnish_script_has_every_phone_short_and_every_vowel_long() -> None:
    spoken = [phone for line in read_script("fi") for phone in script_coverage.finnish_phones(line.text)]
    assert set("aeiouyäödhjklmnprstvŋ") <= {phone.rstrip(":") for phone in spoken}
    assert {f"{vowel}:" for vowel in "aeiouyäö"} <= set(spoken)


def test_own_script(tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    path.write_text("# comment\n\n  Hello   there. \nGood bye.\n", encoding="utf-8")
    assert [(line.number, line.label, line.text) for line in read_script(path=path)] == [
        (1, "001", "Hello there."),
        (2, "002", "Good bye."),
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"# nothing\n", "expected sentences to read, one a line"),
        (b"One.\nTwo.\nOne.\n", "sentences 1 and 3 are the same ('One.')"),
        (b"\x89PNG\x00\x00", "expected sentences to read in UTF-8"),
        (None, "no such file"),
    ],
)
def test_bad_scripts_are_refused(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "mine.txt"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_script(path=path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_unknown_language() -> None:
    with pytest.raises(InputError, match=r"unknown language 'f': .*known: en, fi"):
        read_script("f")
