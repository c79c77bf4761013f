import numpy as np

from mien.face.cast.noise import layered_noise, smoothstep, value_noise


def test_noise_is_the_same_for_the_same_seed_and_stays_in_range() -> None:
    points = np.random.default_rng(0).uniform(-100, 100, (500, 3))
    assert np.array_equal(value_noise(points, 5.0, 3), value_noise(points, 5.0, 3))
    assert not np.array_equal(value_noise(points, 5.0, 3), value_noise(points, 5.0, 4))
    assert np.abs(layered_noise(points, 20.0, 1)).max() <= 1
    assert value_noise(points, 5.0, 3).std() > 0.1


def test_smoothstep_falls_where_low_is_the_larger() -> None:
    assert smoothstep(0, 1, np.array([-1.0, 0.5, 2.0])).tolist() == [0, 0.5, 1]
    assert smoothstep(1, 0, np.array([-1.0, 2.0])).tolist() == [1, 0]
