"""Tables of languages: their phones exist, a new one is one file, and a damaged one is one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.text.languages import find_language, heard_as, in_english_phones, known_languages, native_tier
from mien.text.languages.language import Language
from mien.text.languages.reading import looks_like, note_on_language, read_in
from tests.programs import voice_or_skip


def language(tag: str) -> Language:
    found = find_language(tag)
    assert found is not None
    return found


@pytest.mark.parametrize("tag", known_languages())
def test_every_phone_of_a_table_has_shapes_that_exist(tag: str) -> None:
    mouth, table = HandMadeMouth(), language(tag)
    for sign in table._segments:
        for segment in table.segments(sign):
            assert mouth.visemes_of(segment.articulation)
            assert set(segment.shapes) <= set(mouth.visemes)


@pytest.mark.parametrize(("front", "others"), [("y", ("i", "u")), ("ø", ("e", "o")), ("æ", ("e", "ɑ"))])
def test_finnish_vowels_that_english_lacks_look_like_no_other(front: str, others: tuple[str, ...]) -> None:
    def shape(phone: str) -> tuple[str, ...]:
        segment = language("fi").segments(phone)[0]
        return segment.shapes or HandMadeMouth().visemes_of(segment.articulation)

    assert all(shape(front) != shape(other) for other in others)


def test_a_phone_in_no_table_is_cut_or_refused() -> None:
    assert [s.articulation for s in language("fi").segments("yø")] == ["UW", "UH"]
    with pytest.raises(InputError, match="the phone 'ǃ' is in none of its tables"):
        language("fi").segments("ǃ")


def test_phones_become_english_ones_and_keep_their_time() -> None:
    native = Tier(
        "phones",
        (Interval(0, 0.1, "SIL"), Interval(0.1, 0.3, "pf"), Interval(0.3, 0.6, "øː"), Interval(0.6, 0.7, "ʔ")),
    )
    phones, shapes = in_english_phones(native, language("de"))
    assert [(p.label, p.start, p.end) for p in phones] == [
        ("SIL", 0, 0.1),
        ("P", 0.1, pytest.approx(0.2)),
        ("F", pytest.approx(0.2), 0.3),
        ("UH", 0.3, 0.7),
    ]
    assert shapes == ((), (), (), ("front_round_mid",))


def test_aligned_phones_come_back_as_the_language_s_own() -> None:
    from mien.speech.aligned_phone import AlignedPhone

    german, words = language("de"), [("pf", "eː"), ("ʔ",)]
    assert [heard_as(word, german) for word in words] == [("P", "F", "EY"), ("AH",)]
    labels = [("SIL", -1), ("P", 0), ("F", 0), ("EY", 0), ("AH", 1), ("SIL", -1)]
    aligned = [AlignedPhone(label, i / 10, (i + 1) / 10, word, 0.0) for i, (label, word) in enumerate(labels)]
    tier = native_tier(aligned, words, german)
    assert [(p.label, p.start, p.end) for p in tier] == [
        ("SIL", 0.0, 0.1), ("pf", 0.1, 0.3), ("eː", 0.3, 0.4), ("SIL", 0.4, 0.5), ("SIL", 0.5, 0.6),
    ]  # fmt: skip


TABLE = 'tag = "et"\nname = "Estonian"\nreader = "letters"\n[letters]\n"õ" = ["ɤ"]\n"p" = ["p"]\n[numbers]\n'


def test_another_language_is_one_file(tmp_path: Path) -> None:
    file = tmp_path / "et.toml"
    file.write_text(TABLE, encoding="utf-8")
    estonian = find_language(file)
    assert estonian is not None
    assert read_in(estonian, "põp").words[0].phones == ("p", "ɤ", "p")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("tag =", "tug ="), "expected tag ="),
        (('"letters"', '"lettres"'), "did you mean 'letters'"),
        (("[letters]", "[letters"), "is not TOML"),
        (('"p" = ["p"]', '"p" = ["p"]\n[phones]\n"ɤ" = "AHH"'), "unknown English phone .*'AHH'"),
        (('"p" = ["p"]', '"p" = ["p"]\n[phones]\n"ɤ" = { az = "AH" }'), "expected an English phone"),
        (('reader = "letters"', 'reader = "espeak"'), "needs espeak ="),
    ],
)
def test_a_damaged_table_is_one_line(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    file = tmp_path / "et.toml"
    file.write_text(TABLE.replace(*change), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        find_language(file)


def test_a_missing_table(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        find_language(tmp_path / "no.toml")


@pytest.mark.parametrize(
    ("text", "tag"),
    [
        ("Der Lappen liegt auf dem Eisschrank.", "de"),
        ("Das schwarze Stück Papier befindet sich da oben neben dem Holzstück.", "de"),
        ("Hyvää päivää", "fi"),
        ("Minä en tiedä, mutta hän on siellä.", "fi"),
        ("¿Dónde está la biblioteca?", "es"),
        ("I never said that.", None),
        ("Die, villain! I was in the den.", None),
        ("She sells sea shells by the sea shore.", None),
        ("The café in Zürich is on the corner.", None),
        ("Bin blue at s three again", None),
        ("42", None),
    ],
)
def test_which_language_a_text_looks_like(text: str, tag: str | None) -> None:
    assert looks_like(text) == tag
    assert bool(note_on_language(text)) == (tag is not None)


def test_german_through_espeak() -> None:
    voice_or_skip("espeak-de")
    said = read_in(language("de"), "Schöne Grüße, z.B. 25!")
    assert [(word.text, word.pause) for word in said.words] == [
        ("schöne", ""), ("grüße", ","), ("zum", ""), ("beispiel", ""), ("fünfundzwanzig", "!"),
    ]  # fmt: skip
    assert said.words[0].phones == ("ʃ", "øː", "n", "ə")
