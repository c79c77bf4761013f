"""Arrays on the disk hold what was written, whoever lets go of them, and long sounds are resampled to the same bits."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import numpy as np
import pytest

import mien.core.audio
from mien.core.audio import Audio
from mien.core.long_arrays import GrowingSound, let_go, long_array, trim


def test_what_was_let_go_is_still_there() -> None:
    found = long_array(5000)
    found[:] = np.arange(5000)
    part = found[100:4000]
    del found
    let_go(part)
    trim()
    np.testing.assert_array_equal(part, np.arange(100, 4000))


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc, and let go of on Linux alone")
def test_what_was_let_go_takes_no_memory() -> None:
    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()

    found = long_array(16_000_000)
    found[:] = 1.0
    before = resident()
    let_go(found)
    assert before - resident() > 50_000_000
    assert found[-1] == 1.0


def test_other_arrays_are_left_alone() -> None:
    plain = np.arange(10.0)
    let_go(plain[2:])
    assert plain[3] == 3


def test_a_long_sound_is_resampled_to_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = Audio(np.random.default_rng(0).normal(0, 0.1, 3_000_077).astype(np.float32), 44_100)
    at_once = sound.resampled(16_000)
    monkeypatch.setattr(mien.core.audio, "LONG", 1)
    assert sound.resampled(16_000) == at_once


def test_a_sound_that_grows_long_goes_on_on_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.core.long_arrays.LONG", 2)
    pieces = [np.random.default_rng(n).random(700).astype(np.float32) for n in range(5)]
    sound = GrowingSound(1000)
    for piece in pieces:
        sound.add(piece)
    taken = sound.taken()
    np.testing.assert_array_equal(taken, np.concatenate(pieces))
    taken *= 2
    let_go(taken)
    np.testing.assert_array_equal(taken, 2 * np.concatenate(pieces))
