from mien.animation.edits.edited_line import LineWord, line_of, matched_phones, matched_words
from tests.animation.edits.layers import say, spoken


def test_phones_go_to_the_words_in_which_they_lie():
    line = line_of(spoken(0.2, ("no", ("N", "OW"), 0.1), 0.1, ("way", ("W", "EY"), 0.05), 0.2))
    assert line.line == (
        LineWord(None, (), ("SIL",)),
        LineWord("no", ("N", "OW"), ("SIL",)),
        LineWord("way", ("W", "EY"), ("SIL",)),
    )
    assert line.phones == ((), (1, 2), (4, 5))
    assert line.pauses == ((0,), (3,), (6,))


def test_a_take_without_words_is_all_before_the_first():
    line = line_of(spoken(0.2, 0.3))
    assert line.line == (LineWord(None, (), ("SIL", "SIL")),)


def test_every_phone_of_a_line_has_one_place():
    line = line_of(say("i never said that i never said"))
    held = [p for group in (*line.phones, *line.pauses) for p in group]
    assert sorted(held) == list(range(len(held)))


def words(text: str) -> tuple[LineWord, ...]:
    return (LineWord(None), *map(LineWord, text.split()))


def test_a_word_put_in_front_does_not_take_the_edits_of_its_namesake():
    assert matched_words(words("say never"), words("never say never")) == {0: 0, 1: 2, 2: 3}


def test_the_middle_of_a_repetition_can_go():
    found = matched_words(words("he said that she said this"), words("he said this"))
    assert found[1] == 1
    assert found[6] == 3


def test_nothing_in_common():
    assert matched_words(words("yes"), words("no no")) == {0: 0}


def test_a_phone_that_changed_in_its_place_is_the_same_one():
    assert matched_phones(("T", "AH", "M"), ("T", "UW", "M")) == {0: 0, 1: 1, 2: 2}
    assert matched_phones(("S", "EH", "D"), ("S", "D")) == {0: 0, 2: 1}
