from itertools import pairwise

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.correction import SPANS, Correction, CorrectionSettings, articulation_about
from mien.motion.mouth.influence import InfluenceCurves, InfluenceSettings, PartsInTime, influence_of
from tests.motion.speaking import tier

PHONES = tier(["SIL", "B", "AY", "S", "UW", "M", "SIL"], 0.09)
TIMES = np.arange(40) / 50


def random_curves(strands=3, components=2, seed=0):
    model = InfluenceCurves(InfluenceSettings(strands=strands, neighbours=3))
    described = model.place(PHONES, TIMES).described.shape[1]
    model._begin(described, components, np.random.default_rng(seed))
    model.weights_ = model.weights_.astype(float) + 0.2 * np.random.default_rng(seed + 1).standard_normal(
        model.weights_.shape
    )
    model.shapes_ = model.shapes_.astype(float)
    return model


def test_slopes_are_those_of_the_error():
    model = random_curves()
    parts = model.place(PHONES, TIMES)
    wanted = np.random.default_rng(5).standard_normal((len(TIMES), 2))

    def error():
        return 0.5 * ((model.components(parts) - wanted) ** 2).sum() / len(wanted)

    found = model._slopes(parts, wanted)
    random = np.random.default_rng(6)
    for array, slope in zip((model.weights_, model.shapes_), found, strict=True):
        for _ in range(25):
            place = tuple(int(random.integers(n)) for n in array.shape)
            kept, step = array[place], 1e-5
            array[place] = kept + step
            above = error()
            array[place] = kept - step
            below = error()
            array[place] = kept
            assert slope[place] == pytest.approx((above - below) / (2 * step), abs=2e-6)


def test_influences_share_out_every_instant():
    model = random_curves()
    parts = model.place(PHONES, TIMES)
    shares = influence_of(model.curves(parts.described), parts)
    assert shares.min() >= 0
    assert np.allclose(shares.sum(axis=1), 1)


def test_parts_pull_most_near_their_own_time():
    model = InfluenceCurves(InfluenceSettings(strands=1, neighbours=3, lead=0.0))
    model._begin(model.place(PHONES, TIMES).described.shape[1], 1, np.random.default_rng(0))
    model.weights_[1:] = 0
    middles = np.array([phone.middle for phone in PHONES if phone.label in ("B", "S", "UW", "M")])
    parts = model.place(PHONES, middles)
    shares = influence_of(model.curves(parts.described), parts)[:, :, 0]
    assert (shares.argmax(axis=1) == 3).all()


def test_motion_does_not_depend_on_the_frame_rate():
    model = random_curves()
    slow = model.components(model.place(PHONES, np.arange(15) / 25))
    fast = model.components(model.place(PHONES, np.arange(30) / 50))
    assert np.array_equal(slow, fast[::2])


def test_motion_made_by_known_curves_is_learned():
    truth = random_curves(strands=2, components=2, seed=3)
    random = np.random.default_rng(0)
    phones = [p for p in articulation_table().parts if p != "SIL"]
    settings = InfluenceSettings(strands=4, neighbours=3, epochs=12, lead=0.025)
    model = InfluenceCurves(settings)
    tiers = [tier(["SIL", *random.choice(phones, 12), "SIL"], random.uniform(0.06, 0.14)) for _ in range(60)]
    times = [np.arange(0, t.intervals[-1].end, 0.02) for t in tiers]
    made = [truth.components(truth.place(t, at)) for t, at in zip(tiers, times, strict=True)]
    model.fit([model.place(t, at) for t, at in zip(tiers[:50], times[:50], strict=True)], np.concatenate(made[:50]))
    new = np.concatenate([model.components(model.place(t, at)) for t, at in zip(tiers[50:], times[50:], strict=True)])
    missed = ((new - np.concatenate(made[50:])) ** 2).sum() / ((np.concatenate(made[50:])) ** 2).sum()
    assert missed < 0.02  # of the power, in utterances that were not learned


