import numpy as np
import pytest

from mien.capture.cleaning.swaps import mend_swaps
from mien.core.errors import InputError
from tests.capture.cleaning.grid import Grid
from tests.capture.cleaning.synthetic import REST, column, speaking, with_positions


def swapped(track, stretches):
    positions = track.positions.copy()
    for one, other, first, last in stretches:
        pair = [track.names.index(one), track.names.index(other)]
        positions[first : last + 1, pair] = positions[first : last + 1, pair[::-1]]
    return with_positions(track, positions)


@pytest.mark.parametrize(
    "stretches",
    [
        [("lip_ul", "lip_ll", 40, 55)],
        [("corner_l", "lip_ll", 0, 20)],
        [("brow_l1", "brow_l2", 100, 119)],
        [("brow_l1", "brow_l2", 30, 30)],
        [("lip_ul", "outer_u", 30, 44), ("chin", "chin_l", 35, 60)],
        [("lip_ul", "lip_ll", 20, 30), ("lip_ul", "lip_ll", 70, 90)],
    ],
)
def test_exchanged_markers_get_their_names_back(stretches) -> None:
    truth = speaking(noise=0.1)
    mended, repairs = mend_swaps(swapped(truth, stretches))
    assert mended == truth
    told = sorted((frozenset(r.markers), r.first, r.last) for r in repairs)
    assert told == sorted((frozenset((a, b)), first, last) for a, b, first, last in stretches)


def test_a_swap_that_starts_in_a_gap_is_undone_up_to_the_gap() -> None:
    truth = speaking(noise=0.1)
    broken = swapped(truth, [("brow_l1", "brow_l2", 40, 60)]).positions.copy()
    broken[36:42, [column("brow_l1"), column("brow_l2")]] = np.nan
    mended, repairs = mend_swaps(with_positions(truth, broken))
    np.testing.assert_array_equal(mended.positions[42:], truth.positions[42:])
    assert [(r.first, r.last) for r in repairs] == [(42, 60)]


def test_lips_that_meet_and_pass_each_other_are_not_exchanged() -> None:
    truth = speaking(noise=0.1)
    positions = truth.positions.copy()
    # The lower lip rolls over the upper one by 1.5 mm, then opens wide.
    positions[60:64, column("lip_l"), 1] = positions[60:64, column("lip_u"), 1] + 1.5
    track = with_positions(truth, positions)
    assert mend_swaps(track) == (track, ())


def test_most_of_a_take_swapped_needs_a_rest_pose() -> None:
    truth = speaking(noise=0.1)
    broken = swapped(truth, [("brow_l1", "brow_l2", 30, 119)])
    assert mend_swaps(broken)[0] != truth
    assert mend_swaps(broken, rest=REST)[0] == truth
    with pytest.raises(InputError, match=r"expected shape \(26, 3\)"):
        mend_swaps(truth, rest=REST[:2])


@pytest.mark.data
def test_real_speech_has_no_swaps_and_planted_ones_are_undone(grid: Grid) -> None:
    for name in grid.names[3:120:12]:
        track = grid.normalised(name)
        assert mend_swaps(track)[1] == (), name
        mended, repairs = mend_swaps(swapped(track, [("61", "17", 40, 52), ("105", "66", 10, 20)]))
        assert mended == track, name
        assert len(repairs) == 2, name
