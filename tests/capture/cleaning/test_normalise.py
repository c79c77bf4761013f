import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.capture.cleaning.normalise import apply, best_similarity, least_squares, neutral_frame, three_point
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from tests.capture.cleaning.grid import OUTER_LIPS, RIGID, Grid
from tests.capture.cleaning.synthetic import (
    GROUPS,
    NAMES,
    REST,
    column,
    head_motion,
    recorded,
    speaking,
    with_positions,
)


def test_three_points_take_out_the_head_and_return_it() -> None:
    still, head = speaking(), head_motion()
    result = three_point(recorded(still, head), "nose", "eye_l", "eye_r", REST)
    np.testing.assert_allclose(result.track.positions, still.positions, atol=1e-9)
    np.testing.assert_allclose(result.head, head, atol=1e-9)


def test_three_points_put_the_nose_on_the_reference_and_the_eyes_in_its_plane() -> None:
    noisy = recorded(speaking(noise=0.5), head_motion())
    normalised = three_point(noisy, "nose", "eye_l", "eye_r", REST).track.positions
    nose, left, right = (normalised[:, column(n)] for n in ("nose", "eye_l", "eye_r"))
    np.testing.assert_allclose(nose, np.tile(REST[column("nose")], (len(nose), 1)), atol=1e-9)
    along = (left - right) / np.linalg.norm(left - right, axis=1, keepdims=True)
    np.testing.assert_allclose(along, np.tile([1.0, 0.0, 0.0], (len(nose), 1)), atol=1e-9)
    normal = np.cross(REST[column("eye_l")] - REST[column("nose")], REST[column("eye_r")] - REST[column("nose")])
    np.testing.assert_allclose((left - nose) @ normal, 0, atol=1e-6)


@pytest.mark.parametrize("scale", [False, True])
def test_least_squares_takes_out_the_head_and_returns_it(scale: bool) -> None:
    still, head = speaking(), head_motion(scale=0.05 if scale else 0.0)
    result = least_squares(recorded(still, head), GROUPS.rigid, REST, scale=scale)
    np.testing.assert_allclose(result.track.positions, still.positions, atol=1e-9)
    np.testing.assert_allclose(result.head, head, atol=1e-9)


def test_head_times_normalised_is_what_was_recorded_with_noise_too() -> None:
    noisy = recorded(speaking(noise=0.5), head_motion(scale=0.03))
    for result in (
        three_point(noisy, "nose", "eye_l", "eye_r", REST),
        least_squares(noisy, GROUPS.rigid, REST),
        least_squares(noisy, GROUPS.rigid, REST, scale=True, robust=True),
    ):
        np.testing.assert_allclose(apply(result.head, result.track.positions), noisy.positions, atol=1e-9)


def test_many_markers_shake_the_face_less_than_three() -> None:
    still = speaking()
    noisy = recorded(speaking(noise=0.5), head_motion())
    error = {
        "three": three_point(noisy, "nose", "eye_l", "eye_r", REST).track.positions - still.positions,
        "many": least_squares(noisy, GROUPS.rigid, REST).track.positions - still.positions,
    }
    rms = {name: float(np.sqrt((e[:, column("chin")] ** 2).sum(axis=1).mean())) for name, e in error.items()}
    assert rms["many"] < 0.8 * rms["three"]


def test_missing_rigid_markers_are_done_without_until_two_are_left() -> None:
    track, head = speaking(), head_motion()
    positions = recorded(track, head).positions.copy()
    positions[10, [column("nose"), column("temple_l")]] = np.nan
    positions[20, [column(name) for name in GROUPS.rigid[2:]]] = np.nan
    result = least_squares(with_positions(track, positions), GROUPS.rigid, REST)
    np.testing.assert_allclose(result.head[10], head[10], atol=1e-9)
    assert result.unplaced == (20,)
    assert np.isnan(result.track.positions[20]).all()
    three = three_point(with_positions(track, positions), "nose", "eye_l", "eye_r", REST)
    assert three.unplaced == (10, 20)


def test_robust_fit_shrugs_off_a_rigid_marker_that_flew_away() -> None:
    track, head = speaking(noise=0.05), head_motion()
    positions = recorded(track, head).positions.copy()
    positions[30, column("forehead")] += [25.0, 0.0, 0.0]
    spoilt = with_positions(track, positions)
    plain = least_squares(spoilt, GROUPS.rigid, REST).track.positions[30, column("chin")]
    robust = least_squares(spoilt, GROUPS.rigid, REST, robust=True).track.positions[30, column("chin")]
    truth = track.positions[30, column("chin")]
    assert np.linalg.norm(plain - truth) > 3
    assert np.linalg.norm(robust - truth) < 0.5


