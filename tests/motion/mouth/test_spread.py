import numpy as np
import pytest

from mien.motion.mouth.spread import MOST_GAIN, RecordedSpread, instants_about


def recorded(times):
    return np.stack([np.sin(3 * times) + 0.4 * np.sin(19 * times), np.cos(5 * times)], axis=1)


def flattened(times):
    """What a model answers that halves what is quick, and all of the second component."""
    return np.stack([0.9 * np.sin(3 * times) + 0.3 * np.sin(19 * times), 0.8 * np.cos(5 * times)], axis=1) + 2.0


def test_size_and_speed_are_given_back():
    pieces = [np.arange(0, 8, 0.04) + start for start in (0.0, 20.0, 40.0)]
    spread = RecordedSpread().fit([recorded(t) for t in pieces], [flattened(instants_about(t)) for t in pieces])
    at = np.arange(100, 120, 0.04)
    wanted, made = recorded(at), spread.of(flattened, at)
    assert made.std(axis=0) == pytest.approx(wanted.std(axis=0), rel=0.05)
    speeds = [np.sqrt((np.diff(curve, axis=0) ** 2).mean(axis=0)) for curve in (made, wanted)]
    assert speeds[0] == pytest.approx(speeds[1], rel=0.1)
    assert made.mean(axis=0) == pytest.approx(flattened(at).mean(axis=0), abs=0.05)  # the mean stays
    rest = np.array([1.0, 2.0])
    about_rest = RecordedSpread().fit(
        [recorded(t) for t in pieces], [flattened(instants_about(t)) for t in pieces], rest
    )
    assert about_rest.gain_.tolist() == spread.gain_.tolist()
    assert about_rest.of(lambda times: np.tile(rest, (len(times), 1)), at) == pytest.approx(np.tile(rest, (len(at), 1)))


def test_what_is_not_known_is_not_made_larger_without_bounds():
    times = np.arange(0, 8, 0.04)
    spread = RecordedSpread().fit([recorded(times)], [0.01 * flattened(instants_about(times))])
    assert spread.gain_.max() == MOST_GAIN
    still = RecordedSpread().fit([recorded(times)], [np.zeros((3 * len(times), 2))])
    assert np.isfinite(still.of(flattened, times)).all()
    assert still.gain_.tolist() == [1, 1]
