from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import pronounce
from mien.text.spoken_numbers import cardinal, ordinal

SPOKEN = [
    ("Dr. Smith met Mrs. Jones.", "doctor smith met missus jones"),
    ("$3.50, £20 and €1.5 million", "three dollars fifty cents twenty pounds and one point five million euros"),
    ("$1, $0.99, $2bn", "one dollar ninety nine cents two billion dollars"),
    ("on March 5, 2024", "on march fifth twenty twenty four"),
    ("2024-03-05", "march fifth twenty twenty four"),
    ("9/11/2001", "september eleventh two thousand one"),
    ("at 3:45 p.m.", "at three forty five p. m."),
    ("at 10:05", "at ten oh five"),
    ("at 5:00", "at five o'clock"),
    ("in 1984", "in nineteen eighty four"),
    ("1999-2005", "nineteen ninety nine to two thousand five"),
    ("the 1990s", "the nineteen nineties"),
    ("the '80s", "the eighties"),
    ("the 3rd of 21st", "the third of twenty first"),
    ("2,000 people", "two thousand people"),
    ("2.05 miles", "two point zero five miles"),
    ("12 kg, 1 km, 100 km/h", "twelve kilograms one kilometer one hundred kilometers per hour"),
    ("-5 °C", "minus five degrees celsius"),
    ("50% & more", "fifty percent and more"),
    ("1/2 cup and 2½", "one half cup and two and one half"),
    ("call 555-1234", "call five five five one two three four"),
    ("joe@example.com", "joe at example dot com"),
    ("https://www.example.com/a", "example dot com slash a"),
    ("St. John lives on Elm St.", "saint john lives on elm street"),
    ("the FBX of NASA", "the f. b. x. of nasa"),
    ("the U.S. team", "the u. s. team"),
    ("Henry VIII, chapter IV", "henry the eighth chapter four"),
    ("#1 hit", "number one hit"),
    ("No. 5", "number five"),
    ("state-of-the-art", "state of the art"),
    ("it’s y'all's", "it's y'all's"),
    ("Café naïve Zoë", "cafe naive zoe"),
    ("IT IS A NICE DAY", "it is a nice day"),
    ("It says IT here", "it says i. t. here"),
    ("5'10\" tall", "five foot ten tall"),
]


@pytest.mark.parametrize(("written", "spoken"), SPOKEN)
def test_reads_ordinary_writing(written: str, spoken: str) -> None:
    assert spoken_words(written).spoken == spoken


def test_each_word_knows_the_characters_it_stands_for() -> None:
    text = "Well, Dr. Smith paid $3.50 today."
    found = [(word.text, text[word.start : word.end]) for word in spoken_words(text).words]
    assert found[:3] == [("well", "Well"), ("doctor", "Dr."), ("smith", "Smith")]
    assert {written for word, written in found if word in ("three", "dollars", "fifty", "cents")} == {"$3.50"}
    assert spoken_words(text).written_for(1, 3) == "Dr. Smith paid"


def test_punctuation_becomes_pauses() -> None:
    words = spoken_words("Well - no, wait! Is it well-known (here)? Yes.").words
    assert [(word.text, word.pause) for word in words if word.pause] == [
        ("well", "-"),
        ("no", ","),
        ("wait", "!"),
        ("known", ","),
        ("here", "?"),
        ("yes", "."),
    ]


def test_a_closing_abbreviation_ends_the_sentence() -> None:
    assert spoken_words("It was 3 p.m.").words[-1].pause == "."


def test_emoji_are_left_out_with_one_note() -> None:
    spoken = spoken_words("Hello 😀 there 👍🏽!")
    assert spoken.spoken == "hello there"
    assert len(spoken.notes) == 1
    assert spoken.notes[0].kind == "note"
    assert "😀" in spoken.notes[0].message


@pytest.mark.parametrize("text", ["", "  \n", "...", "😀", "?!"])
def test_nothing_to_say_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="at least one word"):
        spoken_words(text)


