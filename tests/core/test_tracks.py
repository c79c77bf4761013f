from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack

FPS = FrameRate.of(25)


def test_every_fault_of_a_channel_track_is_said_at_once() -> None:
    with pytest.raises(InputError, match=r"names repeat: \['a'\].*2 names for 3 columns"):
        ChannelTrack(("a", "a"), np.zeros((4, 3)), FPS)


def test_a_number_that_is_not_finite_is_located() -> None:
    values = np.zeros((4, 2))
    values[3, 1] = np.nan
    with pytest.raises(InputError, match="nan in frame 3, channel 'jawOpen'"):
        ChannelTrack(("mouthClose", "jawOpen"), values, FPS)


def test_values_cannot_be_changed_afterwards() -> None:
    source = np.zeros((2, 1))
    track = ChannelTrack(("jawOpen",), source, FPS)
    source[0, 0] = 1
    assert track.channel("jawOpen")[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        track.values[0, 0] = 1


def test_an_unknown_channel_gets_a_guess() -> None:
    with pytest.raises(InputError, match="did you mean 'jawOpen'"):
        ChannelTrack(("jawOpen",), [[0]], FPS).channel("jawopen")


def test_select_orders_and_fills_with_zero() -> None:
    track = ChannelTrack(("a", "b"), [[1, 2]], FPS).select(("b", "c"))
    assert track.values.tolist() == [[2, 0]]


def test_markers_may_be_unseen_but_have_three_coordinates() -> None:
    MarkerTrack(("chin",), np.full((2, 1, 3), np.nan), FPS)
    with pytest.raises(InputError, match="three coordinates"):
        MarkerTrack(("chin",), np.zeros((2, 1, 2)), FPS)


def test_equality_is_by_content() -> None:
    one = MarkerTrack(("chin",), np.full((2, 1, 3), np.nan), FPS)
    assert one == MarkerTrack(("chin",), np.full((2, 1, 3), np.nan), FPS)
    assert one != MarkerTrack(("nose",), np.full((2, 1, 3), np.nan), FPS)
