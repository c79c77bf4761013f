"""Lips meet on the shown face, in three dimensions, whatever is felt."""

from __future__ import annotations

import numpy as np
import pytest

import mien
from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.face.library import load_face
from mien.face.retargeting import basis_at
from mien.motion.expression.hand_made_performance import hand_made_expression
from mien.motion.mouth.shown_closure import BILABIALS, close_lips
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score

RATE = FrameRate.of(50)


@pytest.fixture(scope="module")
def line() -> Utterance:
    return mien.say("Maybe my brother bought a puppy.").utterance


def _apart(values: np.ndarray) -> np.ndarray:
    """Distance of the inner lips' middles on the default face, mm, shape (frames,)."""
    face = load_face("default")
    sites = [face.sites["lip_upper_inner"], face.sites["lip_lower_inner"]]
    rest = np.stack([face.part(part).vertices[vertex] for part, vertex in sites]).astype(float)
    basis = basis_at(face, sites, channels.WEIGHTS)
    placed = rest + np.einsum("fc,cnx->fnx", values[:, : len(channels.WEIGHTS)], basis)
    return np.asarray(np.linalg.norm(placed[:, 0] - placed[:, 1], axis=1))


@pytest.mark.parametrize("emotion", hand_made_expression().names)
def test_lips_meet_at_every_bilabial(line: Utterance, emotion: str) -> None:
    score = Score(() if emotion == "neutral" else (EmotionSpan(emotion),))
    values = perform(line, score, load_performer("default"), RATE, seed=1).channels.values
    times, apart = RATE.times(len(values)), _apart(values)
    nearest = [apart[(times >= p.start - 0.01) & (times <= p.end)].min() for p in line.phones if p.label in BILABIALS]
    assert len(nearest) >= 5
    assert max(nearest) <= 1.35


def test_what_is_not_sealed_stays() -> None:
    values = np.random.default_rng(0).uniform(0, 1, (4, len(channels.ALL)))
    assert np.array_equal(close_lips(values, np.zeros(4)), values)


def test_a_jaw_that_is_down_is_closed_over() -> None:
    values = np.zeros((1, len(channels.ALL)))
    for name, weight in (("jawOpen", 0.3), ("mouthRollUpper", 0.4), ("mouthUpperUpLeft", 0.3)):
        values[0, channels.ALL.index(name)] = weight
    assert _apart(values)[0] > 5
    assert _apart(close_lips(values, np.ones(1)))[0] < 1.3
