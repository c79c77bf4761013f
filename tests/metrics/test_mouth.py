"""The mouth of one face scored against another's."""

from __future__ import annotations

import numpy as np
import pytest

from mien.animation.animation import imported
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.face.library import load_face
from mien.formats.c3d import face_markers
from mien.metrics import mouth
from mien.metrics.face_track import FaceTrack, landmark_names, shown_landmarks
from mien.metrics.pairing import constant_offset

RATE = FrameRate.of(25)
JAW = 0.3 + 0.2 * np.sin(np.arange(60) / 2)


def shown(**curves: np.ndarray) -> FaceTrack:
    return FaceTrack.of_channels(ChannelTrack(tuple(curves), np.stack(list(curves.values()), axis=1), RATE))


def test_landmarks_are_where_the_posed_face_has_them() -> None:
    values = np.random.default_rng(0).random((3, len(WEIGHTS)))
    track = ChannelTrack(WEIGHTS, values, RATE)
    posed = face_markers(imported(track, "random"), load_face())
    here = shown_landmarks(track)
    there = posed.positions[:, [posed.names.index(name) for name in landmark_names()]]
    assert np.abs(here.positions - there).max() < 1e-3


def test_a_mouth_is_itself() -> None:
    scores = mouth.evaluate(shown(jawOpen=JAW), shown(jawOpen=JAW))
    assert scores["opening_r"] == pytest.approx(1.0)
    assert scores["opening_spread"] == pytest.approx(1.0)
    assert scores["mouth_rms_with_offset_mm"] == 0.0


def test_size_sign_and_offset_are_kept_apart() -> None:
    one, half = shown(jawOpen=JAW), shown(jawOpen=JAW / 2)
    scores = mouth.evaluate(one, half)
    assert scores["opening_spread"] == pytest.approx(0.5, abs=0.02)
    assert scores["opening_bias_mm"] < -1.0  # it opens less: signed
    assert scores["opening_absolute_mm"] > 1.0
    assert mouth.evaluate(half, one)["opening_bias_mm"] > 1.0


def test_a_constant_offset_is_removed_and_said() -> None:
    one = shown(jawOpen=JAW)
    moved = MarkerTrack(one.landmarks.names, one.landmarks.positions + np.array([0.0, 4.4, 0.0]), RATE)
    scores = mouth.evaluate(one, FaceTrack("moved", moved))
    assert scores["mouth_rms_mm"] == pytest.approx(0.0, abs=1e-9)
    assert scores["mouth_rms_with_offset_mm"] == pytest.approx(4.4)
    assert scores["mouth_offset_y_mm"] == pytest.approx(4.4)
    pair, _ = mouth.mouth_pair(one, FaceTrack("moved", moved))
    assert mouth.evaluate(one, one, offset=constant_offset(pair))["mouth_rms_mm"] == pytest.approx(4.4)


def test_another_frame_rate_is_resampled() -> None:
    times = np.arange(0.0, 2.0, 1 / 60)
    fast = FaceTrack.of_channels(
        ChannelTrack(("jawOpen",), (0.3 + 0.2 * np.sin(times * 25 / 2))[:, None], FrameRate.of(60))
    )
    assert mouth.evaluate(shown(jawOpen=JAW), fast)["opening_r"] > 0.999


def test_only_speech_is_scored_where_phones_are_known() -> None:
    one = shown(jawOpen=JAW)
    phones = Tier("phones", (Interval(0.0, 0.4, "SIL"), Interval(0.4, 0.8, "AA"), Interval(0.8, 2.4, "SIL")))
    known = FaceTrack("known", one.landmarks, phones=phones)
    assert mouth.evaluate(known, one)["frames"] == 15  # frames 8 to 22
    assert mouth.evaluate(one, one)["frames"] == 60


def test_frames_that_were_not_seen_do_not_count() -> None:
    one = shown(jawOpen=JAW)
    gaps = one.landmarks.positions.copy()
    gaps[10:20] = np.nan
    assert mouth.evaluate(FaceTrack("gaps", MarkerTrack(one.landmarks.names, gaps, RATE)), one)["frames"] == 50


def test_a_mouth_that_is_not_there_is_refused() -> None:
    one = shown(jawOpen=JAW)
    brows = one.only(["4.1", "4.2", "4.3", "4.4"])
    with pytest.raises(InputError, match="landmarks"):
        mouth.validate(one, brows)


def test_recorded_markers_are_laid_on_their_places_whatever_the_head_does() -> None:
    from mien.face.posing import head_rotation

    one = shown(jawOpen=JAW)
    turned = one.landmarks.positions @ head_rotation(20, -8, 5).T + np.array([30.0, -4.0, 600.0])
    markers = FaceTrack.of_markers(MarkerTrack(one.landmarks.names, turned, RATE))
    assert markers.head is not None
    assert np.allclose(markers.head, [20, -8, 5], atol=0.5)
    assert mouth.evaluate(one, markers)["mouth_rms_mm"] < 0.3  # the nose gives way to the jaw a little
