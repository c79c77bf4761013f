import numpy as np
import pytest

from mien.capture.cleaning.faults import find_faults, frozen
from mien.capture.cleaning.impossible_motion import guess_axes, guess_units, say_axes
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from tests.capture.cleaning.grid import GROUPS as GRID_GROUPS
from tests.capture.cleaning.grid import Grid
from tests.capture.cleaning.synthetic import GROUPS, NAMES, column, head_motion, recorded, speaking, with_positions

FACE = recorded(speaking(noise=0.1), head_motion())


def only(track: MarkerTrack, seconds: float | None = None) -> str:
    faults = find_faults(track, GROUPS, seconds)
    assert len(faults) == 1, [str(fault) for fault in faults]
    return f"{faults[0].severity}: {faults[0]}"


def test_a_good_recording_has_no_faults() -> None:
    assert find_faults(FACE, GROUPS, 4.8) == ()


@pytest.mark.parametrize(("factor", "unit"), [(0.001, "metres"), (0.1, "centimetres")])
def test_units(factor: float, unit: str) -> None:
    assert guess_units(with_positions(FACE, FACE.positions * factor)) == unit
    assert only(with_positions(FACE, FACE.positions * factor)).startswith("repair: expected millimetres, got a face")
    assert unit in only(with_positions(FACE, FACE.positions * factor))


def test_an_unknown_unit_is_refused() -> None:
    assert only(with_positions(FACE, FACE.positions * 40)).startswith(
        "refuse: expected millimetres, got a face 7.31e+03"
    )


@pytest.mark.parametrize(
    ("order", "signs", "said"),
    [
        ((0, 2, 1), (1, -1, 1), "x is x, y is z, z is -y of the file: another convention, such as z up"),
        ((2, 1, 0), (-1, 1, 1), "x is z, y is y, z is -x of the file: another convention, such as z up"),
        ((0, 1, 2), (-1, 1, 1), "x is -x, y is y, z is z of the file: left-handed axes, or a mirrored picture"),
        ((0, 1, 2), (1, -1, -1), "x is x, y is -y, z is -z of the file: another convention, such as z up"),
    ],
)
def test_axes(order: tuple[int, ...], signs: tuple[int, ...], said: str) -> None:
    turned = with_positions(FACE, FACE.positions[:, :, list(order)] * signs)
    assert said in only(turned)
    matrix = guess_axes(turned, GROUPS)
    assert matrix is not None
    np.testing.assert_allclose(turned.positions @ matrix.T, FACE.positions)
    assert say_axes(matrix) in said


def test_a_face_that_stands_askew_is_said_and_not_turned() -> None:
    half = np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]]) @ np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])
    askew = with_positions(FACE, speaking().positions @ half.T @ half.T)
    if guess_axes(askew, GROUPS) is None:
        assert only(askew).startswith("warn: axes cannot be checked")
    unseen = FACE.positions.copy()
    unseen[:, column("nose")] = np.nan
    assert guess_axes(with_positions(FACE, unseen), GROUPS) is None


def test_missing_and_damaged_numbers_name_marker_and_frame() -> None:
    positions = FACE.positions.copy()
    positions[7:9, column("chin")] = 0.0
    positions[3, column("nose"), 1] = np.inf
    positions[:, column("brow_l1")] = np.nan
    positions[30:34] = np.nan
    said = [f"{f.severity}: {f}" for f in find_faults(with_positions(FACE, positions), GROUPS)]
    assert said == [
        "repair: marker 'nose', frame 3: infinite positions in 1 frames, taken as not seen: a damaged file",
        "repair: marker 'chin', frame 7: positions exactly at the origin in 2 frames, taken as not seen: how some "
        "systems write 'not seen'",
        "repair: frame 30: no marker is seen up to frame 33: the tracker lost the face",
        "repair: marker 'brow_l1': never seen: fallen off, or not tracked",
    ]


def test_a_frozen_marker_and_a_frozen_camera() -> None:
    positions = FACE.positions.copy()
    positions[40:60, column("chin")] = positions[39, column("chin")]
    stuck = with_positions(FACE, positions)
    assert frozen(stuck) == [(column("chin"), 40, 59)]
    assert "repair: marker 'chin', frame 40: does not move at all up to frame 59" in only(stuck)
    positions = FACE.positions.copy()
    positions[40:43] = positions[39]
    assert "warn: frame 40: every marker stands exactly still up to frame 42" in only(with_positions(FACE, positions))


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (4.85, None),
        (
            4.5,
            "warn: frame 112: 120 frames at 25 a second are 4.80 s, the sound is 4.50 s: one of them starts",
        ),
        (
            4.0,
            "refuse: frame 100: 120 frames at 25 a second are 4.80 s, the sound is 4.00 s: the rate is likely 30",
        ),
        (
            1.0,
            "refuse: frame 25: 120 frames at 25 a second are 4.80 s, the sound is 1.00 s: the rate is likely 120",
        ),
        (
            9.0,
            "refuse: frame 120: 120 frames at 25 a second are 4.80 s, the sound is 9.00 s: another take's sound",
        ),
    ],
)
def test_sound_and_motion_of_different_length(seconds: float, said: str | None) -> None:
    if said is None:
        assert find_faults(FACE, GROUPS, seconds) == ()
    else:
        assert only(FACE, seconds).startswith(said)


def test_nothing_there_is_refused_alone() -> None:
    rate = FrameRate.of(25)
    empty = MarkerTrack(NAMES, np.zeros((0, len(NAMES), 3)), rate)
    assert only(empty) == "refuse: expected motion, got 0 frames of 26 markers"
    unseen = with_positions(FACE, np.full(FACE.positions.shape, np.nan))
    assert only(unseen).startswith("refuse: no marker is seen in any frame")


def test_markers_that_the_layout_names_and_the_file_lacks_are_refused() -> None:
    fewer = MarkerTrack(NAMES[1:], FACE.positions[:, 1:], FACE.rate)
    assert only(fewer).startswith("refuse: marker 'forehead': the layout names this marker")


def test_a_rate_of_zero_never_becomes_a_track() -> None:
    with pytest.raises(InputError, match="above 0 and at most 1000 frames per second, not 0"):
        FrameRate.of(0)


@pytest.mark.data
def test_real_takes_have_no_faults_but_the_lost_face(grid: Grid) -> None:
    for name in grid.names[:300:30]:
        faults = find_faults(grid.millimetres(name), GRID_GROUPS, grid.audio(name).duration)
        assert [f for f in faults if f.severity != "warn"] == [], (name, [str(f) for f in faults])
    lost = find_faults(grid.millimetres("bbizzn"), GRID_GROUPS)
    assert str(lost[0]) == "frame 0: no marker is seen up to frame 11: the tracker lost the face"
