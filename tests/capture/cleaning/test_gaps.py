import numpy as np
import pytest

from mien.capture.cleaning.gaps import GapSettings, drop_unseen, fill_gaps
from mien.core.errors import InputError
from tests.capture.cleaning.grid import Grid
from tests.capture.cleaning.synthetic import NAMES, REST, column, speaking, with_positions

LIP, CHIN = column("lip_l"), column("chin")


def error(filled: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(((filled - truth) ** 2).sum(axis=-1).mean()))


def test_a_short_gap_is_bridged_by_a_curve_and_reported() -> None:
    truth = speaking(fps=120, frames=400)
    holes = truth.positions.copy()
    holes[200:203, LIP] = np.nan
    filled, repairs = fill_gaps(with_positions(truth, holes))
    assert [str(r) for r in repairs] == ["gap: lip_l, frames 200..202: spline"]
    assert error(filled.positions[200:203, LIP], truth.positions[200:203, LIP]) < 0.05


def test_a_long_gap_is_told_by_the_other_markers() -> None:
    truth = speaking()
    holes = truth.positions.copy()
    holes[50:80, LIP] = np.nan
    filled, repairs = fill_gaps(with_positions(truth, holes))
    assert [str(r) for r in repairs] == ["gap: lip_l, frames 50..79: PCA of the other markers"]
    straight = np.linspace(truth.positions[49, LIP], truth.positions[80, LIP], 32)[1:-1]
    assert error(straight, truth.positions[50:80, LIP]) > 2
    assert error(filled.positions[50:80, LIP], truth.positions[50:80, LIP]) < 0.1


def test_gaps_at_both_ends_are_told_by_the_other_markers() -> None:
    truth = speaking()
    holes = truth.positions.copy()
    holes[:15, CHIN] = np.nan
    holes[-20:, LIP] = np.nan
    filled, repairs = fill_gaps(with_positions(truth, holes))
    assert [(r.markers, r.first, r.last) for r in repairs] == [(("chin",), 0, 14), (("lip_l",), 100, 119)]
    assert error(filled.positions[:15, CHIN], truth.positions[:15, CHIN]) < 0.1
    assert error(filled.positions[-20:, LIP], truth.positions[-20:, LIP]) < 0.1


def test_filling_meets_the_seen_frames_without_a_step() -> None:
    truth = speaking(noise=0.1)
    holes = truth.positions.copy()
    holes[50:80, LIP] = np.nan
    filled = fill_gaps(with_positions(truth, holes))[0].positions[:, LIP]
    steps = np.linalg.norm(np.diff(filled, axis=0), axis=1)
    assert steps[[49, 79]].max() < 1.5 * np.delete(steps, [49, 79]).max()


def test_what_was_seen_is_not_touched() -> None:
    truth = speaking(noise=0.1)
    holes = truth.positions.copy()
    holes[np.random.default_rng(1).random(holes.shape[:2]) < 0.1] = np.nan
    filled, _ = fill_gaps(with_positions(truth, holes))
    seen = np.isfinite(holes)
    np.testing.assert_array_equal(filled.positions[seen], holes[seen])
    assert np.isfinite(filled.positions).all()
    assert error(filled.positions, truth.positions) < 0.3


def test_examples_of_other_takes_fill_what_one_take_cannot_know() -> None:
    truth = speaking()
    holes = truth.positions.copy()
    holes[12:, CHIN] = np.nan  # seen only while the face rests
    alone, _ = fill_gaps(with_positions(truth, holes))
    taught, _ = fill_gaps(with_positions(truth, holes), examples=speaking(200).positions[60:])
    assert error(alone.positions[:, CHIN], truth.positions[:, CHIN]) > 2
    assert error(taught.positions[:, CHIN], truth.positions[:, CHIN]) < 0.2


def test_a_lost_face_is_bridged_held_or_left() -> None:
    truth = speaking()
    holes = truth.positions.copy()
    holes[:12] = np.nan
    holes[60] = np.nan
    holes[80:90] = np.nan
    filled, repairs = fill_gaps(with_positions(truth, holes))
    assert [str(r) for r in repairs] == [
        "lost face: all markers, frames 0..11: nearest seen frame held",
        "lost face: all markers, frames 60..60: spline",
        "lost face: all markers, frames 80..89: left empty: too long to fill",
    ]
    np.testing.assert_array_equal(filled.positions[3], truth.positions[12])
    assert error(filled.positions[60], truth.positions[60]) < 0.3
    assert np.isnan(filled.positions[80:90]).all()
    assert np.isfinite(np.delete(filled.positions, np.s_[80:90], axis=0)).all()


def test_an_end_lost_for_too_long_is_left() -> None:
    holes = speaking().positions.copy()
    holes[90:] = np.nan
    _, repairs = fill_gaps(with_positions(speaking(), holes), GapSettings(hold=1.0))
    assert repairs[0].method == "left empty: too long to fill"


def test_markers_never_or_hardly_seen_are_dropped_and_said() -> None:
    holes = speaking().positions.copy()
    holes[:, CHIN] = np.nan
    holes[6:, LIP] = np.nan
    track, dropped = drop_unseen(with_positions(speaking(), holes), least_seen=0.2)
    assert len(track.names) == len(NAMES) - 2
    assert [str(d) for d in dropped] == [
        "dropped: lip_l, frames 0..119: seen in 5%",
        "dropped: chin, frames 0..119: never seen",
    ]
    with pytest.raises(InputError, match="never seen cannot be filled: chin; drop them first"):
        fill_gaps(with_positions(speaking(), holes))
    with pytest.raises(InputError, match="no marker is seen"):
        drop_unseen(with_positions(speaking(), np.full_like(holes, np.nan)), 0.2)


def test_examples_of_other_markers_are_refused() -> None:
    with pytest.raises(InputError, match=r"expected shape \(n, 26, 3\), got \(5, 2, 3\)"):
        fill_gaps(speaking(), examples=np.zeros((5, 2, 3)))


def test_one_frame_without_holes_and_a_marker_seen_once() -> None:
    one = with_positions(speaking(1), REST[None])
    assert fill_gaps(one) == (one, ())
    holes = speaking(10).positions.copy()
    holes[1:, CHIN] = np.nan
    filled, _ = fill_gaps(with_positions(speaking(10), holes))
    assert np.isfinite(filled.positions).all()


@pytest.mark.data
def test_real_lip_motion_is_filled_better_by_the_other_markers_than_by_a_curve(grid: Grid) -> None:
    by_curve, by_others = [], []
    for name in grid.names[:6]:
        truth = grid.normalised(name)
        marker = truth.names.index("14")
        holes = truth.positions.copy()
        holes[30:45, marker] = np.nan
        track = with_positions(truth, holes)
        curve = fill_gaps(track, GapSettings(short=1.0))[0]
        others = fill_gaps(track)[0]
        by_curve.append(error(curve.positions[30:45, marker], truth.positions[30:45, marker]))
        by_others.append(error(others.positions[30:45, marker], truth.positions[30:45, marker]))
    assert np.mean(by_others) < 0.5 < np.mean(by_curve)


@pytest.mark.data
def test_a_real_take_in_which_the_tracker_lost_the_face(grid: Grid) -> None:
    filled, repairs = fill_gaps(grid.normalised("bbizzn"))
    assert [str(r) for r in repairs] == ["lost face: all markers, frames 0..11: nearest seen frame held"]
    assert np.isfinite(filled.positions).all()
