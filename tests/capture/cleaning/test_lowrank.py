import numpy as np

from mien.capture.cleaning.lowrank import LowRank


def poses(frames: int = 60, noise: float = 0.0) -> np.ndarray:
    """Twelve coordinates that move in three ways only."""
    random = np.random.default_rng(0)
    return random.normal(size=(frames, 3)) @ random.normal(size=(3, 12)) * 2 + 5 + random.normal(0, noise, (frames, 12))


def test_hidden_coordinates_of_a_low_rank_pose_are_found() -> None:
    known = poses()
    model = LowRank.fit(known[:50], 3)
    hidden = known[55].copy()
    hidden[[1, 4, 8]] = np.nan
    np.testing.assert_allclose(model.rebuild(hidden), known[55], atol=1e-3)
    assert model.noise <= 1e-3


def test_noise_is_measured() -> None:
    assert abs(LowRank.fit(poses(600, 0.3), 3).noise - 0.3) < 0.02


def test_holes_in_every_frame_are_filled_in_turn() -> None:
    known = poses(60, 0.02)
    holed = known.copy()
    random = np.random.default_rng(2)
    for row in holed:
        row[random.choice(12, 2, replace=False)] = np.nan
    model = LowRank.fit(holed, 3)
    rebuilt = np.stack([model.rebuild(row) for row in holed])
    holes = np.isnan(holed)
    assert np.abs(rebuilt - known)[holes].mean() < 0.2 * np.abs(known - np.nanmean(holed, axis=0))[holes].mean()


def test_nothing_seen_gives_the_mean_and_few_frames_a_low_rank() -> None:
    model = LowRank.fit(poses(4), 10)
    np.testing.assert_allclose(model.rebuild(np.full(12, np.nan)), model.mean)
    assert len(model.components) == 1
