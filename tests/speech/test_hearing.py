"""Hearing a whole sound: blocks agree with the stream; edges lie between rows."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.utterance import PAUSE
from mien.speech import hearing
from mien.speech.frame_classifier import FrameStream, default_classifier
from mien.speech.hearing import SHARE, Hearing, hear
from mien.speech.streaming_features import HOP, RATE, WINDOW, StreamingFeatures


def test_blocks_are_heard_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = np.random.default_rng(0).normal(0, 0.05, 2 * RATE).astype(np.float32)
    network = default_classifier()
    stream = FrameStream(network, hearing.FUTURE, hearing.STEP)
    rows = StreamingFeatures().push(np.concatenate([sound, np.zeros(WINDOW // 2)]))
    whole = np.concatenate([stream.push(rows), stream.pending()]) - SHARE * network.log_share
    whole[:, 0] -= hearing.PAUSE_IN_NOISE  # white noise all along: nothing in it is quiet
    monkeypatch.setattr(hearing, "_BLOCK", RATE // 3)
    np.testing.assert_allclose(hear(Audio(sound, RATE)).rows, whole, atol=0.05)


def test_an_edge_lies_where_both_are_as_likely() -> None:
    rows = np.array([[0.0, -3.0], [0.0, -3.0], [-1.0, 0.0], [-3.0, 0.0]], np.float32)
    heard = Hearing((PAUSE, "A"), rows)
    assert heard.edge(2, PAUSE, "A") == pytest.approx(1.75 * HOP / RATE)
    assert heard.score("A", 2, 4) == 0.0
    assert heard.score(PAUSE, 2, 4) == pytest.approx(-2.0)
