"""Action units: the table, the names, what they add up to, and that they reach the default face."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.channels import ALL, ARKIT, WEIGHTS
from mien.core.errors import InputError
from mien.core.facs import (
    action_units,
    au_channels,
    basic_expressions,
    channels_of_units,
    expression_channels,
    is_unit,
    missing_channels,
    unit_track,
)
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face

# Table 1 of Frydrych et al. 2003, and the units that the project adds to it.
PAPER = (1, 2, 4, 5, 41, 6, 7, 9, 10, 11, 12, 15, 16, 17, 20, 23, 24, 25, 26, 27, 38, 39)
MORE = (13, 14, 17, 18, 22, 24, 28, 43, 45, 46)
MIDDLE = {"AU17", "AU18", "AU22", "AU25", "AU26", "AU27", "AU28"}


def test_every_unit_of_the_paper_and_those_beyond_are_there() -> None:
    assert set(action_units()) == {f"AU{number}" for number in (*PAPER, *MORE)}
    assert {code for code, unit in action_units().items() if not unit.left} == MIDDLE


@pytest.mark.parametrize("code", list(action_units()))
def test_every_unit_moves_the_default_face(code: str) -> None:
    face = load_face()
    moved = {name for part in face.parts for name in part.targets}
    assert missing_channels([code], moved) == {}
    assert au_channels(code)


def test_sides_mirror_each_other_and_scale() -> None:
    for unit in action_units().values():
        assert {n.replace("Left", "Right"): w for n, w in unit.left.items()} == dict(unit.right)
    assert au_channels("AU12R", 0.25) == {"mouthSmileRight": 0.25}
    assert au_channels("12l") == {"mouthSmileLeft": 1.0}
    assert au_channels("AU15RB", 0.5) == {"mouthFrownRight": pytest.approx(0.15)}


def test_left_and_right_together_are_the_unit_of_both_sides() -> None:
    for code, unit in action_units().items():
        if unit.left:
            assert channels_of_units({code + "L": 0.5, code + "R": 0.5}) == pytest.approx(
                channels_of_units({code: 0.5})
            )


def test_shared_channels_add_up_and_stop_at_one() -> None:
    assert channels_of_units({"AU25": 1.0, "AU16": 0.9})["mouthLowerDownLeft"] == 1.0
    assert channels_of_units({"AU26": 0.5})["jawOpen"] == pytest.approx(0.2)


def test_names_that_are_no_units_are_refused() -> None:
    with pytest.raises(InputError, match="unknown action unit 'AU99'"):
        au_channels("AU99")
    with pytest.raises(InputError, match="has no sides"):
        au_channels("AU26L")
    with pytest.raises(InputError, match=r"from 0 to 1, not 1\.5"):
        au_channels("AU12", 1.5)
    assert not is_unit("mouthSmileLeft")


def test_basic_expressions_stay_in_range_and_ask_for_known_units() -> None:
    assert set(basic_expressions()) == {"happiness", "sadness", "surprise", "fear", "anger", "disgust"}
    for name in basic_expressions():
        weights = expression_channels(name)
        assert set(weights) <= set(WEIGHTS)
        assert all(0 < weight <= 1 for weight in weights.values())
        half = expression_channels(name, 0.5)
        assert all(half[channel] <= weight for channel, weight in weights.items())
    with pytest.raises(InputError, match="did you mean 'anger'"):
        expression_channels("angre")


def test_a_track_of_units_equals_the_units_frame_by_frame() -> None:
    names = ("AU1L", "AU1R", "AU12", "AU9R", "jawOpen", "headYaw")
    values = np.random.default_rng(0).uniform(0, 1, (5, len(names)))
    track = unit_track(ChannelTrack(names, values, FrameRate.of(25)))
    assert track.names == ALL
    for row, moved in zip(values, track.values, strict=True):
        expected = channels_of_units(dict(zip(names[:4], row[:4], strict=True)))
        expected["jawOpen"], expected["headYaw"] = row[4], row[5]
        assert {n: v for n, v in zip(ALL, moved, strict=True) if abs(v) > 1e-9} == pytest.approx(expected)
    with pytest.raises(InputError, match=r"AU12.*frame 1"):
        unit_track(ChannelTrack(("AU12",), [[0.0], [1.2]], FrameRate.of(25)))


def test_an_arkit_face_is_told_what_it_must_drop() -> None:
    lacking = missing_channels(action_units(), ARKIT)
    assert lacking["AU38"] == ("noseFlareLeft", "noseFlareRight")
    assert "AU1" not in lacking  # both brows are one ARKit channel
    assert "AU12" not in lacking
    assert set(missing_channels(["AU1L"], ARKIT)) == {"AU1L"}
