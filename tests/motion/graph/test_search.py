"""The fast search against the plain programme, and both against the paper's own queue."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.motion.graph.candidates import GraphIndex
from mien.motion.graph.costs import SearchWeights, path_cost
from mien.motion.graph.plain_search import plain_search
from mien.motion.graph.search import search
from tests.motion.graph.graphs import plain_cost, priority_queue_search, recorded_question, small_graph, small_question

PAPER = SearchWeights()
TUNED = SearchWeights(jump=1.0, join=1.0, audio=0.5, duration=1.0)

weight = st.sampled_from([0.0, 1e-3, 0.1, 0.5, 1.0, 3.0, 100.0])
any_weights = st.builds(
    SearchWeights,
    jump=weight,
    join=weight,
    audio=weight,
    duration=weight,
    emotion=weight,
    pause_audio=st.sampled_from([0.0, 0.5, 1.0]),
    join_everywhere=st.booleans(),
    emotion_is_filter=st.booleans(),
)


def close(value, expected):
    return value == pytest.approx(expected, rel=2e-6, abs=2e-6)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    chains=st.lists(st.integers(1, 6), min_size=2, max_size=5),
    length=st.integers(1, 5),
    weights=any_weights,
)
def test_the_papers_queue_finds_the_same_cost(seed, chains, length, weights):
    graph = small_graph(seed, [*chains, 3], ["AA", "M", "T"])
    asked = small_question(seed + 1, length, [graph.symbols[phone] for phone in np.unique(graph.phones)])
    nodes, cost = priority_queue_search(graph, asked, weights)
    index = GraphIndex(graph)
    assert close(plain_search(index, asked, weights)[1], cost)
    way = search(index, asked, weights)
    assert close(way.cost.total, cost)
    assert close(plain_cost(graph, asked, weights, way.nodes), cost)
    assert close(plain_cost(graph, asked, weights, nodes), cost)


@settings(max_examples=120, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    chains=st.lists(st.integers(1, 40), min_size=1, max_size=25),
    alphabet=st.integers(2, 6),
    length=st.integers(1, 30),
    weights=any_weights,
    emotion=st.sampled_from([None, "neutral", "happy", "bored"]),
    recorded=st.booleans(),
    instants=st.booleans(),
)
def test_as_cheap_as_the_plain_programme(seed, chains, alphabet, length, weights, emotion, recorded, instants):
    graph = small_graph(seed, chains, ["AA", "M", "T", "SIL", "IY", "S"][:alphabet], ("neutral", "happy"), instants)
    if recorded and len(graph) > length:
        asked = recorded_question(graph, seed + 1, length)
    else:
        asked = small_question(seed + 1, length, ["AA", "M", "T", "SIL", "B", "NG"], emotion)
    index = GraphIndex(graph)
    nodes, cost = plain_search(index, asked, weights)
    way = search(index, asked, weights)
    assert close(way.cost.total, cost)
    assert close(path_cost(graph, asked, weights, nodes).total, cost)
    assert way.effort.weighed <= way.effort.left <= way.effort.heard <= way.effort.states


@pytest.mark.parametrize("weights", [PAPER, TUNED, SearchWeights(0.0, 1.0, 0.0), SearchWeights(0.0, 0.0, 1.0)])
def test_on_a_graph_of_thousands(weights):
    graph = small_graph(3, [20] * 150, ["AA", "M", "T", "SIL", "IY", "S"])
    index = GraphIndex(graph)
    for seed in range(3):
        asked = recorded_question(graph, seed, 30)
        assert close(search(index, asked, weights).cost.total, plain_search(index, asked, weights)[1])


def test_what_was_recorded_is_found_whole():
    graph = small_graph(5, [30] * 10, ["AA", "M", "T", "IY"])
    from mien.motion.graph.query import SpokenPhones

    first = 90
    nodes = range(first, first + 30)
    asked = SpokenPhones(
        tuple(graph.symbols[graph.phones[node]] for node in nodes),
        tuple(graph.features_of(node) for node in nodes),
        tuple(float(graph.durations[node]) for node in nodes),
    )
    way = search(GraphIndex(graph), asked)
    assert way.nodes.tolist() == list(nodes)
    assert way.cost.total == 0.0
    assert not way.jumps.any()
    assert way.substitutions == ()


def test_most_states_are_never_heard_with_the_papers_weights():
    graph = small_graph(7, [20] * 100, ["AA", "M", "T", "SIL", "IY", "S"])
    asked = recorded_question(graph, 2, 25)
    effort = search(GraphIndex(graph), asked).effort
    assert effort.heard < 0.1 * effort.states


def test_a_repeated_frame_of_jumps_is_counted_inside_one_take():
    """A pair of one take whose second is not the next node is a jump."""
    graph = small_graph(1, [6], ["M"])
    asked = small_question(0, 4, ["M"])
    way = search(GraphIndex(graph), asked, SearchWeights(0.0, 0.0, 1.0))
    jumps = [bool(b != a + 1) for a, b in zip(way.nodes[:-1], way.nodes[1:], strict=True)]
    assert way.jumps.tolist() == [False, *jumps]
    assert way.cost.jumps == sum(jumps)


def test_phones_that_were_not_recorded_are_stood_for():
    graph = small_graph(1, [20, 20], ["AA", "B", "T"], ("neutral", "happy"))
    index = GraphIndex(graph)
    way = search(index, small_question(0, 6, ["P"]))
    assert {(s.taken, s.reason) for s in way.substitutions} == {("B", "class")}
    assert [s.place for s in way.substitutions] == list(range(6))
    way = search(index, small_question(0, 3, ["NG"]))
    assert {(s.taken, s.reason) for s in way.substitutions} <= {("T", "articulation"), ("B", "articulation")}
    way = search(index, small_question(0, 3, ["T"], "sad"))
    assert {s.reason for s in way.substitutions} == {"emotion"}
    assert way.substitutions[0].phone == "T (sad)"


def test_the_emotion_is_a_filter_or_a_cost():
    graph = small_graph(2, [20] * 8, ["AA", "M", "T"], ("neutral", "happy"))
    index = GraphIndex(graph)
    asked = small_question(0, 12, ["AA", "M", "T"], "happy")
    filtered = search(index, asked)
    assert {graph.emotion_names[graph.emotions[node]] for node in filtered.nodes} == {"happy"}
    soft = [search(index, asked, SearchWeights(emotion=value, emotion_is_filter=False)) for value in (0.0, 1.0, 1e4)]
    counts = [way.cost.other_emotion for way in soft]
    assert counts[0] > 0
    assert counts[0] >= counts[1] >= counts[2] == 0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda index: search(index, small_question(0, 3, ["M"]).part(0, 0)), "no phone to search for"),
        (lambda index: search(index, small_question(0, 3, ["QQ"])), "unknown phone 'QQ'"),
        (lambda index: search(index, _with_coefficients(4)), "have 3 coefficients, those of phone 'M' 4"),
        (lambda index: SearchWeights(jump=-1.0), "'jump' is a number from 0 up, not -1.0"),
        (lambda index: SearchWeights(audio=float("nan")), "'audio' is a number from 0 up"),
        (lambda index: SearchWeights(pause_audio=2.0), "0..1"),
    ],
)
def test_what_cannot_be_searched_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make(GraphIndex(small_graph(1, [6], ["M", "AA"])))


def _with_coefficients(count):
    from mien.motion.graph.query import spoken_phones
    from tests.motion.graph.graphs import SOUND, speech

    return spoken_phones(*speech(np.random.default_rng(0), ["M"], count), SOUND)
