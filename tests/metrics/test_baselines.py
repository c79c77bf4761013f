"""Each baseline finds again what it should be able to learn; one contract for all."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.metrics.baselines import Cosine, MeanPose, Model, Ridge
from mien.metrics.compared_models import contenders
from mien.metrics.context import PhoneContext
from mien.metrics.dominance import Dominance
from mien.metrics.perceptron import Perceptron
from mien.metrics.scored_takes import prepare
from mien.metrics.trajectory import correlation, separation
from tests.metrics.synthetic import MOUTH, spoken, takes

SMALL = {
    "mean pose": MeanPose,
    "cosine": Cosine,
    "dominance": lambda: Dominance(iterations=15),
    "ridge": Ridge,
    "perceptron": lambda: Perceptron(units=16, epochs=10, batch=20),
}


@pytest.mark.parametrize("name", SMALL)
def test_every_baseline_keeps_the_contract(name: str) -> None:
    model: Model = SMALL[name]()
    learned = takes(8, noise=0.05)
    assert model.fit(learned) is model
    new = spoken("new", ("me", "ta"))
    times = np.arange(0, 1.3, 1 / 60)
    mouth = model.synthesise(new.phones, times)
    assert mouth.shape == (len(times), len(MOUTH), 3)
    assert np.isfinite(mouth).all()
    again = SMALL[name]().fit(learned).synthesise(new.phones, times)
    assert np.array_equal(mouth, again)
    strange = Tier("phones", (Interval(0.0, 0.4, "SIL"), Interval(0.4, 0.6, "ZH"), Interval(0.6, 1.0, "SIL")))
    assert np.isfinite(model.synthesise(strange, times)).all()
    assert np.isfinite(model.synthesise(Tier("phones", ()), times)).all()


@pytest.mark.parametrize("name", SMALL)
def test_nothing_to_learn_from_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="to learn from"):
        SMALL[name]().fit([])


@pytest.mark.parametrize(("name", "least"), [("cosine", 0.99), ("dominance", 0.9), ("ridge", 0.9), ("perceptron", 0.9)])
def test_a_simple_mouth_is_learned(name: str, least: float) -> None:
    model = SMALL[name]().fit(takes(16))
    new = prepare(spoken("new", ("tea", "ma", "ta"), duration=0.17))
    mouth = model.synthesise(new.take.phones, new.times)
    opening = new.sites.opening
    recorded, learned = (separation(p, *opening)[new.speech] for p in (new.positions, mouth))
    assert correlation(recorded, learned) > least


def test_the_mean_pose_is_the_mean_of_all_frames() -> None:
    learned = takes(3)
    flat = np.concatenate([take.markers.positions for take in learned])
    assert MeanPose().fit(learned).synthesise(learned[0].phones, np.zeros(1))[0] == pytest.approx(flat.mean(axis=0))


def test_cosine_passes_half_way_between_keys_half_way_between_middles() -> None:
    model = Cosine().fit(takes(4))
    tier = Tier("phones", (Interval(0.0, 0.2, "M"), Interval(0.2, 0.4, "AA")))
    mouth = model.synthesise(tier, np.array([0.0, 0.1, 0.2, 0.3, 0.4])).reshape(5, -1)
    key, other = model.keys_["M"], model.keys_["AA"]
    assert mouth == pytest.approx(np.stack([key, key, (key + other) / 2, other, other]))


def test_the_slope_of_the_dominance_fit_is_right() -> None:
    from scipy.optimize import check_grad

    model = Dominance(iterations=1).fit(takes(3))
    take = takes(3)[0]
    times = take.markers.rate.times(len(take.markers))
    pull = model._pulls(take.phones, times)
    count = len(model.symbols_)
    start = np.concatenate([np.zeros(count), np.full(2 * count, np.log(15.0))])
    point = start + np.random.default_rng(0).normal(0, 0.3, 3 * count)
    scores = np.random.default_rng(1).normal(0, 5, (len(times), 4))
    error = check_grad(
        lambda x: model._cost(x, start, pull, scores)[0], lambda x: model._cost(x, start, pull, scores)[1], point
    )
    assert error < 1e-3 * np.linalg.norm(model._cost(point, start, pull, scores)[1])


def test_context_sees_a_pause_outside_the_phones() -> None:
    tier = Tier("phones", (Interval(0.0, 0.04, "M"), Interval(0.08, 0.12, "T")))
    context = PhoneContext(0.04).fit([tier])
    number = {symbol: place for place, symbol in enumerate(context.symbols_)}
    looks = context.encode(tier, np.array([0.04])) % len(context.symbols_)
    assert looks.tolist() == [[number["M"], number["SIL"], number["T"]]]


def test_an_unknown_row_is_refused() -> None:
    with pytest.raises(InputError, match="unknown model 'rigde': did you mean 'ridge'"):
        contenders(["rigde"])


def test_the_rows_are_the_baselines_then_what_mien_learns() -> None:
    rows = contenders()
    assert list(rows)[: len(SMALL)] == list(SMALL)
    assert len(rows) > len(SMALL)
    for make in rows.values():
        assert make() is not make()
