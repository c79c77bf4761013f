"""The paper's model: what made the data must be found again, and Algorithm 1 must equal its plain reading."""

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take
from mien.motion.mouth.coarticulation import Coarticulation, CoarticulationSettings, Step, blend_weight, plan
from mien.motion.mouth.coarticulation_reference import synthesise_plainly
from mien.motion.mouth.influence_curves import PENALTIES, WeightPairs, fit_curves, fitting_cost, pool, weights_of
from mien.motion.mouth.key_visemes import geometric_median
from mien.motion.mouth.phone_samples import Area, areas, sample_phones
from mien.motion.mouth.recorded_mouths import RecordedMouth
from tests.motion.speaking import NAMES, takes, tier

PHONES = ("SIL", "AA", "S", "K", "UW", "IY")
EASE = np.array([[1.0, 0.0], [0.0, 0.0], [-3.0, 3.0], [2.0, -2.0]])
"""1 - 3t² + 2t³ and 3t² - 2t³ by powers of t: the curves that make the recordings below."""
UNEVEN = np.array([[1.0, 0.0, 0.0], [-1.5, 1.0, 0.5], [0.2, 0.6, -0.8], [0.3, -1.0, 0.7]])
"""Of a triphone: they do not sum to one, and are not below zero in 0..1."""


def curve_made_takes(noise=0.0, count=12):
    """Takes at 120 frames per second: every diphone moves from key to key by `EASE`."""
    random = np.random.default_rng(3)
    basis = np.linalg.qr(random.standard_normal((36, 5)))[0].T * 10
    keys = dict(zip(PHONES, random.standard_normal((6, 5)), strict=True))
    made = []
    for number in range(count):
        labels = ["SIL", *random.choice(PHONES[1:], 12).tolist(), "SIL"]
        phones = tier(labels, 12 / 120)  # middles fall on frames
        times = np.arange(len(labels) * 12) / 120
        pose = np.empty((len(times), 5))
        for frame in range(len(times)):
            place = min(max((frame - 6) / 12, 0), len(labels) - 1)
            first = min(int(place), len(labels) - 2)
            start, end = np.polynomial.polynomial.polyval(place - first, EASE)
            pose[frame] = start * keys[labels[first]] + end * keys[labels[first + 1]]
        positions = (pose @ basis).reshape(-1, 12, 3) + noise * random.standard_normal((len(times), 12, 3))
        track = MarkerTrack(NAMES, positions, FrameRate.of(120))
        sound = Audio.silence(len(times) / 120, 8000)
        made.append(Take(f"t{number}", sound, track, "", Tier("words", ()), phones, "mediapipe-218"))
    return made, {phone: key @ basis for phone, key in keys.items()}


SETTINGS = CoarticulationSettings(key_per_phone=True)


def test_known_curves_and_keys_are_found_again():
    made, keys = curve_made_takes()
    model = Coarticulation(SETTINGS).fit(made)
    learned = {
        phones: curves for phones, curves in model.curves_.items() if len(phones) == 2 and phones[0] != phones[1]
    }
    assert len(learned) > 15
    for curves in learned.values():
        assert np.allclose(curves.coefficients, EASE, atol=1e-6)
    for phone, key in keys.items():
        assert np.allclose(model.space_.decode(model.keys_[phone][None])[0], key, atol=1e-6)


