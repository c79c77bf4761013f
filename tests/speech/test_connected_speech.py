"""Words that change where they meet are found as they are said, and as they are written where they do not."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.utterance import PAUSE
from mien.speech.text_search import TextGraph, search
from mien.text.phones import phone_table

LABELS = (PAUSE, *phone_table())
HAD_YOUR = [[("HH", "AE", "D")], [("Y", "AO", "R")]]
LAST_YEAR = [[("L", "AE", "S", "T")], [("Y", "IH", "R")]]


def found_in(said: str, choices: list[list[tuple[str, ...]]], connected: bool = True) -> list[tuple[str, int]]:
    """Phones and words on the best way through rows in which one label after another is nearly certain."""
    heard = np.full((6 * len(said.split()), len(LABELS)), -6.0, np.float32)
    for place, phone in enumerate(said.split()):
        heard[6 * place : 6 * place + 6, LABELS.index(PAUSE if phone == "." else phone)] = 0.0
    found = search(heard, TextGraph(choices, LABELS, connected))
    assert found is not None
    return [(part.label, part.word) for part in found if part.word >= 0]


@pytest.mark.parametrize("said", ["HH AE JH AO R", "HH AE D Y AO R", "HH AE D . Y AO R"])
def test_coalescence_is_heard_where_it_is_said(said: str) -> None:
    phones = found_in(said, HAD_YOUR)
    assert [label for label, _ in phones] == said.replace(". ", "").split()
    assert [word for _, word in phones] == sorted(word for _, word in phones)
    assert {word for _, word in phones} == {0, 1}


@pytest.mark.parametrize("said", ["L AE S Y IH R", "L AE S T Y IH R", "L AE S CH IH R"])
def test_a_final_stop_may_be_left_out_between_consonants(said: str) -> None:
    assert [label for label, _ in found_in(said, LAST_YEAR)] == said.split()


def test_without_connection_words_are_as_they_are_written() -> None:
    found = found_in("HH AE JH AO R", HAD_YOUR, connected=False)
    assert [label for label, _ in found] == [
        "HH",
        "AE",
        "D",
        "Y",
        "AO",
        "R",
    ]


def test_a_final_stop_after_a_vowel_stays() -> None:
    assert [label for label, _ in found_in("HH AE Y AO R", [[("HH", "AE", "T")], [("L", "AO", "R")]])] == (
        ["HH", "AE", "T", "L", "AO", "R"]
    )
