"""The head that goes with the voice: a hidden law comes back, silence holds still, and what ships moves by a degree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.motion.alive.head_motion import LearnedHead, default_head, prosodic_features
from tests.utterances import utterance

HEAD = [channels.ALL.index(name) for name in channels.HEAD]


def hummed(seconds: float = 4.0) -> Utterance:
    """A voice-like hum whose pitch rises and falls, with pauses at both ends."""
    t = np.arange(round(seconds * 16_000)) / 16_000
    pitch = 120 * 2 ** (0.4 * np.sin(2 * np.pi * 0.7 * t))
    phase = 2 * np.pi * np.cumsum(pitch) / 16_000
    sound = sum(np.sin(k * phase) / k for k in range(1, 6)) * 0.2 * ((t > 0.5) & (t < seconds - 0.5))
    line = utterance(("SIL", 0.5), ("AA", seconds - 1.0), ("SIL", 0.5))
    return replace(line, audio=Audio(sound, 16_000))


def test_a_hidden_linear_law_comes_back() -> None:
    random = np.random.default_rng(0)
    rows, law = random.normal(size=(4000, 12)) * 5 + 2, random.normal(size=(12, 3))
    head = LearnedHead(ridge=1e-6).fit_frames(rows, (rows - rows.mean(axis=0)) @ law)
    new = random.normal(size=(50, 12)) * 5 + 2
    np.testing.assert_allclose(head.predict(new), (new - rows.mean(axis=0)) @ law, atol=1e-6)


def test_a_strong_ridge_holds_the_head_still() -> None:
    random = np.random.default_rng(0)
    rows = random.normal(size=(500, 4))
    head = LearnedHead(ridge=1e12).fit_frames(rows, rows @ random.normal(size=(4, 3)))
    assert np.abs(head.predict(rows)).max() < 1e-6


def test_what_ships_moves_with_the_voice_by_a_degree_and_rests_without() -> None:
    line, rate = hummed(), FrameRate.of(30)
    values = default_head().perform(line, rate)
    moved = values[:, HEAD]
    assert not np.delete(values, HEAD, axis=1).any()
    assert 0.1 < np.abs(moved).max() < 6.0
    assert np.abs(moved[0]).max() < 0.2
    assert not default_head().perform(utterance(("SIL", 3.0)), rate).any()
    assert np.abs(np.diff(moved, axis=0)).max() * 30 < 40.0  # degrees per second: nothing jerks


def test_the_same_at_every_frame_rate_and_twice() -> None:
    line = hummed()
    slow, fast = (default_head().perform(line, FrameRate.of(fps)) for fps in (25, 50))
    np.testing.assert_allclose(fast[::2][: len(slow)], slow, atol=1e-9)
    np.testing.assert_array_equal(default_head().perform(line, FrameRate.of(25)), slow)


def test_features_know_pauses() -> None:
    times = np.arange(0, 4, 0.04)
    found = prosodic_features(hummed(), times)
    middle = found.shape[1] // 6 // 2 * 6  # the columns of the moment itself
    silent = found[:, middle + 5]
    assert silent[times < 0.46].all()
    assert not silent[(times > 0.54) & (times < 3.4)].any()
    assert np.isfinite(found).all()


def test_takes_without_heads_are_refused() -> None:
    with pytest.raises(InputError, match="no take has the poses of a head"):
        LearnedHead().fit([])