def test_recordings_come_back_from_their_phones():
    made, _ = curve_made_takes()
    model = Coarticulation(CoarticulationSettings(key_per_phone=True, triphones=False)).fit(made)
    take = made[0]
    times = take.markers.rate.times(len(take.markers))[6:-6]
    unlike = [a.label != b.label for a, b in zip(take.phones, take.phones.intervals[1:], strict=False)]
    error = model.synthesise(take.phones, times) - take.markers.positions[6:-6]
    place = ((np.arange(len(times))) // 12).clip(0, len(unlike) - 1)
    assert np.abs(error[np.array(unlike)[place]]).max() < 1e-6


def test_with_noise_curves_come_near():
    made, _ = curve_made_takes(noise=0.1, count=40)
    model = Coarticulation(SETTINGS).fit(made)
    t = np.linspace(0, 1, 21)
    truth = np.polynomial.polynomial.polyval(t, EASE).T
    misses = [np.abs(c.at(t) - truth).max() for p, c in model.curves_.items() if len(p) == 2 and p[0] != p[1]]
    assert np.median(misses) < 0.02
    assert max(misses) < 0.1


def triphone_area(times, noise=0.0, seed=0):
    random = np.random.default_rng(seed)
    samples = random.standard_normal((3, 5))
    weights = np.stack([np.polynomial.polynomial.polyval(times, column) for column in UNEVEN.T], axis=1)
    assert weights.min() >= -1e-12
    poses = weights @ samples + noise * random.standard_normal((len(times), 5))
    return Area(("AA", "S", "K"), samples, times, poses)


def test_triphone_weights_and_curves_are_found_again():
    found = []
    for seed in range(5):
        area = triphone_area(np.linspace(0.03 + seed / 100, 0.97, 17), seed=seed)
        found.append((area.phones, area.times, weights_of(area)))
    curves = fit_curves(pool(found)["AA", "S", "K"], 3)
    assert np.allclose(curves.coefficients, UNEVEN, atol=1e-6)
    assert curves.pairs == 85


def test_triphone_weights_are_never_negative():
    area = triphone_area(np.linspace(0, 1, 50), noise=0.5)
    weights = weights_of(area)
    assert weights.min() == 0.0
    free = np.linalg.lstsq(area.samples.T, area.poses.T, rcond=None)[0].T
    assert free.min() < 0
    inside = (free > 1e-9).all(axis=1)
    assert np.allclose(weights[inside], free[inside])


def test_steadiness_draws_wild_weights_to_the_cosine():
    samples = np.array([[1.0, 0.0], [1.0, 1e-4]])  # nearly alike: plain least squares runs wild
    times = np.array([0.25, 0.5])
    area = Area(("AA", "S"), samples, times, np.array([[1.0, 0.02], [1.0, -0.01]]))
    assert np.abs(weights_of(area)).max() > 50
    calm = weights_of(area, steadiness=0.1)
    assert np.abs(calm - [[0.85, 0.15], [0.5, 0.5]]).max() < 0.05


def test_the_degree_that_made_the_weights_costs_least():
    random = np.random.default_rng(0)
    t = random.uniform(0, 1, (40, 60))
    made = {
        (str(k), "x"): WeightPairs(
            t[k], np.polynomial.polynomial.polyval(t[k], EASE).T + 0.05 * random.standard_normal((60, 2))
        )
        for k in range(40)
    }
    cost = fitting_cost([made], least_pairs=12)
    assert cost.shape == (len(PENALTIES), 6)
    assert (np.diff(cost[0]) <= 1e-9).all()  # without penalty a higher degree never fits worse
    assert cost[0, 1] > 1.5 * cost[0, 2]  # a big step down to degree 3
    assert cost[3, 1] - cost[3, 2] > 10 * (cost[3, 2] - cost[3, 3])  # and hardly one beyond it
    assert np.allclose(cost[1], cost[0] + 0.1 * (cost[3] - cost[0]))


def test_the_penalty_of_a_degree_is_lambda_times_the_squared_coefficients():
    times = np.linspace(0.02, 0.98, 24)
    made = {
        ("A", str(k)): WeightPairs(times, np.stack([1 - times + 0.1 * k * times**2, times - 0.2 * k], axis=1))
        for k in range(3)
    }
    cost = fitting_cost([made], least_pairs=4, degrees=(1, 2), penalties=(0.0, 0.25, 4.0))
    for column, degree in enumerate((1, 2)):
        powers = times[:, None] ** np.arange(degree + 1)
        fits = [np.linalg.lstsq(powers, pairs.weights, rcond=None)[0] for pairs in made.values()]
        left = sum(((powers @ fit - p.weights) ** 2).sum() for fit, p in zip(fits, made.values(), strict=True))
        size = sum((fit**2).sum() for fit in fits)
        assert size > 1  # so that a penalty left out, or taken off, is seen
        assert np.allclose(cost[:, column], [left, left + 0.25 * size, left + 4.0 * size], atol=1e-9)
    assert PENALTIES == (0.0, 1e-5, 5e-5, 1e-4)  # Deng et al. 2006, Fig. 9


def test_samples_stand_in_the_middle_and_areas_between_them():
    phones = tier(["AA", "S", "K"], 0.1)
    times = np.arange(30) / 100
    mouth = RecordedMouth(phones, times, np.zeros((30, 36)))
    said = sample_phones(mouth, np.arange(30.0)[:, None], 0.01)
    assert said.middles.tolist() == [5, 15, 25]
    (first, second), (third,) = list(areas([said], 2)), list(areas([said], 3))
    assert first.phones == ("AA", "S")
    assert first.times.tolist() == pytest.approx(np.linspace(0, 1, 11).tolist())
    assert second.samples[:, 0].tolist() == [15, 25]
    assert third.phones == ("AA", "S", "K")
    assert third.poses[:, 0].tolist() == list(range(5, 26))


def test_no_area_reaches_over_a_phone_that_was_not_seen():
    phones = tier(["AA", "S", "K"], 0.1)
    times = np.concatenate([np.arange(10), np.arange(20, 30)]) / 100
    said = sample_phones(RecordedMouth(phones, times, np.zeros((20, 36))), np.zeros((20, 1)), 0.01)
    assert said.labels == ("AA", "K")
    assert list(areas([said], 2)) == []


def test_geometric_median_is_hardly_moved_by_bad_samples():
    random = np.random.default_rng(0)
    good = random.standard_normal((80, 3))
    bad = np.full((20, 3), 50.0)
    assert np.linalg.norm(geometric_median(np.concatenate([good, bad])) - good.mean(axis=0)) < 1.0


def test_plan_follows_algorithm_1():
    known = {("a", "b", "c"): 1, ("b", "c", "d"): 1, ("e", "f"): 1}
    found = plan(["a", "b", "c", "d", "e", "f"], known | {("d", "e"): 1}, {})
    assert found == [
        Step("triphone", None, 0),
        Step("triphone", 0, 1),  # two triphones overlap: blended
        Step("triphone", 1),  # the last triphone covers it, so the diphone is skipped
        Step("diphone"),
        Step("diphone"),
    ]


def test_unknown_pairs_back_off_through_their_classes_to_the_cosine():
    steps = plan(["P", "AA", "S"], {}, {("closed", "open"): 1})
    assert [step.source for step in steps] == ["class", "cosine"]


def test_blend_falls_from_one_to_nothing_faster_with_n():
    t = np.linspace(0, 1, 11)
    plain, steep = blend_weight(t, 0.5, 0.0), blend_weight(t, 0.5, 3.0)
    assert plain.tolist() == pytest.approx((1 - t).tolist())
    assert (np.diff(steep) < 0).all()
    assert steep[3] > plain[3]
    assert steep[7] < plain[7]


def _joined(first, second):
    return Tier("phones", first.intervals + second.shifted(first.intervals[-1].end).intervals)


@pytest.mark.parametrize(
    "settings",
    [
        CoarticulationSettings(least_pairs=8),
        CoarticulationSettings(least_pairs=8, triphones=False, class_back_off=True),
        CoarticulationSettings(least_pairs=30, class_back_off=True, blend_mu=0.3, blend_n=2.0, key_per_phone=True),
    ],
)
def test_synthesis_equals_the_plain_reading(settings):
    made = takes(25)
    model = Coarticulation(settings).fit(made)
    sources = set()
    new = takes(3, seed=99)
    for phones in (made[0].phones, made[7].phones, new[0].phones, _joined(made[1].phones, new[1].phones)):
        times = np.linspace(-0.1, phones.intervals[-1].end + 0.1, 173)
        plainly = synthesise_plainly(model, phones, times)
        assert np.abs(model.synthesise(phones, times) - plainly).max() < 1e-12 * np.abs(plainly).max()
        sources |= set(model.evidence(phones))
    assert len(sources) > 1


def test_hand_made_keys_replace_those_found():
    made = takes(10)
    wanted = made[0].markers.positions[0] + 1.0
    model = Coarticulation(keys={"open": wanted}).fit(made)
    free = Coarticulation().fit(made)
    assert np.allclose(model.keys_["AA"], model.space_.encode(wanted.reshape(1, -1))[0])
    assert np.allclose(model.keys_["AA"], model.keys_["AW"])
    assert np.allclose(model.keys_["S"], free.keys_["S"])


def test_every_phone_has_a_key_and_unknown_ones_are_refused():
    model = Coarticulation().fit(takes(10))
    assert len(model.keys_) == 40
    assert np.isfinite(np.array(list(model.keys_.values()))).all()
    with pytest.raises(InputError, match="unknown phone 'QX'"):
        model.synthesise(tier(["SIL", "QX", "SIL"]), np.arange(3) / 25)
    with pytest.raises(InputError, match="no take to learn from"):
        Coarticulation().fit([])
    with pytest.raises(InputError, match="0 < mu < 1"):
        CoarticulationSettings(blend_mu=1.0)
