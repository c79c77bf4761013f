from itertools import pairwise

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph, frame_spans, without_gaps

FAST, SLOW = FrameRate.of(100), FrameRate.of(25)


def tier(*phones):
    return Tier("phones", tuple(Interval(*phone) for phone in phones))


def take(name="one", phones=None, motion=None, **changes):
    phones = phones or tier((0.0, 0.2, "SIL"), (0.2, 0.32, "M"), (0.32, 0.6, "AY"))
    values = {
        "name": name,
        "phones": phones,
        "emotion": "neutral",
        "features": np.arange(60.0 * 9).reshape(60, 9),
        "feature_rate": FAST,
        "motion": np.arange(15.0 * 2).reshape(15, 2) if motion is None else motion,
        "motion_rate": SLOW,
    }
    return RecordedChain(**(values | changes))


def test_nodes_hold_what_sounds_and_moves_in_their_time():
    graph = build_graph([take()], markers=4)
    assert [graph.symbols[p] for p in graph.phones] == ["SIL", "M", "AY"]
    assert graph.feature_counts.tolist() == [20, 12, 28]
    assert graph.features_of(1)[:, 0].tolist() == [9.0 * k for k in range(20, 32)]
    assert graph.motion_of(1)[:, 0].tolist() == [10.0, 12.0, 14.0]
    assert graph.entries[1].tolist() == [10.0, 11.0]
    assert graph.exits[1].tolist() == [14.0, 15.0]
    assert graph.follows.tolist() == [False, True, True]


def test_read_at_instants_recorded_neighbours_meet():
    graph = build_graph([take()], markers=4, instants=True)
    assert np.allclose(graph.exits[:-1], graph.entries[1:])
    assert np.allclose(graph.entries[1], [10.0, 11.0])  # 0.2 s is frame 5
    assert np.allclose(graph.entries[2], [16.0, 17.0])  # 0.32 s is frame 8


def test_takes_are_chains_of_their_own():
    graph = build_graph([take("one"), take("two", emotion="angry")], markers=4)
    assert graph.chains.tolist() == [0, 0, 0, 1, 1, 1]
    assert graph.follows.tolist() == [False, True, True, False, True, True]
    assert [graph.emotion_names[e] for e in graph.emotions] == ["neutral"] * 3 + ["angry"] * 3
    assert np.array_equal(graph.motion_of(4), graph.motion_of(1))
    assert graph.take_motion.tolist() == [0, 15, 30]


def test_a_gap_is_a_pause():
    assert [p.label for p in without_gaps(tier((0, 0.1, "M"), (0.2, 0.3, "AY")))] == ["M", "SIL", "AY"]
    graph = build_graph([take(phones=tier((0.0, 0.2, "M"), (0.3, 0.6, "AY")))], markers=4)
    assert [graph.symbols[p] for p in graph.phones] == ["M", "SIL", "AY"]


@pytest.mark.parametrize("instants", [False, True])
def test_a_lost_frame_breaks_the_chain(instants):
    motion = np.arange(30.0).reshape(15, 2)
    motion[6] = np.nan  # 0.24 s: in M
    graph = build_graph([take(motion=motion), take("two")], markers=4, instants=instants)
    assert [graph.symbols[p] for p in graph.phones] == ["SIL", "AY", "SIL", "M", "AY"]
    assert graph.chains.tolist() == [0, 1, 2, 2, 2]
    assert graph.take_of.tolist() == [0, 0, 1, 1, 1]
    assert np.isfinite(graph.entries).all()
    assert np.isfinite(graph.exits).all()


def test_a_phone_outside_the_frames_takes_the_nearest():
    spans = frame_spans(tier((0.0, 0.1, "M"), (5.0, 5.1, "AY")), SLOW, 10)
    assert spans.tolist() == [[0, 3], [9, 1]]


def test_frames_between_neighbours_are_shared_out_without_overlap():
    random = np.random.default_rng(0)
    times = np.concatenate([[0.0], np.sort(random.uniform(0.0, 3.0, 30)).round(3), [3.0]])
    phones = tier(*((a, b, "M") for a, b in pairwise(times)))
    for rate in (SLOW, FAST, FrameRate.of(29.97)):
        spans = frame_spans(phones, rate, rate.frames_covering(3.0))
        assert (spans[:, 1] >= 1).all()
        long = np.array([p.duration > 1.01 / rate.fps for p in phones])
        ends = spans.sum(axis=1)
        assert (ends[:-1][long[:-1] & long[1:]] == spans[1:, 0][long[:-1] & long[1:]]).all()


def test_it_comes_back_from_its_arrays():
    graph = build_graph([take("one"), take("two", emotion="angry")], markers=4)
    arrays = graph.to_arrays()
    again = AnimeGraph.from_arrays(arrays)
    for name, values in again.to_arrays().items():
        assert np.array_equal(values, arrays[name]), name
    assert again.symbols == graph.symbols
    assert again.markers == 4
    del arrays["exits"]
    with pytest.raises(InputError, match="lacks the array 'exits'"):
        AnimeGraph.from_arrays(arrays)


@pytest.mark.parametrize(
    ("chains", "message"),
    [
        ([], "no take"),
        ([take(), take("two", motion=np.zeros((15, 3)))], r"take 'two': expected motion of shape \(frames, 2\)"),
        ([take(features=np.zeros((0, 9)))], "expected features"),
        ([take(), take("two", motion_rate=FAST)], "other frame rates"),
        ([take(motion=np.full((15, 2), np.nan))], "none of the 1 takes"),
    ],
)
def test_what_cannot_be_a_graph_is_refused(chains, message):
    with pytest.raises(InputError, match=message):
        build_graph(chains, markers=4)
