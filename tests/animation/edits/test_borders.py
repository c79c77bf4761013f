from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.animation.edits import BorderEdit, EditLayer, Place
from mien.animation.edits.borders import LEAST_PHONE, moved_borders, with_borders
from tests.animation.edits.layers import LINE, borders, say

BASE = say("i never said that")


def laid(*edits: BorderEdit, on=BASE):
    return with_borders(EditLayer(edits), on)


def test_a_border_goes_where_it_is_shifted_and_its_word_with_it():
    speech, lost, notes = laid(BorderEdit(Place("never", 1, 3), "end", 0.03))
    never, said = speech.words.intervals[1:3]
    assert never.end == said.start == pytest.approx(0.73)
    assert [phone.label for phone in speech.phones] == [phone.label for phone in BASE.phones]
    assert not lost
    assert not notes


def test_the_end_of_one_is_the_start_of_the_next():
    one = laid(BorderEdit(Place("never", 1, 1), "end", 0.02))[0]
    other = laid(BorderEdit(Place("never", 1, 2), "start", 0.02))[0]
    assert one == other


def test_a_border_stops_before_the_next_and_says_so():
    speech, _, notes = laid(BorderEdit(Place("never", 1, 0), "end", 3.0))
    assert speech.phones.intervals[3].duration == pytest.approx(LEAST_PHONE)
    assert "could not go +3.000 s" in notes[0].message


def test_the_ends_of_the_sound_stay():
    _, lost, _ = laid(BorderEdit(Place(None, 1, 0, True), "start", 0.1))
    assert "start of the sound" in lost[0].why


def test_native_phones_go_along():
    from dataclasses import replace

    speech = replace(BASE, native=BASE.phones)
    moved = laid(BorderEdit(Place("said", 1, 0), "end", 0.05), on=speech)[0]
    assert moved.native.intervals[6].end == pytest.approx(moved.phones.intervals[6].end)


def test_nothing_to_move_is_the_same_utterance():
    assert laid()[0] is BASE
    assert laid(BorderEdit(Place("never", 1, 0), "end", 0.0))[0] is BASE


@given(st.lists(borders, max_size=8), st.randoms(use_true_random=False))
def test_the_tier_stays_whole_and_the_order_does_not_matter(edits, random):
    base = say(LINE, 0.06)
    speech, _, _ = laid(*edits, on=base)
    phones = speech.phones.intervals
    assert all(a.end == b.start for a, b in pairwise(phones))
    assert (phones[0].start, phones[-1].end) == (base.phones.intervals[0].start, base.phones.intervals[-1].end)
    assert min(phone.duration for phone in phones) >= LEAST_PHONE - 1e-9
    assert [word.label for word in speech.words] == [word.label for word in base.words]
    shuffled = list(edits)
    random.shuffle(shuffled)
    again = laid(*shuffled, on=base)[0]
    assert np.allclose([p.start for p in again.phones], [p.start for p in phones], atol=1e-12)


@given(
    st.lists(st.floats(0.001, 0.3), min_size=2, max_size=12),
    st.dictionaries(st.integers(1, 11), st.floats(-2, 2), max_size=8),
)
def test_borders_that_are_not_moved_stay_unless_pushed_by_none(lengths, shifts):
    edges = np.r_[0.0, np.cumsum(lengths)]
    shifts = {border: shift for border, shift in shifts.items() if border < len(edges) - 1}
    moved = moved_borders(edges, shifts)
    assert all(moved[n] == edges[n] for n in range(len(edges)) if n not in shifts)
    assert (np.diff(moved) >= np.minimum(np.diff(edges), LEAST_PHONE) - 1e-9).all()
