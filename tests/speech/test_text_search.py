"""The search through a text: against the plain recursion, with stretches settled on the way, and with other speech."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.core.utterance import PAUSE
from mien.speech import text_search
from mien.speech.text_search import OTHER, OTHER_ROW, OTHER_START, SHORTEST, Found, TextGraph, search

LABELS = (PAUSE, "A", "B", "C", "D")


def with_other(heard: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.concatenate([heard, heard.max(axis=1, keepdims=True) - np.float32(OTHER_ROW)], axis=1)


def plain_best(heard: NDArray[np.float32], graph: TextGraph) -> float:
    """Score of the best way, every phone and stage followed."""
    scores = np.full((SHORTEST, len(graph.labels)), -np.inf)
    for number, row in enumerate(with_other(heard)):
        new = np.full_like(scores, -np.inf)
        for phone, label in enumerate(graph.labels):
            before = [scores[-1, p] for p in graph.before[phone] if p >= 0 and number]
            enter = 0.0 if graph.starts[phone] and not number else max(before, default=-np.inf)
            new[:, phone] = [enter - (OTHER_START if label == OTHER else 0), *scores[:-1, phone]]
            new[-1, phone] = max(new[-1, phone], scores[-1, phone])
            new[:, phone] += row[graph.columns[phone]]
        scores = new
    return float(scores[-1, graph.ends].max())


def score(heard: NDArray[np.float32], found: list[Found]) -> float:
    rows = with_other(heard)
    index = {label: number for number, label in enumerate((*LABELS, OTHER))}
    assert found[0].first == 0
    assert found[-1].last == len(heard)
    assert all(a.last == b.first for a, b in pairwise(found))
    assert all(part.last - part.first >= SHORTEST for part in found)
    return sum(
        float(rows[part.first : part.last, index[part.label]].sum()) - (OTHER_START if part.label == OTHER else 0)
        for part in found
    )


@pytest.mark.parametrize("seed", range(4))
def test_the_way_is_the_best_one_and_says_the_text(seed: int) -> None:
    random = np.random.default_rng(seed)
    choices = [[tuple(random.choice(LABELS[1:], random.integers(1, 4))) for _ in range(2)] for _ in range(3)]
    graph = TextGraph(choices, LABELS)
    heard = random.normal(0, 2, (60, len(LABELS))).astype(np.float32)
    found = search(heard, graph)
    assert found is not None
    assert score(heard, found) == pytest.approx(plain_best(heard, graph), abs=1e-3)
    for number, pronunciations in enumerate(choices):
        assert tuple(part.label for part in found if part.word == number) in pronunciations


def spoken(phones: str, rows: int = 6) -> NDArray[np.float32]:
    """Rows in which one label after another is certain."""
    heard = np.full((len(phones) * rows, len(LABELS)), -6.0, np.float32)
    for place, phone in enumerate(phones):
        heard[place * rows : (place + 1) * rows, LABELS.index(PAUSE if phone == "." else phone)] = 0.0
    return heard


def test_what_is_settled_on_the_way_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    said = ".ABCD.DCBA.ABDC." * 8
    heard = spoken(said) + np.random.default_rng(1).normal(0, 0.5, (6 * len(said), len(LABELS))).astype(np.float32)
    graph = TextGraph([[tuple(word)] for word in said.split(".") if word], LABELS)
    whole = search(heard, graph)
    monkeypatch.setattr(text_search, "_SETTLE", 90)
    assert search(heard, graph) == whole
    assert whole is not None
    assert [part.label for part in whole] == [PAUSE if phone == "." else phone for phone in said.replace("..", ".")]


def test_words_that_the_text_does_not_have_leave_the_others_in_place() -> None:
    found = search(spoken(".ABC.DADADA.CBA."), TextGraph([[("A", "B", "C")], [("C", "B", "A")]], LABELS))
    assert found is not None
    (other,) = [part for part in found if part.label == OTHER]
    assert abs(other.first - 30) <= 6
    assert abs(other.last - 66) <= 6
    assert [part.first for part in found if part.label == "C"] == [18, 72]


def test_a_text_that_is_not_said_has_a_way_where_all_are_followed() -> None:
    heard, graph = spoken("DDDDDDDDAB"), TextGraph([[("A", "B", "C")]] * 5, LABELS)
    assert search(heard, graph, beam=20.0) is None
    found = search(heard, graph, beam=float("inf"))
    assert found is not None
    assert {part.word for part in found} >= set(range(5))


def test_too_many_words_have_no_way() -> None:
    assert search(spoken("AB"), TextGraph([[("A", "B")]] * 3, LABELS)) is None
