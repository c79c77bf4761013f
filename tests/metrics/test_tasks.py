"""Upper face, head, closures, synchrony and dynamics: each finds the difference that was made, and that one."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.metrics import closure, dynamics, head_turns, sync, upper_face
from mien.metrics.face_track import FaceTrack
from tests.metrics.faces_in_motion import JAW, PHONES, RATE, TIMES, shown, speaking

BROW = 0.4 + 0.3 * np.sin(3 * TIMES)


def test_a_brow_of_half_the_size_is_seen_as_half() -> None:
    scores = upper_face.evaluate(shown(browInnerUp=BROW), shown(browInnerUp=BROW / 2))
    assert scores["inner_brow_r"] == pytest.approx(1.0)
    assert scores["inner_brow_spread"] == pytest.approx(0.5, abs=0.01)
    assert scores["inner_brow_bias_mm"] < 0
    assert scores["upper_face_dynamics_signed_mm"] > 0  # it moves too little
    assert scores["upper_face_dynamics_absolute_mm"] >= scores["upper_face_dynamics_signed_mm"]


def test_lids_are_seen_apart_from_brows() -> None:
    scores = upper_face.evaluate(
        shown(eyeBlinkLeft=BROW, eyeBlinkRight=BROW), shown(eyeWideLeft=BROW, eyeWideRight=BROW)
    )
    assert scores["lid_gap_r"] < -0.9
    assert scores["lid_gap_bias_mm"] > 1


def test_a_face_without_brows_and_lids_is_refused() -> None:
    lips = shown(jawOpen=JAW).only(["2.2", "2.3", "8.3", "8.4"])
    with pytest.raises(InputError, match="it has none"):
        upper_face.evaluate(lips, shown(jawOpen=JAW))


def test_a_head_that_turns_half_as_far_and_looks_elsewhere() -> None:
    yaw = 5 * np.sin(2 * TIMES)
    still = np.zeros(100)
    one, other = shown(headYaw=yaw, headPitch=still, headRoll=still), shown(headYaw=yaw / 2 + 7, headPitch=still)
    scores = head_turns.evaluate(one, other)
    assert scores["yaw_r"] == pytest.approx(1.0)
    assert scores["yaw_spread"] == pytest.approx(0.5)
    assert scores["yaw_bias_deg"] == pytest.approx(7.0 - yaw.mean() / 2)
    assert scores["head_speed_estimate_deg_s"] == pytest.approx(scores["head_speed_reference_deg_s"] / 2)
    assert np.isnan(scores["pitch_r"])


def test_a_head_that_is_not_known_is_refused() -> None:
    with pytest.raises(InputError, match="does not say how the head moves"):
        head_turns.evaluate(shown(jawOpen=JAW), shown(headYaw=JAW))


def test_closures_are_asked_for_at_bilabials() -> None:
    right = closure.evaluate(speaking(), speaking())
    assert (right["bilabials"], right["closure_recall"], right["shut_f1"]) == (2, 1.0, 1.0)
    half = closure.evaluate(speaking(), speaking(shut=((1.2, 1.4),)))
    assert half["closure_recall"] == 0.5
    assert half["closure_recall_reference"] == 1.0
    wrong = closure.evaluate(speaking(), speaking(shut=((1.2, 1.4), (2.0, 2.2), (1.6, 1.8))))
    assert wrong["closure_recall"] == 1.0
    assert wrong["closure_precision"] < 0.9
    assert wrong["shut_precision"] < wrong["shut_recall"]


def test_without_phones_only_the_reference_is_asked() -> None:
    one = speaking()
    unknown = FaceTrack("it", one.landmarks)
    scores = closure.evaluate(unknown, unknown)
    assert scores["shut_f1"] == 1.0
    assert "closure_f1" not in scores


def test_outer_lips_alone_tell_nothing_of_closures() -> None:
    outer = speaking().only(["8.1", "8.2", "8.3", "8.4", "2.1"])
    with pytest.raises(InputError, match="inner lips"):
        closure.evaluate(outer, outer)


@pytest.mark.parametrize("late", [-0.3, 0.12])
def test_a_late_mouth_is_late_by_as_much(late: float) -> None:
    moved = 0.3 + 0.15 * np.sin(8 * (TIMES - late)) + 0.1 * np.sin(13 * (TIMES - late) + 1)
    scores = sync.evaluate(shown(jawOpen=JAW), shown(jawOpen=moved))
    assert scores["lag_ms"] == pytest.approx(1000 * late, abs=8)
    assert scores["opening_r_at_lag"] > 0.98
    assert scores["lag_unnoticed"] == 0.0


def test_the_end_of_the_range_is_no_lag() -> None:
    rising = 0.5 * TIMES / TIMES[-1]
    wave = rising + 0.02 * np.sin(TIMES)
    scores = sync.evaluate(shown(jawOpen=np.exp(4 * (rising - 0.5))), shown(jawOpen=wave))
    assert np.isnan(scores["lag_ms"])
    assert np.isnan(scores["lag_unnoticed"])


def test_a_mouth_of_twice_the_speed_and_more_noise() -> None:
    one, other = shown(jawOpen=JAW), shown(jawOpen=2 * JAW)
    scores = dynamics.evaluate(one, other)
    assert scores["speed_p99_ratio"] == pytest.approx(2.0, abs=0.1)
    noise = np.random.default_rng(0).normal(0, 0.2, one.landmarks.positions.shape)
    noisy = FaceTrack("noisy", MarkerTrack(one.landmarks.names, one.landmarks.positions + noise, RATE))
    shaken = dynamics.evaluate(one, noisy)
    assert shaken["jitter_estimate_mm"] > shaken["jitter_reference_mm"] + 0.2


def test_flapping_is_counted() -> None:
    calm, flapping = 0.3 + 0.1 * np.sin(3 * TIMES), 0.3 + 0.2 * np.sign(np.sin(20 * TIMES))
    scores = dynamics.evaluate(shown(jawOpen=calm), shown(jawOpen=flapping))
    assert scores["turns_estimate_s"] > 4 * scores["turns_reference_s"]


def test_openings_are_told_by_class() -> None:
    scores = dynamics.evaluate(speaking(), speaking(shut=()))
    assert scores["opening_bilabial_reference_mm"] < 0.75
    assert scores["opening_bilabial_estimate_mm"] > 2
    assert scores["opening_open_reference_mm"] == scores["opening_open_estimate_mm"]
    openings = dynamics.openings_by_class(np.arange(100.0), PHONES, TIMES, np.ones(100, dtype=bool))
    assert openings["bilabial"].tolist() == [30.0, 50.0]  # the least of the frames from 1.2 s and 2.0 s on
    assert openings["front"].tolist() == pytest.approx([42.5])
