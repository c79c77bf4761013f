"""Faces that a tracker lost are counted, and refused where they are too many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.face_loss import MOST_LOST, check_face, frames_lost, share_lost
from tests.metrics.synthetic import spoken


def track(lost: int, frames: int = 75) -> MarkerTrack:
    positions = np.zeros((frames, 6, 3))
    positions[10 : 10 + lost] = np.nan
    return MarkerTrack(tuple("abcdef"), positions, FrameRate.of(25))


def test_lost_frames_are_refused_with_the_share_that_is_allowed() -> None:
    assert check_face(track(15), "a.mpg") == 15
    with pytest.raises(
        InputError, match=rf"a\.mpg: the face was lost in 27 of 75 frames \(36%; at most {MOST_LOST:.0%}\)"
    ):
        check_face(track(27), "a.mpg")


def test_a_marker_that_is_never_seen_and_one_that_blinks_lose_no_face() -> None:
    positions = np.zeros((20, 6, 3))
    positions[:, 0] = np.nan
    positions[::2, 1] = np.nan
    assert frames_lost(MarkerTrack(tuple("abcdef"), positions, FrameRate.of(25))) == 0
    assert frames_lost(MarkerTrack(tuple("abcdef"), np.full((20, 6, 3), np.nan), FrameRate.of(25))) == 20


def test_takes_know_what_was_lost_and_older_ones_what_was_filled() -> None:
    take = spoken("one", ("ma",))
    frames = len(take.markers)
    assert share_lost(take) == 0.0
    assert share_lost(replace(take, source={"lost": str(frames // 2)})) == pytest.approx(0.5, abs=0.02)
    assert share_lost(replace(take, source={"filled": str(frames * 12)})) == pytest.approx(12 / 48)