@pytest.mark.parametrize(
    ("text", "word", "script"),
    [("Привет мир", "Привет", "Cyrillic"), ("say 你好 now", "你好", "Chinese"), ("ok مرحبا", "مرحبا", "Arabic")],
)
def test_other_scripts_are_refused_by_name(text: str, word: str, script: str) -> None:
    with pytest.raises(InputError) as refused:
        spoken_words(text)
    assert repr(word) in str(refused.value)
    assert script in str(refused.value)


@given(st.text(alphabet=st.characters(codec="latin-1"), max_size=40))
def test_any_latin_text_is_spoken_or_refused_in_one_line(text: str) -> None:
    try:
        spoken = spoken_words(text)
    except InputError as refused:
        message = str(refused)
        spoken = None
    if spoken is None:
        assert "\n" not in message
        return
    for word in spoken.words:
        assert 0 <= word.start < word.end <= len(text)
        assert pronounce(word.text)


@given(st.integers(0, 10**17))
def test_cardinals_and_ordinals_end_alike(number: int) -> None:
    head = cardinal(number).rpartition(" ")[0]
    assert ordinal(number).rpartition(" ")[0] == head


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("50-60 people", "fifty to sixty people"),
        ("a 50-60% chance", "a fifty to sixty percent chance"),
        ("pages 3–5", "pages three to five"),
        ("Boeing 747-400", "boeing seven hundred forty seven four hundred"),
        ("3-2-1", "three two one"),
        ("a 10-year-old", "a ten year old"),
        ("1999-2001", "nineteen ninety nine to two thousand one"),
        ("555-1234", "five five five one two three four"),
    ],
)
def test_ranges_of_numbers(text: str, spoken: str) -> None:
    assert spoken_words(text).spoken == spoken


@pytest.mark.parametrize(
    ("text", "phones"),
    [
        ("He read it.", "R EH D"),
        ("Read it!", "R IY D"),
        ("You should read it.", "R IY D"),
        ("I have read.", "R EH D"),
        ("Live music", "L AY V"),
        ("I live here.", "L IH V"),
        ("The wind blows.", "W IH N D"),
        ("A lead pipe", "L EH D"),
    ],
)
def test_words_written_alike(text: str, phones: str) -> None:
    said = [word.phones for word in spoken_words(text).words if word.phones is not None]
    assert said == [tuple(phones.split())]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("24/7", "twenty four seven"),
        ("a 50/50 chance", "a fifty fifty chance"),
        ("3/4 of it", "three quarters of it"),
        ("1.5M users", "one point five million users"),
        ("2k", "two thousand"),
        ("5 km/h", "five kilometers per hour"),
        ("10:30am, 7:05pm, MP3s", "ten thirty a. m. seven oh five p. m. m. p. threes"),
        ("00:00", "midnight"),
        ("00:15", "zero fifteen"),
        ("7 pm", "seven p. m."),
        ("AT&T and R&D", "a. t. and t. and r. and d."),
        ("call 911", "call nine one one"),
        ("911.5 kg", "nine hundred eleven point five kilograms"),
        ("CA 90210", "ca nine oh two one oh"),
        ("C#, C++", "c. sharp c. plus plus"),
        ("5¢", "five cents"),
        ("the 80's and 1990s", "the eighties and nineteen nineties"),
        ("30.11.2026", "november thirtieth twenty twenty six"),
        ("2026-11-30T12:00Z", "november thirtieth twenty twenty six at twelve o'clock u. t. c."),
        ("192.168.0.1", "one nine two dot one six eight dot zero dot one"),
        ("version 3.11.7", "version three point eleven point seven"),
        ("'µ and 'π", "micro and pi"),
        ("WWII", "world war two"),
        ("a JPEG", "a jay peg"),
        ("I, II and III", "one two and three"),
        ("Types I, II, and III", "types one two and three"),
        ("Henry VII and VIII", "henry the seventh and the eighth"),
        ("Louis XIV and I went", "louis the fourteenth and i went"),
        ("Act V, Scene I", "act five scene one"),
        ("Part I. Then I and you", "part one then i and you"),
        ("10^6, 5^2", "ten to the six five squared"),
        ("24/7/365", "twenty four seven three sixty five"),
        ("a 4K film, $4K", "a four k. film four thousand dollars"),
        ("N/A", "n. a."),
        ("x ≠ 3 kg/m²", "x is not equal to three kilograms per square meter"),
        ("i. First\n(iv) last", "one first four last"),
        ("I. Introduction", "one introduction"),
        ("It was I.", "it was i"),
        ("ﬁne ﬂow of oﬃce work", "fine flow of office work"),
        ("𝐇𝐞𝐥𝐥𝐨 ①", "hello one"),
    ],
)
def test_what_people_write_is_read_as_they_say_it(written: str, said: str) -> None:
    assert spoken_words(written).spoken == said