def test_a_mirror_image_is_never_fitted() -> None:
    fitted = best_similarity(REST, REST * [-1.0, 1.0, 1.0], np.ones(len(REST)), scale=False)
    assert np.linalg.det(fitted[:3, :3]) == pytest.approx(1.0)


def test_refusals_name_what_is_wrong() -> None:
    track = speaking(10)
    with pytest.raises(InputError, match="unknown marker 'nosse': did you mean 'nose'"):
        three_point(track, "nosse", "eye_l", "eye_r", REST)
    with pytest.raises(InputError, match=r"expected shape \(26, 3\), got \(3, 3\)"):
        least_squares(track, GROUPS.rigid, REST[:3])
    with pytest.raises(InputError, match="three rigid markers not in a line, has 2"):
        least_squares(track, GROUPS.rigid[:2], REST)
    in_line = REST.copy()
    in_line[column("nose")] = (in_line[column("eye_l")] + in_line[column("eye_r")]) / 2
    with pytest.raises(InputError, match="stand in a line"):
        three_point(track, "nose", "eye_l", "eye_r", in_line)


def test_neutral_frame_is_at_rest_and_not_in_a_closure_in_passing() -> None:
    still = speaking(noise=0.02)
    positions = still.positions.copy()
    # A /p/: the lips pressed tighter than at rest, the corners and the chin away from rest.
    positions[60, column("lip_l")] = positions[60, column("lip_u")]
    positions[60, [column("chin"), column("corner_l")]] += [0.0, -6.0, 0.0]
    positions[4, column("brow_l1")] = np.nan
    chosen = neutral_frame(recorded(with_positions(still, positions), head_motion()), "lip_u", "lip_l", GROUPS.rigid)
    assert chosen <= 10
    assert chosen != 4


def test_neutral_frame_keeps_to_the_candidates() -> None:
    allowed = np.zeros(120, dtype=bool)
    allowed[70:90] = True
    assert 70 <= neutral_frame(speaking(), "lip_u", "lip_l", GROUPS.rigid, allowed) < 90
    with pytest.raises(InputError, match="no neutral frame can be chosen"):
        neutral_frame(speaking(), "lip_u", "lip_l", GROUPS.rigid, np.zeros(120, dtype=bool))


def test_a_track_of_one_frame() -> None:
    one = MarkerTrack(NAMES, REST[None], FrameRate.of(25))
    assert neutral_frame(one, "lip_u", "lip_l", GROUPS.rigid) == 0
    np.testing.assert_allclose(least_squares(one, GROUPS.rigid, REST).head[0], np.eye(4), atol=1e-12)


@pytest.mark.data
def test_scoring_normalisation_of_the_shared_recordings(grid: Grid) -> None:
    """Against a similarity fit worked out another way: scipy's rotation, and the scale from its definition."""
    name = grid.names[5]
    recorded_track = grid.millimetres(name)
    rigid = [recorded_track.names.index(n) for n in RIGID]
    target = grid.reference[rigid]
    assert np.linalg.norm(target[0] - target[3]) == pytest.approx(90.0)
    normalised = grid.normalised(name).positions
    lips = [recorded_track.names.index(n) for n in OUTER_LIPS]
    for frame in (0, 40, 74):
        points = recorded_track.positions[frame]
        middle, aim = points[rigid].mean(axis=0), target.mean(axis=0)
        turn, _ = Rotation.align_vectors(target - aim, points[rigid] - middle)
        turned = turn.apply(points - middle)
        factor = (turned[rigid] * (target - aim)).sum() / (turned[rigid] ** 2).sum()
        np.testing.assert_allclose(normalised[frame][lips], (factor * turned + aim)[lips], atol=1e-6)


@pytest.mark.data
def test_neutral_frame_of_real_takes_is_closed_and_outside_speech(grid: Grid) -> None:
    for name in grid.names[10:50:10]:
        track = grid.millimetres(name)
        frame = neutral_frame(track, "13", "14", RIGID)
        one, other = (track.positions[frame, track.names.index(n)] for n in ("13", "14"))
        assert np.linalg.norm(one - other) < 0.75, name
