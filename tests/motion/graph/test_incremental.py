from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.motion.graph.candidates import GraphIndex
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.incremental import IncrementalSearch, search_ahead
from mien.motion.graph.search import search
from tests.motion.graph.graphs import recorded_question, small_graph, small_question, transition

TUNED = SearchWeights(jump=1.0, join=1.0, audio=0.5, duration=1.0)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(1, 12), weights=st.sampled_from([SearchWeights(), TUNED]))
def test_with_all_phones_ahead_it_is_the_cheapest(seed, length, weights):
    graph = small_graph(seed, [10] * 6, ["AA", "M", "T"])
    index, asked = GraphIndex(graph), small_question(seed, length, ["AA", "M", "T"])
    best = search(index, asked, weights).cost.total
    assert search_ahead(index, asked, weights, length).cost.total == pytest.approx(best, rel=1e-5)
    for look_ahead in (0, 1, 3):
        way = search_ahead(index, asked, weights, look_ahead)
        assert len(way.nodes) == length
        assert way.cost.total >= best * (1 - 1e-5)


def test_each_phone_is_settled_as_soon_as_enough_is_known():
    graph = small_graph(0, [20] * 5, ["AA", "M", "T"])
    arriving = IncrementalSearch(GraphIndex(graph), look_ahead=2)
    asked = recorded_question(graph, 4, 6)
    counts = [len(arriving.push(asked.part(k, k + 1))) for k in range(6)]
    assert counts == [0, 0, 1, 1, 1, 1]
    assert len(arriving.finish()) == 2
    assert arriving.finish() == ()


def test_phones_may_come_several_at_once():
    graph = small_graph(0, [20] * 5, ["AA", "M", "T"])
    index, asked = GraphIndex(graph), recorded_question(graph, 4, 9)
    arriving = IncrementalSearch(index, TUNED, 3)
    nodes = [*arriving.push(asked.part(0, 5)), *arriving.push(asked.part(5, 9)), *arriving.finish()]
    assert nodes == search_ahead(index, asked, TUNED, 3).nodes.tolist()


def test_without_look_ahead_each_step_is_the_cheapest_step():
    graph = small_graph(3, [20] * 5, ["AA", "M", "T"])
    index, asked = GraphIndex(graph), small_question(1, 8, ["AA", "M", "T"])
    weights = SearchWeights(1.0, 1.0, 0.0)
    nodes = search_ahead(index, asked, weights, 0).nodes
    for before, after in pairwise(nodes):
        same = np.flatnonzero(graph.phones == graph.phones[after])
        least = min(transition(graph, weights, before, node) for node in same)
        assert transition(graph, weights, before, after) == pytest.approx(least, rel=1e-6)


def test_a_new_utterance_begins_after_the_last():
    graph = small_graph(0, [20] * 5, ["AA", "M", "T"])
    index, asked = GraphIndex(graph), recorded_question(graph, 4, 6)
    arriving = IncrementalSearch(index, TUNED, 2)
    once = [*arriving.push(asked), *arriving.finish()]
    assert [*arriving.push(asked), *arriving.finish()] == once


def test_misuse_is_refused():
    graph = small_graph(0, [5], ["M"])
    with pytest.raises(InputError, match="from 0 up, not -1"):
        IncrementalSearch(GraphIndex(graph), look_ahead=-1)
    arriving = IncrementalSearch(GraphIndex(graph))
    arriving.push(small_question(0, 1, ["M"]))
    with pytest.raises(InputError, match="either every phone"):
        arriving.push(small_question(0, 1, ["M"], "happy"))
