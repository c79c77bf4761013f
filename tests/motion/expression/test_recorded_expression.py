"""Expressions learned from recordings whose expression is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack
from mien.metrics.face_track import shown_landmarks
from mien.motion.drift import smooth_drift
from mien.motion.expression.expression_file import RecordedExpressions
from mien.motion.expression.expression_motion import (
    Twins,
    expressive_displacement,
    find_twins,
    matched_phones,
    warped_by_motion,
    warped_times,
)
from mien.motion.expression.expression_space import RATE as SAMPLES
from mien.motion.expression.recorded_expression import expression_of, learn_expressions
from mien.text.score import EmotionSpan, Score
from tests.motion.expressive_takes import KNOWN, LAYOUT, RATE, expression, take, takes


@cache
def learned_from_two() -> RecordedExpressions:
    """What two sentences teach, learned once for all tests."""
    learned = learn_expressions(takes(2))
    assert learned is not None
    return learned


def tier(*phones: tuple[str, float, float]) -> Tier:
    return Tier("phones", tuple(Interval(start, end, label) for label, start, end in phones))


def test_time_runs_evenly_inside_each_phone() -> None:
    onto = tier(("SIL", 0.0, 0.2), ("M", 0.2, 0.3), ("AA", 0.3, 0.5), ("SIL", 0.5, 0.7))
    source = tier(("SIL", 0.0, 0.1), ("M", 0.1, 0.4), ("AA", 0.4, 0.5), ("SIL", 0.5, 0.9))
    times = np.array([0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(warped_times(times, onto, source), [0.0, 0.1, 0.25, 0.4, 0.45, 0.5, 0.6])


def test_a_pause_or_a_phone_more_does_not_break_the_match() -> None:
    onto = tier(("M", 0.0, 0.1), ("AA", 0.1, 0.2), ("T", 0.2, 0.3))
    source = tier(("M", 0.0, 0.1), ("SIL", 0.1, 0.5), ("AA", 0.5, 0.6), ("T", 0.6, 0.7))
    assert matched_phones(onto, source) == [(0, 0), (1, 2), (2, 3)]
    np.testing.assert_allclose(warped_times(np.array([0.15]), onto, source), [0.55])


def test_another_sentence_is_refused() -> None:
    with pytest.raises(InputError, match="only 1 of 3 phones are the same"):
        warped_times(
            np.zeros(1), tier(("M", 0, 1), ("AA", 1, 2), ("T", 2, 3)), tier(("S", 0, 1), ("AA", 1, 2), ("M", 2, 3))
        )


def test_twins_say_the_same() -> None:
    pairs = find_twins(takes(2))
    assert [(pair.expressive.name, pair.neutral.name) for pair in pairs] == [
        ("s0-happy", "s0-neutral"),
        ("s0-surprised", "s0-neutral"),
        ("s1-happy", "s1-neutral"),
        ("s1-surprised", "s1-neutral"),
    ]
    unlinked = [replace(one, sentence="") for one in takes(2)]
    assert len(find_twins(unlinked)) == 4  # by their words


def test_the_words_are_taken_out_and_the_expression_is_left() -> None:
    layout = load_layout(LAYOUT)
    left = expressive_displacement(Twins(take(1, "happy", stretch=0.3), take(1, "neutral")))
    chin = left[:, layout.markers.index(layout.landmarks[152])]
    corner = left[:, layout.markers.index(layout.landmarks[291])]
    spoken = take(1, "neutral").markers.positions[:, layout.markers.index(layout.landmarks[152])]
    assert np.abs(chin).max() < 0.2 * np.ptp(spoken[:, 1])  # the jaw's speech is gone (a smile lifts the chin)
    assert corner[:, 1].mean() > 3  # the smile is not


def test_the_right_warp_leaves_less_than_linear_time() -> None:
    felt, plain = take(2, "happy", stretch=0.3), take(2, "neutral")
    edges = [plain.phones.intervals[0].end, plain.phones.intervals[-1].start]
    onto = tier(*(("AA", *pair) for pair in [edges]))
    source = tier(("AA", felt.phones.intervals[0].end, felt.phones.intervals[-1].start))
    linear = replace(felt, phones=source), replace(plain, phones=onto)
    right, wrong = (expressive_displacement(Twins(*pair)) for pair in ((felt, plain), linear))
    chin = load_layout(LAYOUT).index([load_layout(LAYOUT).landmarks[152]])[0]
    assert (right[:, chin] ** 2).sum() < 0.2 * (wrong[:, chin] ** 2).sum()


def test_without_phone_times_the_motion_tells_the_warp() -> None:
    random = np.random.default_rng(0)
    grid = np.arange(180) / 60
    spoken = np.stack([smooth_drift(grid, 0.12, random) for _ in range(6)], axis=1) * [5, 3, 2, 1.5, 1, 1]
    pace = np.interp(grid, np.linspace(0, 3, 12), np.sort(random.uniform(0.0, 2.98, 12)))
    felt = np.stack([np.interp(pace, grid, column) for column in spoken.T], axis=1)
    felt = felt + 4.0 + 0.5 * smooth_drift(grid, 0.2, random)[:, None]
    noisy = [rows + random.normal(0, 0.3, rows.shape) for rows in (felt, spoken)]
    found = warped_by_motion(grid, *noisy)
    assert np.abs(found - pace).mean() < 0.035


def test_twins_without_phones_give_the_expression() -> None:
    plain, felt = take(0, "neutral", 0.0, 0.05), take(0, "happy", 0.25, 0.05)
    bare = [replace(one, phones=Tier("phones", ()), words=Tier("words", ())) for one in (felt, plain)]
    known, found = (expressive_displacement(twins).mean(axis=0) for twins in (Twins(felt, plain), Twins(*bare)))
    assert np.linalg.norm(found - known) < 0.2 * np.linalg.norm(known)


def test_other_motion_is_no_twin() -> None:
    random = np.random.default_rng(0)
    one, other = (random.normal(size=(120, 30)) for _ in range(2))
    with pytest.raises(InputError, match="do not move alike"):
        warped_by_motion(np.arange(5) / 60, one, other)


def test_the_known_expressions_are_learned() -> None:
    learned = learn_expressions(takes())
    assert learned is not None
    assert learned.space.emotions == ("happy", "surprised")
    assert learned.space.space_.share_ > 0.8
    for emotion, names in KNOWN.items():
        carried = np.concatenate(learned.space.carried_[emotion])
        for name in names:
            assert carried[:, channels.ALL.index(name)].mean() == pytest.approx(0.5, abs=0.06), (emotion, name)
    calm = [name for name in channels.ARKIT if name not in sum(KNOWN.values(), ())]
    others = np.concatenate(learned.space.carried_["happy"])[:, [channels.ALL.index(name) for name in calm]]
    assert others.mean() < 0.05


def shown(weights: np.ndarray, landmarks: tuple[int, ...], axis: int) -> np.ndarray:
    """Mean way of landmarks of the default face, mm."""
    rest = np.zeros((1, weights.shape[1]))
    track = shown_landmarks(ChannelTrack(channels.ALL, np.concatenate([rest, weights]), FrameRate.of(60)))
    places = [track.names.index(load_layout(LAYOUT).landmarks[number]) for number in landmarks]
    way = track.positions[:, places, axis] - track.positions[:1, places, axis]
    return np.asarray(np.abs(way).mean(axis=1)[1:])


@pytest.mark.parametrize(("emotion", "landmarks", "axis"), [("happy", (61, 291), 0), ("surprised", (55, 285), 1)])
def test_on_the_face_they_are_as_large_as_they_were_and_move_alike(
    emotion: str, landmarks: tuple[int, ...], axis: int
) -> None:
    learned = learned_from_two()
    pairs = [pair for pair in find_twins(takes(2)) if pair.expressive.emotion == emotion]
    sizes = []
    for number, (pair, found) in enumerate(zip(pairs, learned.space.carried_[emotion], strict=True)):
        plain = pair.neutral.phones
        times = np.arange(round(plain.intervals[0].end * SAMPLES), round(plain.intervals[-1].start * SAMPLES)) / SAMPLES
        truth = expression(emotion, RATE.times(len(pair.expressive.markers)), number)
        elsewhere = warped_times(times, plain, pair.expressive.phones)
        was = truth[np.minimum((elsewhere * 60).round().astype(int), len(truth) - 1)]
        one, other = shown(was, landmarks, axis), shown(found[: len(was)], landmarks, axis)
        sizes.append(other.mean() / one.mean())
        assert np.corrcoef(one, other)[0, 1] > 0.95
    assert np.mean(sizes) == pytest.approx(1.0, abs=0.15)


def test_the_eyelids_are_carried_and_not_in_the_space() -> None:
    learned = learned_from_two()
    assert learned.space.space_.mean_.shape == ((218 - 28) * 3,)
    new = learned.space.sample("surprised", 3.0, np.random.default_rng(0))
    assert new.carried[:, channels.ALL.index("eyeWideLeft")].mean() > 0.3


def test_a_performer_uses_what_was_recorded_and_tells_what_was_not() -> None:
    model = expression_of(learned_from_two())
    asked = Score((EmotionSpan("surprised"), EmotionSpan("sad", start=1.0)))
    assert [note.message for note in model.notes(asked)] == [
        "sad was not recorded for this performer: its motion is hand-made"
    ]
    values = model.perform(Score((EmotionSpan("happy"),)), 3.0, FrameRate.of(30), np.random.default_rng(1))
    assert values[:, channels.ALL.index("mouthSmileLeft")].mean() == pytest.approx(0.5, abs=0.15)


def test_without_twins_nothing_is_learned_and_bad_ones_are_told() -> None:
    assert learn_expressions([take(1, "happy"), take(2, "neutral")]) is None
    broken = take(1, "happy")
    positions = broken.markers.positions.copy()
    positions[7, 3] = np.nan
    broken = replace(broken, markers=type(broken.markers)(broken.markers.names, positions, broken.markers.rate))
    with pytest.raises(InputError, match="a marker was lost in frame 7"):
        learn_expressions([broken, take(1, "neutral")])
