"""Joining on cases that were made so that the answer is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.motion.graph.joining import CARRY, Joiner, RecordedMotion, joints
from tests.motion.graph.recorded import chain, graph, line, nodes_of, said

TAKE = said(("SIL", 0.2), ("B", 0.12), ("AA", 0.2), ("SIL", 0.2))
FINE = np.arange(0, 0.72, 0.01)


def wave(times: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.sin(8 * times), np.cos(5 * times), times], axis=1)


def x(motion: NDArray[np.float64]) -> NDArray[np.float64]:
    return motion[:, 0]


def test_a_recording_said_as_it_was_recorded_comes_back() -> None:
    made = graph(chain("one", TAKE, wave))
    times = np.arange(18) / 25
    shown = Joiner(made).join(range(4), TAKE, times, None)
    assert np.allclose(shown, wave(times), atol=1e-6)
    assert np.abs(Joiner(made).join(range(4), TAKE, FINE, None) - wave(FINE)).max() < 0.01


def test_one_said_twice_as_slowly_runs_at_half_the_speed() -> None:
    made = graph(chain("one", TAKE, wave))
    slow = said(("SIL", 0.4), ("B", 0.24), ("AA", 0.4), ("SIL", 0.4))
    shown = Joiner(made).join(range(4), slow, 2 * FINE, None)
    assert np.abs(shown - wave(FINE)).max() < 0.01


def test_the_warp_follows_the_sound() -> None:
    made = graph(chain("one", said(("AA", 0.4)), line(0.0, 10.0)))
    late = made.features_of(0)[[0] * 20 + list(range(0, 40, 2))]  # nothing happens at first, then all of it
    shown = x(Joiner(made).join([0], said(("AA", 0.4)), FINE[:40], [late]))
    even = x(Joiner(made, evenness=1.0).join([0], said(("AA", 0.4)), FINE[:40], [late]))
    assert shown[18] < 0.5
    assert even[18] == pytest.approx(1.8, abs=1e-6)
    assert shown[39] > 3.7


def jumping(helper: bool) -> Any:
    """B of a take at 0 mm, then AA of a take at 10 mm; if wanted a take at 4 mm has B and AA as neighbours."""
    first = chain("first", said(("B", 0.2), ("T", 0.2)), line(0.0), seconds=0.6)
    second = chain("second", said(("T", 0.2), ("AA", 0.2)), line(10.0), seconds=0.6)
    third = chain("third", said(("B", 0.3), ("AA", 0.1)), line(4.0), seconds=0.6)
    made = graph(*([first, second, third] if helper else [first, second]))
    return made, [nodes_of(made, 0)[0], nodes_of(made, 1)[1]]


def test_a_jump_is_led_over_by_a_recorded_transition() -> None:
    made, path = jumping(helper=True)
    joiner = Joiner(made)
    assert joints(made, path).tolist() == [True]
    assert joiner.helper(*path, (0.2, 0.2)) == nodes_of(made, 2)[0]
    shown = x(joiner.join(path, said(("B", 0.2), ("AA", 0.2)), np.array([0.0, 0.1, 0.2, 0.3, 0.4]), None))
    assert shown == pytest.approx([0, 2, 4, 7, 10])  # its weight rises to the joint and falls after it


def test_without_one_what_came_after_fades_into_what_came_before() -> None:
    made, path = jumping(helper=False)
    assert Joiner(made).helper(*path, (0.2, 0.2)) is None
    shown = x(Joiner(made).join(path, said(("B", 0.1), ("AA", 0.3)), np.array([0.0, 0.1, 0.2, 0.4]), None))
    assert shown == pytest.approx([0, 2.5, 5, 10])  # linearly from the start of the first to the end of the second


def test_the_helper_most_alike_is_taken() -> None:
    takes = [
        chain("first", said(("B", 0.2), ("T", 0.2)), line(0.0)),
        chain("second", said(("T", 0.2), ("AA", 0.2)), line(10.0)),
    ]
    for level, length in ((30.0, 0.2), (6.0, 0.2), (6.0, 0.6)):
        takes.append(chain(f"h{level}{length}", said(("B", length), ("AA", length)), line(level)))
    made = graph(*takes)
    path = nodes_of(made, 0)[0], nodes_of(made, 1)[1]
    assert Joiner(made).helper(*path, (0.2, 0.2)) == nodes_of(made, 3)[0]
    assert Joiner(made).helper(*path, (0.6, 0.6)) == nodes_of(made, 4)[0]


def test_where_nothing_more_was_recorded_the_velocity_carries_on_and_dies_away() -> None:
    made = graph(chain("one", said(("B", 0.2)), line(0.0, 50.0), seconds=0.2))  # frames up to 0.2 s
    motion = RecordedMotion(made)
    after = x(motion.at(0, np.array([0.2, 0.21, 5.0])))
    assert after[0] == pytest.approx(10)
    assert after[1] == pytest.approx(10.5, abs=0.05)
    assert after[2] == pytest.approx(10 + 50 * CARRY)
    assert x(motion.at(0, np.array([-5.0]))) == pytest.approx([-50 * CARRY])


def test_lost_frames_end_what_was_recorded() -> None:
    def lost(times: NDArray[np.float64]) -> NDArray[np.float64]:
        motion = line(0.0, 10.0)(times)
        motion[10:12] = np.nan
        return motion

    made = graph(chain("one", said(("B", 0.2), ("AA", 0.2), ("T", 0.2), ("IY", 0.2)), lost))
    labels = [made.symbols[phone] for phone in made.phones]
    assert labels == ["B", "IY"]  # AA ends on a lost frame, T holds one
    motion = RecordedMotion(made)
    everywhere = np.concatenate([motion.at(node, np.linspace(-1, 2, 100)) for node in range(len(made))])
    assert np.isfinite(everywhere).all()
    assert x(motion.at(len(made) - 1, np.array([0.7]))) == pytest.approx([7.0])


def test_fades_add_up_to_one_whatever_the_path() -> None:
    random = np.random.default_rng(1)
    labels = ["B", "AA", "T", "IY"]
    still = [
        chain(f"t{k}", said(*((str(p), 0.12) for p in random.choice(labels, 5))), line(7.0), seconds=0.8)
        for k in range(4)
    ]
    made = graph(*still)
    for _ in range(20):
        path = random.integers(0, len(made), 6)
        phones = said(*((made.symbols[made.phones[n]], float(random.uniform(0.0, 0.3))) for n in path))
        assert np.allclose(Joiner(made).join(path, phones, np.linspace(-0.1, 2, 90), None), [7, 0, 0], atol=1e-4)


def test_motion_is_whole_whatever_the_path() -> None:
    """From one hundredth of a second to the next nothing leaps: the fades meet at every joint."""
    random = np.random.default_rng(2)
    labels = ["B", "AA", "T"]
    takes = []
    for k in range(5):
        phase = float(random.uniform(0, 6))
        phones = said(*((str(p), 0.12) for p in random.choice(labels, 6)))
        takes.append(chain(f"t{k}", phones, lambda t, phase=phase: 5 * wave(t + phase), seconds=0.8))
    made = graph(*takes)
    for _ in range(20):
        path = random.integers(0, len(made), 8)
        phones = said(*((made.symbols[made.phones[n]], float(random.uniform(0.08, 0.3))) for n in path))
        shown = Joiner(made).join(path, phones, np.arange(0, phones.intervals[-1].end, 0.001), None)
        steps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
        assert steps.max() < 1.0  # mm in a millisecond; a pop would be of several mm