@pytest.mark.parametrize(
    ("sentence", "word", "phones"),
    [
        ("I read it yesterday.", "read", "R EH D"),
        ("I will read it.", "read", "R IY D"),
        ("Did you read it?", "read", "R IY D"),
        ("She read the letter.", "read", "R EH D"),
        ("I have read it.", "read", "R EH D"),
        ("Read it. I saw him yesterday.", "read", "R IY D"),
        ("Wind the clock.", "wind", "W AY N D"),
        ("The wind blew.", "wind", "W IH N D"),
        ("Don't tear it.", "tear", "T EH R"),
        ("A tear fell.", "tear", "T IH R"),
        ("Record the song.", "record", "R IH K AO R D"),
        ("The record broke.", "record", "R EH K ER D"),
        ("It is of no use.", "use", "Y UW S"),
        ("Use it.", "use", "Y UW Z"),
        ("They live here.", "live", "L IH V"),
        ("A live show.", "live", "L AY V"),
        ("Lead pipes are old.", "lead", "L EH D"),
        ("They lead the way.", "lead", "L IY D"),
        ("Stay close to me.", "close", "K L OW S"),
        ("Close the door.", "close", "K L OW Z"),
    ],
)
def test_words_written_alike_are_told_apart(sentence: str, word: str, phones: str) -> None:
    (said,) = [found for found in spoken_words(sentence).words if found.text == word]
    assert said.phones == tuple(phones.split())


@pytest.mark.parametrize(
    ("written", "said", "noted"),
    [
        ("[door slams] Who is there?", "who is there", "door slams"),
        ("Well (sighs) that is that.", "well that is that", "sighs"),
        ("(very quietly) Go.", "go", "very quietly"),
        ("*laughs* No.", "no", "laughs"),
        ("I *really* mean it (see below).", "i really mean it see below", ""),
        ("It is late (the pause was long).", "it is late the pause was long", ""),
        ("ANNA: Hello.", "hello", "ANNA"),
        ("Anna: Hello.\nBob: Hi.\nAnna: Bye.", "hello hi bye", "Anna, Bob"),
        ("Anna: hello.", "anna hello", ""),
        ("NOTE: read this.\nTip: and this.", "note read this tip and this", ""),
    ],
)
def test_directions_and_names_are_not_spoken_and_named_in_a_note(written: str, said: str, noted: str) -> None:
    text = spoken_words(written)
    assert text.spoken == said
    assert [noted in note.message for note in text.notes] == ([True] if noted else [])


@pytest.mark.parametrize(
    ("written", "said", "names"),
    [
        ("(sighs) BOB: No.", "no", "BOB"),
        ("[a very long roll of thunder] BOB: No.", "no", "BOB"),
        ("NARRATOR (quietly): It rained.\n(laughs) Anna: Yes.", "it rained yes", "NARRATOR, Anna"),
        ("He said (quietly): no.", "he said no", ""),
    ],
)
def test_directions_may_stand_about_a_speakers_name(written: str, said: str, names: str) -> None:
    text = spoken_words(written)
    assert text.spoken == said
    found = [note.message.rpartition("speaker: ")[2] for note in text.notes if "speaker: " in note.message]
    assert found == ([names] if names else [])


def test_places_in_the_written_text_are_kept() -> None:
    written = "ANNA: (sighs) The ﬁne [bang] line."
    text = spoken_words(written)
    assert [written[word.start : word.end] for word in text.words] == ["The", "ﬁne", "line"]
    assert text.words[-1].pause == "."