def test_the_same_seed_gives_the_same_bits():
    model = random_curves()
    wanted = model.components(model.place(PHONES, TIMES))
    settings = InfluenceSettings(strands=3, neighbours=3, epochs=2, batch=16)
    first, second = (InfluenceCurves(settings).fit([model.place(PHONES, TIMES)], wanted) for _ in range(2))
    assert np.array_equal(first.weights_, second.weights_)
    assert np.array_equal(first.shapes_, second.shapes_)
    assert np.array_equal(first.weights_, first.weights_.astype(np.float32))  # files keep single precision


def test_joined_utterances_are_those_they_were():
    model = random_curves()
    other = tier(["SIL", "P", "OY", "SIL"], 0.2)
    joined = PartsInTime.join([model.place(PHONES, TIMES), model.place(other, TIMES)])
    rows = np.array([70, 3, 41])
    alone = np.concatenate([model.components(model.place(t, TIMES)) for t in (PHONES, other)])
    assert np.allclose(model.components(joined.frames(rows)), alone[rows], atol=1e-5)


def test_gaps_between_phones_are_pauses():
    gap = Tier("phones", (Interval(0.1, 0.2, "M"), Interval(0.5, 0.6, "AY")))
    filled = Tier("phones", (Interval(0.1, 0.2, "M"), Interval(0.2, 0.5, "SIL"), Interval(0.5, 0.6, "AY")))
    assert parts_of(gap).symbols.tolist() == parts_of(filled).symbols.tolist()
    assert parts_of(gap).starts.tolist() == parts_of(filled).starts.tolist()
    with pytest.raises(InputError, match="unknown phone 'X'"):
        parts_of(tier(["X"]))


def test_articulation_about_an_instant_is_its_mean_over_each_span():
    table = articulation_table()
    seen = articulation_about(PHONES, np.array([0.31]), 0.5).reshape(len(SPANS) - 1, -1)
    parts = parts_of(PHONES)
    for span, (start, end) in enumerate(pairwise(SPANS)):
        at = 0.31 + start + (np.arange(4000) + 0.5) / 4000 * (end - start)
        place = np.searchsorted(parts.starts, at, side="right") - 1
        symbols = parts.symbols[np.clip(place, 0, None)]
        assert np.allclose(seen[span, : len(table.features)], table.values[symbols].mean(axis=0), atol=2e-3)
        assert seen[span, len(table.features) :].sum() == pytest.approx(0.5)


def test_silence_lies_outside_the_phones():
    pause = articulation_table().values[articulation_table().parts["SIL"][0]]
    for phones in (PHONES, Tier("phones", ())):
        seen = articulation_about(phones, np.array([-5.0, 9.0]), 0.0).reshape(2, len(SPANS) - 1, -1)
        assert np.allclose(seen, pause)


def test_slopes_of_the_correction_are_those_of_the_error():
    correction = Correction(CorrectionSettings(hidden=(6, 5), dropout=0.0, decay=0.0))
    random = np.random.default_rng(0)
    layers = [(random.standard_normal((a, b)), random.standard_normal(b)) for a, b in ((7, 6), (6, 5), (5, 2))]
    inputs, wanted = random.standard_normal((30, 7)), random.standard_normal((30, 2))
    correction.layers_ = [layers]
    flat = [array for layer in layers for array in layer]
    for array, slope in zip(flat, correction._slopes(layers, inputs, wanted, random), strict=True):
        place = tuple(int(random.integers(n)) for n in array.shape)
        kept, errors = array[place], []
        for step in (1e-6, -1e-6):
            array[place] = kept + step
            errors.append(0.5 * ((correction.components(inputs) - wanted) ** 2).sum() / 30)
        array[place] = kept
        assert slope[place] == pytest.approx((errors[0] - errors[1]) / 2e-6, abs=1e-6)


def test_the_correction_learns_what_a_line_cannot():
    random = np.random.default_rng(0)
    inputs = random.uniform(-1, 1, (3000, 2))
    wanted = np.abs(inputs[:, :1] * inputs[:, 1:]) * 10
    model = Correction(CorrectionSettings(hidden=(32, 16), networks=2, dropout=0.0, epochs=30, batch=64))
    model.fit(inputs, wanted)
    line = np.linalg.lstsq(np.c_[inputs, np.ones(3000)], wanted, rcond=None)[1][0] / 3000
    assert ((model.components(inputs) - wanted) ** 2).mean() < 0.05 * line
