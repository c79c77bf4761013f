from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.metrics.sync import is_undetectable, lag_of_best_correlation, onset, onset_lag

FPS = 25.0
TIMES = np.arange(100) / FPS


def mouth(times: np.ndarray) -> np.ndarray:
    return 6 + 4 * np.sin(8 * times) + 2 * np.sin(13 * times + 1)


@given(st.floats(-0.16, 0.16))
def test_a_shift_is_found_again_to_a_few_milliseconds(seconds: float) -> None:
    lag = lag_of_best_correlation(mouth(TIMES), mouth(TIMES - seconds), FPS)
    assert lag == pytest.approx(1000 * seconds, abs=5.0)


def test_a_still_mouth_has_no_lag() -> None:
    assert np.isnan(lag_of_best_correlation(mouth(TIMES), np.full(100, 3.0), FPS))


def test_a_rate_of_zero_is_refused() -> None:
    with pytest.raises(InputError, match="above 0"):
        lag_of_best_correlation(mouth(TIMES), mouth(TIMES), 0.0)


def test_the_onset_is_half_way_up_between_frames() -> None:
    opening = np.clip((TIMES - 1.0) * 40, 0, 8)  # 0 at 1.0 s, 8 mm at 1.2 s
    assert onset(opening, TIMES, first_phone=1.0) == pytest.approx(1.1)
    late = np.clip((TIMES - 1.03) * 40, 0, 8)
    assert onset_lag(opening, late, TIMES, first_phone=1.0) == pytest.approx(30.0, abs=1.0)


def test_a_mouth_that_does_not_open_has_no_onset() -> None:
    assert np.isnan(onset(np.full(100, 2.0), TIMES, first_phone=1.0))
    assert np.isnan(onset(np.linspace(0, 0.5, 100), TIMES, first_phone=1.0))


@pytest.mark.parametrize(("lag", "fine"), [(45.0, True), (45.1, False), (-125.0, True), (-125.1, False)])
def test_thresholds_of_bt1359(lag: float, fine: bool) -> None:
    assert is_undetectable(lag) is fine
