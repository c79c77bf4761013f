from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.text.languages import find_language
from mien.text.languages.letter_rules import phones_of_letters, read_letters

FINNISH = find_language("fi")
assert FINNISH is not None


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("kuningas", "k u n i ŋː ɑ s"),
        ("kuningatar", "k u n i ŋː ɑ t ɑ r"),
        ("henki", "h e ŋ k i"),
        ("kunpa", "k u m p ɑ"),
        ("pappi", "p ɑ pː i"),
        ("papin", "p ɑ p i n"),
        ("öljyyn", "ø l j yː n"),
        ("hääyöaie", "h æː y ø ɑ i e"),
        ("shakki", "ʃ ɑ kː i"),
        ("yhteishenki", "y h t e i s h e ŋ k i"),
        ("taxi", "t ɑ k s i"),
        ("pizza", "p i t sː ɑ"),
        ("åbo", "oː b o"),
    ],
)
def test_words(word: str, phones: str) -> None:
    assert FINNISH is not None
    assert " ".join(phones_of_letters(word, FINNISH)) == phones


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("3. päivänä", "kolmas päivänä"),
        ("12 500 €", "kaksitoistatuhattaviisisataa euroa"),
        ("klo 15.30", "kello viisitoista kolmekymmentä"),
        ("klo 8.00", "kello kahdeksan"),
        ("-5 astetta", "miinus viisi astetta"),
        ("3,5 kg", "kolme pilkku viisi kilogrammaa"),
        ("WC ja C-vitamiini", "kaksoisvee see ja see vitamiini"),
        ("esim. ATK, jne.", "esimerkiksi aa tee koo ja niin edelleen"),
        ("1995 ja 2001", "tuhatyhdeksänsataayhdeksänkymmentäviisi ja kaksituhattayksi"),
        ("1000000", "yksi miljoona"),
        ("Se on 5.", "se on viisi"),
    ],
)
def test_numbers_and_short_forms(text: str, spoken: str) -> None:
    assert FINNISH is not None
    assert read_letters(text, FINNISH).spoken == spoken


def test_a_word_stands_for_its_place_in_the_text() -> None:
    assert FINNISH is not None
    said = read_letters("  Hei,\nklo 15!", FINNISH)
    assert [said.written[word.start : word.end] for word in said.words] == ["Hei", "klo", "15"]
    assert [word.pause for word in said.words] == [",", "", "!"]


def test_letters_that_finnish_lacks_are_told() -> None:
    assert FINNISH is not None
    said = read_letters("Zürich, señor 😀", FINNISH)
    assert said.spoken == "zyrich senor"
    assert [note.message for note in said.notes] == [
        "left out of the spoken text: 😀",
        "letters that Finnish lacks are read: 'ü' as 'y', 'ñ' as 'n'",
    ]


@pytest.mark.parametrize(("text", "message"), [("", "nothing in"), ("…!", "nothing in"), ("Привет", "another script")])
def test_what_cannot_be_read(text: str, message: str) -> None:
    assert FINNISH is not None
    with pytest.raises(InputError, match=message):
        read_letters(text, FINNISH)


@given(st.text(alphabet="abcdefghijklmnopqrstuvwxyzåäöšž 0123456789.,:;-!?%€'\"()\n", max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    assert FINNISH is not None
    try:
        said = read_letters(text, FINNISH)
    except InputError:
        assume(False)
    for word in said.words:
        assert word.phones
        assert all(FINNISH.segments(phone) for phone in word.phones)
        assert 0 <= word.start < word.end <= len(text)
