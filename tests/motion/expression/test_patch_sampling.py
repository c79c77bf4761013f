"""Patches of a curve: smooth, new, never stuck, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.motion.drift import smooth_drift
from mien.motion.expression.patch_sampling import PatchSettings, sample_patches


def source(seconds: float = 60.0, seed: int = 0) -> np.ndarray:
    times = np.arange(round(seconds * 120)) / 120
    return np.stack([smooth_drift(times, 0.2, np.random.default_rng([seed, k])) for k in range(3)], axis=1) + 4.0


def test_the_new_curve_is_made_of_the_source() -> None:
    rows = source()
    new = sample_patches([rows], 1200, np.random.default_rng(1))
    alone = new.share == 0
    np.testing.assert_array_equal(new.of(rows)[alone], rows[new.before[alone]])
    steps = np.diff(new.before)
    assert (steps == 1).mean() > 0.9  # inside a patch time runs as in the source


def test_joints_are_no_faster_than_the_source() -> None:
    rows = source()
    new = sample_patches([rows], 2400, np.random.default_rng(2)).of(rows)
    speed, fastest = (np.linalg.norm(np.diff(curve, axis=0), axis=1).max() for curve in (new, rows))
    assert speed < 1.1 * fastest


def test_without_a_fitting_patch_the_nearest_is_taken_and_told() -> None:
    rows = np.cumsum(np.random.default_rng(3).standard_normal((300, 3)), axis=0)  # no place is like another
    new = sample_patches([rows], 3000, np.random.default_rng(3), PatchSettings(tolerance=0.0))
    assert len(new.before) == 3000
    assert new.stretched + new.copied >= new.joints  # whatever was not simply continued had to be stretched to


def test_a_patch_that_only_goes_on_is_passed_over_while_another_fits() -> None:
    rows = np.sin(np.arange(600) / 120 * 2 * np.pi)[:, None] + 2.0  # every place comes five times
    papers = PatchSettings(velocity=0.0, fresh=False)
    plain, ours = (sample_patches([rows], 12000, np.random.default_rng(4), s) for s in (papers, PatchSettings()))
    assert plain.copied > 0
    assert (ours.copied, ours.stretched) == (0, 0)


def test_patches_do_not_run_across_the_ends_of_pieces() -> None:
    pieces = [source(1.0, seed) + 10 * seed for seed in range(4)]
    new = sample_patches(pieces, 2000, np.random.default_rng(5))
    rows = np.repeat(np.arange(4), 120)
    inside = new.share == 0
    same_piece = rows[new.before[1:]] == rows[new.before[:-1]]
    going_on = (np.diff(new.before) == 1) & inside[1:] & inside[:-1]
    assert same_piece[going_on].all()


def test_patches_come_from_every_piece_and_lie_where_its_rows_are() -> None:
    lengths = (120, 20, 90, 150)  # the second is shorter than a patch: none of it can be used
    pieces = [np.full((length, 1), 5.0) + 1e-6 * k for k, length in enumerate(lengths)]
    new = sample_patches(pieces, 6000, np.random.default_rng(8))
    piece_of = np.repeat(np.arange(4), lengths)
    assert set(piece_of[new.before].tolist()) == {0, 2, 3}
    alone = new.share == 0
    joined = np.concatenate(pieces)
    np.testing.assert_array_equal(new.of(joined)[alone], joined[new.before[alone]])
    last_rows = new.before[piece_of[new.before] == 3]
    assert 230 <= last_rows.min() < 260  # from its first rows
    assert 350 < last_rows.max() < 380  # to its last


def test_the_same_seed_is_the_same_curve_and_a_longer_one_begins_alike() -> None:
    rows = source()
    one, again, longer = (sample_patches([rows], n, np.random.default_rng(6)) for n in (500, 500, 900))
    np.testing.assert_array_equal(one.before, again.before)
    np.testing.assert_array_equal(one.before, longer.before[:500])


def test_refusals() -> None:
    with pytest.raises(InputError, match="longer than 20 samples"):
        sample_patches([np.zeros((20, 3))], 10, np.random.default_rng(0))
    with pytest.raises(InputError, match="one sample or more"):
        sample_patches([np.zeros((60, 3))], 0, np.random.default_rng(0))
    with pytest.raises(InputError, match="patches are longer than their zone"):
        PatchSettings(patch=5, zone=5)
