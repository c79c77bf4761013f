import numpy as np
import pytest

from mien.capture.cleaning.spikes import SpikeSettings, remove_spikes
from tests.capture.cleaning.grid import Grid
from tests.capture.cleaning.synthetic import column, speaking, with_positions

LIP, CHIN, BROW = column("lip_l"), column("chin"), column("brow_l1")


@pytest.mark.parametrize(
    ("frames", "fps"), [((40,), 25), ((40, 41), 25), ((40, 41, 42), 25), (tuple(range(200, 212)), 120)]
)
def test_a_marker_that_flies_off_for_a_few_frames_is_emptied(frames: tuple[int, ...], fps: float) -> None:
    track = speaking(400, fps, noise=0.1)
    positions = track.positions.copy()
    positions[list(frames), CHIN] += [6.0, -5.0, 4.0]
    emptied, repairs = remove_spikes(with_positions(track, positions))
    assert [(r.markers, r.first, r.last) for r in repairs] == [(("chin",), frames[0], frames[-1])]
    assert np.isnan(emptied.positions[list(frames), CHIN]).all()
    assert np.isnan(emptied.positions).sum() == 3 * len(frames)


def test_spikes_of_several_markers_and_at_the_ends() -> None:
    track = speaking(noise=0.1)
    positions = track.positions.copy()
    positions[0, LIP] += [9.0, 0.0, 0.0]
    positions[60, BROW] += [0.0, 0.0, 12.0]
    positions[119, CHIN] -= [0.0, 9.0, 0.0]
    _, repairs = remove_spikes(with_positions(track, positions))
    assert [(r.markers, r.first, r.last) for r in repairs] == [
        (("lip_l",), 0, 0),
        (("brow_l1",), 60, 60),
        (("chin",), 119, 119),
    ]
    assert "mm off its path: emptied" in repairs[1].method


def test_a_closure_that_takes_one_frame_is_no_spike() -> None:
    """The lower lip and all that hangs on it jump up by 9 mm for a single frame, as for a fast /b/."""
    track = speaking(noise=0.1)
    positions = track.positions.copy()
    for name, share in {"lip_l": 1.0, "lip_ll": 0.9, "lip_lr": 0.9, "outer_l": 0.9, "chin": 0.7}.items():
        positions[50, column(name), 1] += 9.0 * share
    _, repairs = remove_spikes(with_positions(track, positions))
    assert repairs == ()


def test_a_marker_that_moves_off_and_stays_is_no_spike() -> None:
    track = speaking(noise=0.1)
    positions = track.positions.copy()
    positions[60:, BROW] += [0.0, 8.0, 0.0]
    assert remove_spikes(with_positions(track, positions))[1] == ()


def test_clean_motion_and_motion_with_holes_stay_bit_for_bit() -> None:
    track = speaking(noise=0.2)
    positions = track.positions.copy()
    positions[20:30, LIP] = np.nan
    positions[50] = np.nan
    holed = with_positions(track, positions)
    assert remove_spikes(holed) == (holed, ())


def test_settings_decide() -> None:
    track = speaking(noise=0.05)
    positions = track.positions.copy()
    positions[40, CHIN] += [2.0, 0.0, 0.0]
    spiky = with_positions(track, positions)
    assert remove_spikes(spiky)[1] == ()
    assert len(remove_spikes(spiky, SpikeSettings(jump=1.0, surprise=1.0))[1]) == 1


def test_too_short_to_judge() -> None:
    assert remove_spikes(speaking(2))[1] == ()


@pytest.mark.data
def test_no_spike_is_seen_in_real_speech_and_planted_ones_are(grid: Grid) -> None:
    for name in grid.names[3:120:12]:
        track = grid.normalised(name)
        assert remove_spikes(track)[1] == (), name
        positions = track.positions.copy()
        lip, brow = track.names.index("14"), track.names.index("105")
        positions[38, lip] += [0.0, -9.0, 0.0]
        positions[50:52, brow] += [7.0, 7.0, 0.0]
        _, repairs = remove_spikes(with_positions(track, positions))
        assert [(r.markers, r.first, r.last) for r in repairs] == [(("14",), 38, 38), (("105",), 50, 51)], name
