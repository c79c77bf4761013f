"""Expressions: sampled motion is like its source, intensity weighs it, emotions share the face."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.motion.expression.expression import NEUTRAL, Expression, weights_of
from mien.motion.expression.expression_space import RATE, ExpressionSettings, ExpressionSpace, ExpressiveMotion
from mien.motion.expression.hand_made_performance import (
    hand_made_expression,
    hand_made_performance,
    hand_made_space,
    sealed_share,
    space_of,
)
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan, Score

MODEL, SPACE = hand_made_expression(), hand_made_space()
TIMES = np.arange(0, 4, 1 / 30)


def performed(*spans: EmotionSpan, seconds: float = 4.0, fps: float = 30, seed: int = 1) -> np.ndarray:
    return MODEL.perform(Score(spans), seconds, FrameRate.of(fps), np.random.default_rng(seed))


def channel(values: np.ndarray, name: str) -> np.ndarray:
    return values[:, channels.ALL.index(name)]


def test_a_known_space_is_found_again() -> None:
    random = np.random.default_rng(0)
    axes = np.linalg.qr(random.standard_normal((12, 3)))[0].T
    curve = random.standard_normal((3000, 3)) * [3.0, 2.0, 1.0]
    motion = curve @ axes + 5.0
    space = ExpressionSpace(ExpressionSettings(stride=1)).fit({"happy": [ExpressiveMotion(motion, motion[:, :1])]})
    assert space.space_.share_ == pytest.approx(1.0)
    np.testing.assert_allclose(np.abs(space.space_.axes_ @ axes.T), np.eye(3), atol=0.1)
    np.testing.assert_allclose(space.motion(space.curves_["happy"][0]), motion, atol=1e-6)


def test_what_is_carried_moves_with_the_curve() -> None:
    """Lids are sampled with the same patches: what tied them to the curve in the source ties them in the new motion."""
    times = np.arange(3600) / RATE
    motion = np.stack([np.sin(times), np.cos(times), np.sin(2 * times)], axis=1)
    space = ExpressionSpace().fit({"surprised": [ExpressiveMotion(motion, 2 * motion[:, :1] + 1)]})
    new = space.sample("surprised", 10.0, np.random.default_rng(2))
    np.testing.assert_allclose(new.carried[:, 0], 2 * space.motion(new.curve)[:, 0] + 1, atol=1e-6)


@pytest.mark.parametrize("emotion", [name for name in MODEL.names if name != NEUTRAL])
def test_sampled_motion_has_the_statistics_of_its_source(emotion: str) -> None:
    source = SPACE.curves_[emotion][0]
    drawn = [SPACE.sample(emotion, 60.0, np.random.default_rng(seed)).curve for seed in (7, 8, 9)]
    new = np.concatenate(drawn)
    low, high = source.min(axis=0), source.max(axis=0)
    assert (new >= low - 1e-9).all()
    assert (new <= high + 1e-9).all()
    for order, tolerance in ((0, 0.25), (1, 0.2)):  # spread and speed
        ratio = np.diff(new, order, axis=0).std(axis=0) / np.diff(source, order, axis=0).std(axis=0)
        np.testing.assert_allclose(ratio, 1.0, atol=tolerance)
    for lag in (6, 24, 60):  # 0.05, 0.2, 0.5 s
        kept = np.mean([_memory(curve, lag) for curve in drawn], axis=0)
        np.testing.assert_allclose(kept, _memory(source, lag), atol=0.25)
    np.testing.assert_allclose(_spectrum(new), _spectrum(source), atol=0.12)


def _memory(curve: np.ndarray, lag: int) -> np.ndarray:
    centred = curve - curve.mean(axis=0)
    return (centred[lag:] * centred[:-lag]).mean(axis=0) / (centred**2).mean(axis=0)


def _spectrum(curve: np.ndarray) -> np.ndarray:
    """Share of the power below 1, 2 and 4 Hz."""
    pieces = [curve[k : k + 600] - curve[k : k + 600].mean(axis=0) for k in range(0, len(curve) - 600, 600)]
    power = sum((np.abs(np.fft.rfft(piece, axis=0)) ** 2).sum(axis=1) for piece in pieces)
    cycles = np.fft.rfftfreq(600, 1 / RATE)
    return np.array([power[cycles <= limit].sum() / power.sum() for limit in (1, 2, 4)])


def test_a_performance_is_alive_and_uneven() -> None:
    smile = hand_made_performance("happy")
    left, right = channel(smile, "mouthSmileLeft"), channel(smile, "mouthSmileRight")
    assert 0.03 < left.std() < 0.25
    assert 0.005 < (left - right).std() < 0.1
    assert np.corrcoef(left, right)[0, 1] > 0.8
    np.testing.assert_array_equal(smile, hand_made_performance("happy"))


def test_surprise_has_wide_eyes() -> None:
    assert channel(performed(EmotionSpan("surprised")), "eyeWideLeft").mean() > 0.4


def test_intensity_zero_is_neutral_and_one_is_full() -> None:
    np.testing.assert_array_equal(performed(EmotionSpan("happy", 0.0)), performed())
    full, half = (channel(performed(EmotionSpan("happy", i)), "mouthSmileLeft") for i in (1.0, 0.5))
    source = channel(hand_made_performance("happy"), "mouthSmileLeft")
    assert full.mean() == pytest.approx(source.mean(), rel=0.25)
    calm = channel(performed(), "mouthSmileLeft")
    assert half.mean() == pytest.approx((full.mean() + calm.mean()) / 2, rel=0.1)


def test_intensity_follows_its_curve() -> None:
    rising = channel(
        performed(EmotionSpan("happy", IntensityCurve((0.0, 4.0), (0.0, 1.0), "linear"))), "mouthSmileLeft"
    )
    full, calm = (channel(p, "mouthSmileLeft") for p in (performed(EmotionSpan("happy")), performed()))
    np.testing.assert_allclose(rising, full * TIMES / 4 + calm * (1 - TIMES / 4), atol=1e-9)


def test_a_span_comes_and_goes() -> None:
    brow = channel(performed(EmotionSpan("surprised", 1.0, start=1.0, end=3.0)), "browOuterUpLeft")
    calm = channel(performed(), "browOuterUpLeft")
    np.testing.assert_allclose(brow[[0, -1]], calm[[0, -1]], atol=1e-9)
    assert brow[60] > 0.45
    assert np.abs(np.diff(brow)).max() < 0.3


def test_one_emotion_gives_way_to_the_next_without_a_dip() -> None:
    score = Score((EmotionSpan("sad", 1.0, end=2.0), EmotionSpan("happy", 1.0, start=2.0)))
    weights = weights_of(score, TIMES)
    np.testing.assert_allclose(weights[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    assert ((weights[1:] > 0.1).sum(axis=0) == 2).sum() > 3  # for a moment both


def test_what_one_emotion_draws_leaves_the_others_as_they_are() -> None:
    sad = EmotionSpan("sad", 0.3)
    alone = performed(sad)
    beside = performed(sad, EmotionSpan("angry", 0.0))
    np.testing.assert_allclose(alone, beside, atol=1e-12)


def test_motion_is_the_same_at_every_frame_rate() -> None:
    span = EmotionSpan("angry", 0.8)
    slow, quick = performed(span, fps=30), performed(span, fps=60)
    np.testing.assert_allclose(slow, quick[::2][: len(slow)], atol=1e-9)


def test_an_unknown_emotion_gets_a_guess() -> None:
    with pytest.raises(InputError, match="did you mean 'happy'"):
        MODEL.check(Score((EmotionSpan("hapy"),)))


def test_what_was_not_recorded_is_told() -> None:
    assert MODEL.notes(Score((EmotionSpan("sad"),))) == ()  # of a hand-made repertoire nothing else is expected
    own = Expression(MODEL.names, lambda _: SPACE, sealed_share(), frozenset(MODEL.names) - {"happy"})
    notes = own.notes(Score((EmotionSpan("happy"), EmotionSpan("sad"))))
    assert [note.message for note in notes] == ["sad was not recorded for this performer: its motion is hand-made"]


def test_refusals() -> None:
    with pytest.raises(InputError, match="no expressive motion"):
        ExpressionSpace().fit({})
    ragged = [ExpressiveMotion(np.zeros((50, n)), np.zeros((50, 1))) for n in (6, 9)]
    with pytest.raises(InputError, match="differ in their dimensions"):
        ExpressionSpace().fit({"happy": ragged})
    with pytest.raises(InputError, match="unknown emotion 'hapy'"):
        SPACE.sample("hapy", 1.0, np.random.default_rng(0))


def test_one_emotion_alone_has_the_curves_it_has_in_the_space_of_all() -> None:
    alone = space_of("sad")
    assert alone.emotions == ("sad",)
    np.testing.assert_allclose(alone.curves_["sad"][0], SPACE.curves_["sad"][0], atol=1e-9)
    np.testing.assert_array_equal(alone.carried_["sad"][0], SPACE.carried_["sad"][0])
