import numpy as np
import pytest

from mien.capture.cleaning.normalise import least_squares
from mien.capture.cleaning.perspective import scaled, to_millimetres
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from tests.capture.cleaning.grid import Grid
from tests.capture.cleaning.synthetic import GROUPS, REST, recorded, speaking, with_positions

EYES = ("eye_r", "eye_l")


def in_pixels(mirrored: bool = False) -> MarkerTrack:
    """The face before a camera: x right in the picture (the speaker's left), y down, z away from the camera."""
    track = speaking()
    signs = np.array([-1.0 if mirrored else 1.0, -1.0, -1.0])
    return with_positions(track, track.positions * signs / 1.5 + [180.0, 144.0, 0.0])


@pytest.mark.parametrize("mirrored", [False, True])
def test_pixels_come_back_as_the_face_they_were_made_from(mirrored: bool) -> None:
    metric = to_millimetres(in_pixels(mirrored), EYES, mirrored=mirrored)
    assert metric.mm_per_pixel == pytest.approx(1.5)
    laid = least_squares(metric.track, GROUPS.rigid, REST)
    np.testing.assert_allclose(laid.track.positions, speaking().positions, atol=1e-9)
    np.testing.assert_allclose(laid.head[:, :3, :3], np.tile(np.eye(3), (120, 1, 1)), atol=1e-9)


def test_the_pictures_right_is_the_speakers_left_and_y_is_up_and_z_forward() -> None:
    track = to_millimetres(in_pixels(), EYES).track
    left, right, nose, chin = (track.positions[0, track.names.index(n)] for n in ("eye_l", "eye_r", "nose", "chin"))
    assert left[0] > right[0]
    assert nose[1] > chin[1]
    assert nose[2] > left[2]


def test_the_assumption_is_said() -> None:
    metric = to_millimetres(in_pixels(), EYES, millimetres=92, frame=3)
    assert "92 mm between eye_r and eye_l (60.00 pixels in frame 3); pictures not mirrored" in metric.assumption


def test_a_track_without_the_two_markers_is_refused() -> None:
    unseen = in_pixels().positions.copy()
    unseen[:, speaking().names.index("eye_l")] = np.nan
    track = MarkerTrack(speaking().names, unseen, FrameRate.of(25))
    with pytest.raises(InputError, match="never seen apart"):
        to_millimetres(track, EYES)
    with pytest.raises(InputError, match="unknown marker"):
        to_millimetres(track, ("33", "263"))
    with pytest.raises(InputError, match="frame 500 is not in a track of 120"):
        to_millimetres(in_pixels(), EYES, frame=500)
    with pytest.raises(InputError, match="above 0 mm, not 0"):
        to_millimetres(in_pixels(), EYES, millimetres=0)


@pytest.mark.data
def test_grid_face_is_of_human_size_and_looks_forward(grid: Grid) -> None:
    track = scaled(grid.pixels(grid.names[0]), grid.mm_per_pixel)
    left, right, nose, chin = (track.positions[0, track.names.index(n)] for n in ("263", "33", "1", "152"))
    assert np.linalg.norm(left - right) == pytest.approx(90)
    assert left[0] - right[0] > 80
    assert 50 < nose[1] - chin[1] < 120
    assert nose[2] - (left[2] + right[2]) / 2 > 20


def test_recorded_helper_moves_the_face() -> None:
    shift = np.tile(np.eye(4), (120, 1, 1))
    shift[:, 0, 3] = 7.0
    np.testing.assert_allclose(recorded(speaking(), shift).positions[:, :, 0] - speaking().positions[:, :, 0], 7.0)
