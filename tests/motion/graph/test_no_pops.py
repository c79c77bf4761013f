"""No pop is seen where recordings are joined: measured on the default performer, learned from real recordings."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.graph.candidates import candidates_for
from mien.motion.graph.graph_motion import GraphMotion
from mien.motion.graph.joining import joints
from mien.motion.graph.search import cheapest_nodes
from mien.motion.performers import load_learned_performer
from tests.motion.graph.recorded import said

FPS = 25


@pytest.fixture(scope="module")
def performer() -> GraphMotion:
    recorded = load_learned_performer("default").recorded
    assert recorded is not None
    return recorded.motion


def acceleration(motion: NDArray[np.float64]) -> NDArray[np.float64]:
    """RMS over markers, m/s², of frames 1 to n - 2."""
    return np.linalg.norm(np.diff(motion, 2, axis=0), axis=1) / np.sqrt(48) * FPS**2 / 1000


def recorded_accelerations(performer: GraphMotion) -> NDArray[np.float64]:
    graph = performer.graph_
    found = []
    for take in range(0, len(graph.takes), 3):
        motion = np.asarray(graph.motion[graph.take_motion[take] : graph.take_motion[take + 1]], dtype=np.float64)
        found.append(acceleration(motion[np.isfinite(motion).all(axis=1)]))
    return np.concatenate(found)


def strange_sentence(performer: GraphMotion, random: np.random.Generator) -> Tier:
    """Pieces of two recorded phones from anywhere, so that recordings must be joined again and again."""
    graph = performer.graph_
    phones = [("SIL", 0.3)]
    while len(phones) < 30:
        node = int(random.integers(0, len(graph) - 1))
        pair = [(graph.symbols[graph.phones[n]], float(graph.durations[n])) for n in (node, node + 1)]
        if PAUSE not in (pair[0][0], pair[1][0]):
            phones += pair
    return said(*phones, ("SIL", 0.3))


def test_acceleration_at_joins_stays_within_that_of_the_recordings(performer: GraphMotion) -> None:
    random = np.random.default_rng(0)
    recorded = recorded_accelerations(performer)
    at_joins = []
    for _ in range(20):
        phones = strange_sentence(performer, random)
        asked, weights = performer.asked(phones, None)
        nodes, _ = cheapest_nodes(candidates_for(performer.index_, asked, weights))
        times = np.arange(int(phones.intervals[-1].end * FPS)) / FPS
        change = acceleration(performer.joined(nodes, phones, times, None))
        for place in np.flatnonzero(joints(performer.graph_, nodes)):
            frame = round(phones.intervals[place].end * FPS) - 1
            at_joins.append(change[max(frame - 1, 0) : frame + 2])
    found = np.concatenate(at_joins)
    assert len(at_joins) > 100
    for share in (50, 95, 99):
        assert np.percentile(found, share) < 1.15 * np.percentile(recorded, share if share > 50 else 75)
    assert found.max() < recorded.max()
