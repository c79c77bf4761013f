import numpy as np
import pytest

from mien.motion.graph.audio_distance import audio_distance, distances_to, hear_all, warping_path


def stretches(seed=0, count=60, longest=25, coefficients=9):
    random = np.random.default_rng(seed)
    counts = random.integers(1, longest, count).astype(np.int32)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    features = random.standard_normal((counts.sum(), coefficients)).cumsum(axis=0).astype(np.float32)
    return features, starts, counts


@pytest.mark.parametrize("frames", [1, 2, 9, 40])
@pytest.mark.parametrize("asked", [1, 5, 16, 37])
def test_compiled_and_plain_agree(frames, asked):
    features, starts, counts = stretches()
    heard = features[:frames]
    nodes = np.random.default_rng(1).permutation(60)[:asked].astype(np.int32)
    out = np.empty(asked)
    distances_to(heard, features, starts, counts, nodes, out)
    plain = [audio_distance(heard, features[starts[n] : starts[n] + counts[n]]) for n in nodes]
    assert np.allclose(out, plain, rtol=1e-5, atol=1e-6)


def test_a_node_costs_the_same_whoever_is_asked_with_it():
    features, starts, counts = stretches()
    heard = features[100:112]
    together, alone = np.empty(60), np.empty(1)
    distances_to(heard, features, starts, counts, np.arange(60, dtype=np.int32), together)
    for node in range(60):
        distances_to(heard, features, starts, counts, np.array([node], dtype=np.int32), alone)
        assert alone[0] == pytest.approx(together[node], rel=1e-6)


def test_an_utterance_is_heard_phone_by_phone():
    features, starts, counts = stretches()
    heard, ends = features[100:160], np.array([0, 12, 40, 60])
    nodes, offsets = np.array([3, 9, 4, 3, 20, 21, 22, 23], dtype=np.int32), np.array([0, 2, 3, 8])
    costs, alone = np.ones(8), np.empty(1)
    hear_all(heard, ends, np.array([0.5, 0.0, 2.0]), features, starts, counts, nodes, offsets, costs)
    for step, weight in enumerate((0.5, 0.0, 2.0)):
        for place in range(offsets[step], offsets[step + 1]):
            distances_to(heard[ends[step] : ends[step + 1]], features, starts, counts, nodes[place : place + 1], alone)
            assert costs[place] == pytest.approx(1 + weight * alone[0], rel=1e-6)


def test_a_slower_copy_is_no_distance_away():
    rows = np.random.default_rng(0).standard_normal((7, 9))
    assert audio_distance(rows, np.repeat(rows, 3, axis=0)) == 0.0
    assert audio_distance(rows, rows[::-1]) > 0.5


def test_it_is_a_mean_over_the_path_with_steps_in_both_counted_twice():
    random = np.random.default_rng(3)
    heard, recorded = random.standard_normal((8, 9)), random.standard_normal((11, 9))
    path = warping_path(heard, recorded)
    apart = np.linalg.norm(heard[path[:, 0]] - recorded[path[:, 1]], axis=1)
    steps = np.diff(path, axis=0, prepend=[[-1, -1]]).sum(axis=1)
    assert steps.sum() == 19
    assert audio_distance(heard, recorded) == pytest.approx((apart * steps).sum() / 19)
    assert audio_distance(recorded, heard) == pytest.approx(audio_distance(heard, recorded))


def test_the_path_runs_from_the_first_frames_to_the_last():
    random = np.random.default_rng(4)
    for frames, others in ((1, 1), (1, 6), (6, 1), (5, 9)):
        path = warping_path(random.standard_normal((frames, 2)), random.standard_normal((others, 2)))
        assert path[0].tolist() == [0, 0]
        assert path[-1].tolist() == [frames - 1, others - 1]
        assert set(map(tuple, np.diff(path, axis=0).tolist())) <= {(0, 1), (1, 0), (1, 1)}
