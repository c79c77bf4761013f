from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.metrics.face_track import shown_landmarks
from mien.motion.mouth.mouth_space import ChannelSpace, MarkerSpace, mouth_space_of, space_from
from tests.motion.speaking import NAMES, takes

CHANNELS = ("jawOpen", "mouthPucker", "mouthClose", "mouthLowerDownLeft", "mouthLowerDownRight")


def with_channels(take, names=CHANNELS, seed=0):
    values = np.random.default_rng(seed).uniform(0, 0.5, (len(take.markers), len(names)))
    return replace(take, channels=ChannelTrack(names, values, take.markers.rate))


def test_rows_lie_as_far_apart_as_the_lips_that_one_sees():
    space = ChannelSpace.of(CHANNELS)
    random = np.random.default_rng(1)
    weights = random.uniform(0, 1, (40, len(CHANNELS)))
    rows = space.rows_from(weights)
    assert np.allclose(space.motion_of(rows), weights)
    track = shown_landmarks(ChannelTrack(CHANNELS, weights, takes(1)[0].markers.rate))
    places = track.positions[:, [track.names.index(name) for name in ("2.2", "2.3")]]
    assert np.allclose(space.opening_of(rows), places[:, 0, 1] - places[:, 1, 1], atol=1e-3)
    far = np.linalg.norm(rows[:20] - rows[20:], axis=1) / np.sqrt(space.points)
    assert (far > 1).mean() > 0.8  # mm: nothing is scaled away
    assert np.linalg.norm(space.rows_from(np.eye(len(CHANNELS))[:1])) > 4 * np.sqrt(space.points)  # an open jaw


def test_weights_stay_in_range_and_lips_do_not_pass_each_other():
    space = ChannelSpace.of(CHANNELS)
    wild = space.rows_from(np.random.default_rng(2).uniform(-0.5, 1.5, (200, len(CHANNELS))))
    way = space.rows_from(np.array([[0.025, 0, 0, 0, 0]]))[0]
    held = space.parted(wild, way / (space.opening_of(way[None])[0] - space.gap[0]))
    assert space.motion_of(held).min() >= 0
    assert space.motion_of(held).max() <= 1
    assert space.opening_of(held).min() > -1e-9


def test_takes_with_channels_are_learned_in_them():
    made = [with_channels(take, seed=k) for k, take in enumerate(takes(3))]
    still = [replace(t, channels=ChannelTrack((*CHANNELS, "tongueOut", "eyeBlinkLeft", "mouthLeft"), np.pad(
        t.channels.values, ((0, 0), (0, 3))) + np.eye(8)[5] + np.eye(8)[6], t.markers.rate)) for t in made]  # fmt: skip
    assert mouth_space_of(still).names == tuple(n for n in ("jawOpen", "mouthClose", "mouthPucker", *CHANNELS[3:]))
    assert mouth_space_of(made, "markers").names == NAMES
    bare = takes(4)[3]
    assert isinstance(mouth_space_of([*made, bare]), MarkerSpace)
    with pytest.raises(InputError, match="no captured channels"):
        mouth_space_of([*made, bare], "channels")


def test_frames_in_which_the_mouth_was_lost_are_not_learned():
    take = with_channels(takes(1)[0])
    positions = take.markers.positions.copy()
    positions[4:7, 2] = np.nan
    rows = ChannelSpace.of(CHANNELS).rows_of(replace(take, markers=MarkerTrack(NAMES, positions, take.markers.rate)))
    assert np.flatnonzero(np.isnan(rows).any(axis=1)).tolist() == [4, 5, 6]


def test_a_space_comes_back_from_what_a_file_holds_of_it():
    for space in (ChannelSpace.of(CHANNELS), MarkerSpace("mediapipe-218", NAMES)):
        again = space_from(space.content(), space.arrays())
        assert (again.kind, again.names, again.points) == (space.kind, space.names, space.points)
        rows = np.random.default_rng(0).standard_normal((3, len(space.emphasis())))
        assert np.array_equal(again.motion_of(rows), space.motion_of(rows))
        assert np.array_equal(again.opening_of(rows), space.opening_of(rows))
